//! Contexts: a current vertex, colour and material, each perhaps with a name under which it is kept.
//!
//! `v` alone is an unnamed one, as new; `v a` makes a named one current again; `v a =` makes a new one of that name, and
//! `v a = b` one that begins as a copy. What is then said of the current one is kept under its name.

use std::collections::BTreeMap;

use crate::FormatError;
use crate::text::{Place, shortened};

/// The current one of a kind, and all that have names.
#[derive(Debug)]
pub(super) struct Context<T> {
    /// What messages call it.
    noun: &'static str,
    named: BTreeMap<String, T>,
    unnamed: T,
    current: Option<String>,
}

impl<T: Clone + Default> Context<T> {
    /// None with a name, and an unnamed one that is new.
    pub(super) fn new(noun: &'static str) -> Self {
        Self { noun, named: BTreeMap::new(), unnamed: T::default(), current: None }
    }

    /// What a statement that gets or sets the context does.
    pub(super) fn select(&mut self, place: Place<'_>, words: &[&str]) -> Result<(), FormatError> {
        match *words {
            [] => (self.current, self.unnamed) = (None, T::default()),
            [name] => {
                self.get(place, name)?;
                self.current = Some(name.to_owned());
            }
            [name, "="] => self.set(name, T::default()),
            [name, "=", template] => {
                let copy = self.get(place, template)?.clone();
                self.set(name, copy);
            }
            _ => {
                let what = format!("a {} is a name, perhaps an = and perhaps another name", self.noun);
                return Err(place.bad(what, "repair the line"));
            }
        }
        Ok(())
    }

    fn set(&mut self, name: &str, value: T) {
        self.named.insert(name.to_owned(), value);
        self.current = Some(name.to_owned());
    }

    /// The one of a name.
    pub(super) fn get(&self, place: Place<'_>, name: &str) -> Result<&T, FormatError> {
        self.named.get(name).ok_or_else(|| {
            let what = format!("there is no {} {:?} yet", self.noun, shortened(name));
            place.bad(what, "define it before, with a name and =")
        })
    }

    /// The current one.
    pub(super) fn current(&self) -> &T {
        self.current.as_ref().and_then(|name| self.named.get(name)).unwrap_or(&self.unnamed)
    }

    /// The current one, to change.
    pub(super) fn current_mut(&mut self) -> &mut T {
        match self.current.as_ref().and_then(|name| self.named.get_mut(name)) {
            Some(named) => named,
            None => &mut self.unnamed,
        }
    }

    /// Its name.
    pub(super) fn current_name(&self) -> Option<&str> {
        self.current.as_deref()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const PLACE: Place<'static> = Place { file: "a.mgf", line: 3 };

    #[test]
    fn names_keep_what_is_said() {
        let mut c = Context::<i32>::new("colour");
        c.select(PLACE, &["a", "="]).unwrap();
        *c.current_mut() = 5;
        c.select(PLACE, &["b", "=", "a"]).unwrap();
        *c.current_mut() += 1;
        c.select(PLACE, &[]).unwrap();
        *c.current_mut() = 9;
        assert_eq!((*c.get(PLACE, "a").unwrap(), *c.get(PLACE, "b").unwrap(), c.current_name()), (5, 6, None));
        c.select(PLACE, &["a"]).unwrap();
        assert_eq!((*c.current(), c.current_name()), (5, Some("a")));
        c.select(PLACE, &["a", "="]).unwrap();
        c.select(PLACE, &[]).unwrap();
        assert_eq!((*c.get(PLACE, "a").unwrap(), *c.current()), (0, 0));
    }

    #[test]
    fn what_is_not_there_is_named() {
        let mut c = Context::<i32>::new("colour");
        for words in [&["x"][..], &["a", "=", "x"]] {
            let message = c.select(PLACE, words).unwrap_err().to_string();
            assert!(message.starts_with("a.mgf: line 3: there is no colour \"x\""), "{message}");
        }
        assert!(c.select(PLACE, &["a", "b"]).is_err() && c.select(PLACE, &["a", "=", "b", "c"]).is_err());
    }
}
