//! JSON with a record per line, for `diff`: fields in the order in which they are written, numbers rounded so that they
//! do not change with the last bit of a calculation.

use glam::DVec3;
use serde_json::Value;

/// Lengths are rounded to this share of the extent of the scene: well below what `f32` vertices resolve.
const LENGTH_STEP_OF_EXTENT: f64 = 1e-8;
/// Digits of quantities that are no lengths.
const DIGITS: usize = 5;

/// How numbers of one scene are written.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Rounding {
    /// Decimals of lengths in metres.
    decimals: usize,
}

impl Rounding {
    pub(crate) fn of_extent(extent_m: f64) -> Self {
        let step_m = LENGTH_STEP_OF_EXTENT * extent_m;
        let decimals = if step_m > 0.0 { (-step_m.log10().floor()).clamp(0.0, 15.0) as usize } else { 9 };
        Self { decimals }
    }

    fn length(self, x_m: f64) -> String {
        shortest(&format!("{x_m:.*}", self.decimals))
    }

    /// A point, in metres.
    pub(crate) fn point(self, p_m: DVec3) -> String {
        list(p_m.to_array().map(|x_m| self.length(x_m)))
    }

    /// Points, in metres.
    pub(crate) fn points(self, points_m: impl IntoIterator<Item = DVec3>) -> String {
        list(points_m.into_iter().map(|p_m| self.point(p_m)))
    }
}

/// A quantity that is no length.
pub(crate) fn quantity(x: f64) -> String {
    // The number as it is read back from its digits: Display then writes the fewest.
    let rounded: f64 = format!("{x:.*e}", DIGITS - 1).parse().unwrap_or(x);
    if rounded.is_finite() { rounded.to_string() } else { "null".into() }
}

/// Without zeros at the end of the decimals.
fn shortest(number: &str) -> String {
    let short = if number.contains('.') { number.trim_end_matches('0').trim_end_matches('.') } else { number };
    if short == "-0" { "0".into() } else { short.into() }
}

/// A list of values that are JSON already.
pub(crate) fn list(values: impl IntoIterator<Item = String>) -> String {
    format!("[{}]", values.into_iter().collect::<Vec<_>>().join(","))
}

/// A list of ids.
pub(crate) fn ids(ids: impl IntoIterator<Item = usize>) -> String {
    list(ids.into_iter().map(|id| id.to_string()))
}

/// A text.
pub(crate) fn text(text: &str) -> String {
    Value::from(text).to_string()
}

/// An object on one line, of values that are JSON already.
#[derive(Clone, Debug, Default)]
pub(crate) struct Record(String);

impl Record {
    pub(crate) fn with(mut self, name: &str, value: impl AsRef<str>) -> Self {
        let comma = if self.0.is_empty() { "" } else { "," };
        self.0 += &format!("{comma}\"{name}\":{}", value.as_ref());
        self
    }

    pub(crate) fn end(self) -> String {
        format!("{{{}}}", self.0)
    }
}

/// A document: some fields, then tables of records.
#[derive(Clone, Debug)]
pub(crate) struct Document(String);

impl Document {
    pub(crate) fn of_stage(stage: &str, scene: &str) -> Self {
        let head = [("format", text("umbrage-inspect")), ("version", "1".into()), ("stage", text(stage))];
        let mut document = Self("{".into());
        for (name, value) in head.into_iter().chain([("scene", text(scene))]) {
            document = document.with(name, &value);
        }
        document
    }

    fn with(mut self, name: &str, value: &str) -> Self {
        let comma = if self.0.len() == 1 { "" } else { "," };
        self.0 += &format!("{comma}\n\"{name}\": {value}");
        self
    }

    pub(crate) fn table(self, name: &str, records: impl IntoIterator<Item = Record>) -> Self {
        let rows: Vec<String> = records.into_iter().map(Record::end).collect();
        let value = if rows.is_empty() { "[]".into() } else { format!("[\n{}\n]", rows.join(",\n")) };
        self.with(name, &value)
    }

    pub(crate) fn end(self) -> String {
        self.0 + "\n}\n"
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lengths_are_rounded_with_the_scene_and_written_short() {
        let rounding = Rounding::of_extent(6.0);
        assert_eq!(rounding.point(DVec3::new(0.1 + 0.2, -1e-12, 2.5)), "[0.3,0,2.5]");
        assert_eq!(Rounding::of_extent(6000.0).point(DVec3::new(1_234.567_891, 0.0, 100.0)), "[1234.56789,0,100]");
    }

    #[test]
    fn quantities_keep_five_digits() {
        assert_eq!([0.123_456_7, 12_345_678.0, 0.0, f64::NAN].map(quantity), ["0.12346", "12346000", "0", "null"]);
    }

    #[test]
    fn a_document_is_json_with_a_record_a_line() {
        let record = |i: usize| Record::default().with("id", i.to_string()).with("name", text("a \"b\""));
        let text = Document::of_stage("mesh", "x").table("rows", (0..2).map(record)).table("none", []).end();
        let value: Value = serde_json::from_str(&text).unwrap();
        assert_eq!(value["rows"][1]["name"], "a \"b\"");
        assert_eq!(value["none"].as_array().map(Vec::len), Some(0));
        assert_eq!(text.lines().count(), 1 + 4 + 1 + 2 + 1 + 1 + 1);
    }
}
