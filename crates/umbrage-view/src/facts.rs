//! What is told of a point that was picked, and of the file.

use glam::DVec3;
use umbrage_cli::look::Unit;
use umbrage_picture::color::luminance;

use crate::load::Loaded;
use crate::marks::{Mark, Marker, cross};
use crate::pick::{Hit, light};
use crate::provenance::provenance;

/// A name and a value, ready to be read.
pub(crate) type Fact = [String; 2];

/// What a baked file alone cannot tell.
pub(crate) const NOT_IN_FILE: &str =
    "A baked file does not hold shadow edges, patches and faces. Open the scene that it was baked from to see them.";

/// A point that was picked.
pub(crate) struct Picked {
    pub(crate) facts: Vec<Fact>,
    /// The point, the patch there and the d-segment that cut it.
    pub(crate) marks: Vec<Mark>,
}

/// What is known of a point, irradiance in `unit`.
pub(crate) fn picked(loaded: &Loaded, hit: &Hit, unit: Unit) -> Picked {
    let part = &loaded.shown.file.parts[hit.part];
    let light = light(&loaded.shown.file, hit);
    let quantity = |value: [f64; 3]| {
        let [r, g, b] = value.map(|channel| short(channel * unit.per_file_unit()));
        let mean = short(f64::from(luminance(value.map(|channel| channel as f32))) * unit.per_file_unit());
        format!("{mean} {}  ({r} {g} {b})", unit_name(unit))
    };
    let mut facts = vec![fact("position", metres(hit.point_m)), fact("normal", metres(hit.normal))];
    for (name, value) in [("node", &part.node_name), ("material", &part.material_name)] {
        if !value.is_empty() {
            facts.push(fact(name, value.clone()));
        }
    }
    facts.push(fact("irradiance", quantity(light.irradiance)));
    facts.push(fact("radiosity", quantity(light.radiosity)));
    let origin_m = loaded.tables.origin_m;
    let mut marks: Vec<Mark> = cross(hit.point_m - origin_m, hit.normal, loaded.tables.size_m()).into();
    let Some(baked) = &loaded.baked else { return Picked { facts, marks } };
    let Some(found) = provenance(&baked.scene, &baked.meshed, hit.point_m, hit.normal) else {
        facts.push(fact("face", "none is here: the point is on an edge".into()));
        return Picked { facts, marks };
    };
    facts.push(fact("face", found.face.index().to_string()));
    let patch = format!("{}, level {}, {} m²", found.patch.index(), found.level, short(found.area_m2));
    facts.push(fact("patch", patch));
    facts.push(fact("cut by", found.cut.unwrap_or_else(|| "nothing: it is the whole face".into())));
    facts.extend(found.event.map(|event| fact("event", event)));
    marks.extend(Marker { meshed: &baked.meshed, origin_m }.picked(found.patch, found.hint));
    Picked { facts, marks }
}

/// What a unit is called on a screen that has all letters.
pub(crate) fn unit_name(unit: Unit) -> &'static str {
    if unit == Unit::W { "W/m²" } else { unit.name() }
}

/// What is worth knowing of what is open.
pub(crate) fn about(loaded: &Loaded) -> Vec<Fact> {
    let file = &loaded.shown.file;
    let mut facts =
        vec![fact("triangles", file.triangle_count().to_string()), fact("vertices", file.vertex_count().to_string())];
    if let Some(baked) = &loaded.baked {
        let report = &baked.report;
        let [d0, d1, d2] = report.d_segments;
        facts.push(fact("faces", report.faces.to_string()));
        facts.push(fact("d-segments", format!("{d0} D0, {d1} D1, {d2} D2")));
        facts.push(fact("patches", report.patches.to_string()));
        facts.push(fact("links", format!("{}, {:.1} for each leaf", report.links, report.links_a_leaf())));
        facts.push(fact("error", format!("{:.2} % of the mean, between vertices, estimated", 100.0 * report.error)));
        facts.push(fact("baked in", format!("{:.1} s", loaded.took.as_secs_f64())));
    } else if let Some(error) = file.extras.get("error").and_then(serde_json::Value::as_f64) {
        facts.push(fact("error", format!("{:.2} % of the mean, between vertices, estimated", 100.0 * error)));
    }
    let radiance = if file.photometric { "cd/m²" } else { "W/(m² sr)" };
    facts.push(fact("exposure", format!("{} per {radiance}", short(file.exposure_k))));
    facts
}

fn fact(name: &str, value: String) -> Fact {
    [name.to_owned(), value]
}

fn metres(point: DVec3) -> String {
    // Adding 0 makes -0 to 0.
    point.to_array().map(|x| format!("{:.3}", (1e3 * x).round() / 1e3 + 0.0)).join(" ")
}

/// A number to four digits.
fn short(x: f64) -> String {
    let size = x.abs();
    if size == 0.0 || !(1e-3..1e6).contains(&size) {
        return if size == 0.0 { "0".into() } else { format!("{x:.2e}") };
    }
    let decimals = (3 - size.log10().floor() as i64).clamp(0, 6) as usize;
    format!("{x:.decimals$}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_told_to_four_digits() {
        let told = [0.0, 0.012345, 1.0, 12.3456, 4567.8, 1e-7, 2.5e6, -0.5].map(short);
        assert_eq!(told, ["0", "0.01235", "1.000", "12.35", "4568", "1.00e-7", "2.50e6", "-0.5000"]);
    }

    #[test]
    fn a_point_is_told_to_the_millimetre_and_never_as_minus_nothing() {
        assert_eq!(metres(DVec3::new(1.23456, -0.00001, -2.0)), "1.235 0.000 -2.000");
    }
}
