//! An object of a glTF's JSON that knows its own place, so that every error about it can name it.
//!
//! The JSON stays a tree of values instead of becoming typed tables: files in the wild leave out, misspell and add
//! properties, and a reader that asks for what it needs is stopped by nothing else.

use serde_json::{Map, Value};

use crate::FormatError;

/// The least power of two that `f64` cannot count past one by one.
const MAX_EXACT: f64 = 9_007_199_254_740_992.0;

/// An object of the JSON, and where it stands.
#[derive(Clone, Debug)]
pub(super) struct Item<'a> {
    pub(super) file: &'a str,
    /// For messages: `accessor 3`, `material 2 "wall", pbrMetallicRoughness`.
    pub(super) place: String,
    object: &'a Map<String, Value>,
}

impl<'a> Item<'a> {
    /// The object `value`, or an error if it is something else.
    pub(super) fn new(file: &'a str, place: String, value: &'a Value) -> Result<Self, FormatError> {
        match value.as_object() {
            Some(object) => Ok(Self { file, place, object }),
            None => Err(bad(file, place, "should be an object")),
        }
    }

    /// Like [`Item::new`], for an object that may have a name: it becomes part of the place.
    pub(super) fn named(file: &'a str, place: String, value: &'a Value) -> Result<Self, FormatError> {
        let mut item = Self::new(file, place, value)?;
        if let Some(name) = item.name() {
            item.place = format!("{} {:?}", item.place, crate::text::shortened(name));
        }
        Ok(item)
    }

    /// The object itself.
    pub(super) fn object(&self) -> &'a Map<String, Value> {
        self.object
    }

    /// The property `name`, if it is a text that is not empty.
    pub(super) fn name(&self) -> Option<&'a str> {
        self.object.get("name").and_then(Value::as_str).filter(|name| !name.is_empty())
    }

    /// An error about a property of this item.
    pub(super) fn bad(&self, key: &str, what: impl Into<String>) -> FormatError {
        bad(self.file, format!("{}, {key}", self.place), what)
    }

    /// A property, of whatever kind; null counts as absent.
    pub(super) fn get(&self, key: &str) -> Option<&'a Value> {
        self.object.get(key).filter(|value| !value.is_null())
    }

    /// A property as a JSON text, of whatever kind.
    pub(super) fn json(&self, key: &str) -> Option<String> {
        self.get(key).map(Value::to_string)
    }

    /// A count, an offset or an index. Whole numbers written as `3.0` are taken.
    pub(super) fn whole(&self, key: &str) -> Result<Option<usize>, FormatError> {
        self.get(key).map(|value| whole(value).ok_or_else(|| self.bad(key, "should be a whole number"))).transpose()
    }

    /// A whole number that must be there.
    pub(super) fn required_whole(&self, key: &str) -> Result<usize, FormatError> {
        self.whole(key)?.ok_or_else(|| self.bad(key, "is missing"))
    }

    /// A list of whole numbers; empty if absent.
    pub(super) fn wholes(&self, key: &str) -> Result<Vec<usize>, FormatError> {
        let numbers = self.list(key)?.iter().map(whole);
        numbers.map(|n| n.ok_or_else(|| self.bad(key, "should hold whole numbers only"))).collect()
    }

    /// A number.
    pub(super) fn number(&self, key: &str) -> Result<Option<f64>, FormatError> {
        self.get(key).map(|value| number(value).ok_or_else(|| self.bad(key, "should be a finite number"))).transpose()
    }

    /// A list of exactly `N` numbers.
    pub(super) fn numbers<const N: usize>(&self, key: &str) -> Result<Option<[f64; N]>, FormatError> {
        let Some(value) = self.get(key) else { return Ok(None) };
        let wrong = || self.bad(key, format!("should be {N} finite numbers"));
        let list = value.as_array().filter(|list| list.len() == N).ok_or_else(wrong)?;
        let mut numbers = [0.0; N];
        for (n, value) in numbers.iter_mut().zip(list) {
            *n = number(value).ok_or_else(wrong)?;
        }
        Ok(Some(numbers))
    }

    /// A text.
    pub(super) fn text(&self, key: &str) -> Result<Option<&'a str>, FormatError> {
        self.get(key).map(|value| value.as_str().ok_or_else(|| self.bad(key, "should be a text"))).transpose()
    }

    /// A truth value; false if absent.
    pub(super) fn flag(&self, key: &str) -> Result<bool, FormatError> {
        let flag = self.get(key).map(|value| value.as_bool().ok_or_else(|| self.bad(key, "should be true or false")));
        Ok(flag.transpose()?.unwrap_or(false))
    }

    /// A list; empty if absent.
    pub(super) fn list(&self, key: &str) -> Result<&'a [Value], FormatError> {
        let list = self.get(key).map(|value| value.as_array().ok_or_else(|| self.bad(key, "should be a list")));
        Ok(list.transpose()?.map_or(&[], Vec::as_slice))
    }

    /// An object within this one.
    pub(super) fn child(&self, key: &str) -> Result<Option<Self>, FormatError> {
        self.get(key).map(|value| Self::new(self.file, format!("{}, {key}", self.place), value)).transpose()
    }

    /// An extension's object.
    pub(super) fn extension(&self, name: &str) -> Result<Option<Self>, FormatError> {
        match self.child("extensions")? {
            Some(extensions) => extensions.child(name),
            None => Ok(None),
        }
    }

    /// The objects of a list within this one, called `noun` and their number.
    pub(super) fn children(
        &self,
        key: &str,
        noun: &'static str,
    ) -> Result<impl Iterator<Item = Result<Self, FormatError>> + use<'a>, FormatError> {
        let (file, place) = (self.file, self.place.clone());
        let list = self.list(key)?.iter().enumerate();
        Ok(list.map(move |(i, value)| Self::new(file, format!("{place}, {noun} {i}"), value)))
    }
}

fn bad(file: &str, place: String, what: impl Into<String>) -> FormatError {
    FormatError::BadProperty { file: file.to_owned(), place, what: what.into() }
}

fn whole(value: &Value) -> Option<usize> {
    let exact = value.as_f64().filter(|n| n.fract() == 0.0 && (0.0..MAX_EXACT).contains(n));
    value.as_u64().or(exact.map(|n| n as u64)).and_then(|n| usize::try_from(n).ok())
}

fn number(value: &Value) -> Option<f64> {
    value.as_f64().filter(|n| n.is_finite())
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    #[test]
    fn properties_are_read_with_tolerance_and_errors_name_the_place() {
        let value = json!({"count": 3.0, "half": 0.5, "color": [1, 2.5, 3], "name": "x", "gone": null, "on": 1});
        let item = Item::named("a.gltf", "accessor 7".into(), &value).unwrap();
        assert_eq!(item.whole("count").unwrap(), Some(3));
        assert_eq!(item.whole("gone").unwrap(), None);
        assert_eq!(item.numbers::<3>("color").unwrap(), Some([1.0, 2.5, 3.0]));
        for error in [item.whole("half").unwrap_err(), item.numbers::<4>("color").unwrap_err()] {
            assert!(error.to_string().starts_with("a.gltf: accessor 7 \"x\", "), "{error}");
        }
        assert!(item.flag("on").is_err() && item.required_whole("none").is_err() && item.list("half").is_err());
    }

    #[test]
    fn numbers_that_are_too_large_are_no_whole_numbers() {
        for value in [json!({"count": 1e300}), json!({"count": -1}), json!({"count": "3"})] {
            assert!(Item::new("a", "b".into(), &value).unwrap().whole("count").is_err());
        }
    }
}
