//! What serde lets pass or says without a place: duplicate keys, nesting, and where a syntax error is.
//!
//! One walk over the document before it is read into a type, keeping the JSON pointer as it goes.

use std::collections::HashSet;
use std::fmt;

use serde::de::{self, DeserializeSeed, MapAccess, SeqAccess, Visitor};

use crate::limit;
use crate::problem::{ApiError, quote};

use super::json::syntax_error;

/// Refuses a document with duplicate keys, too deep nesting, or no JSON at all.
pub fn check(bytes: &[u8]) -> Result<(), ApiError> {
    let mut walk = Walk { path: Vec::new() };
    let mut deserializer = serde_json::Deserializer::from_slice(bytes);
    let result = Value(&mut walk).deserialize(&mut deserializer).and_then(|()| deserializer.end());
    result.map_err(|error| syntax_error(&error).at(walk.pointer()))
}

/// One step of a JSON pointer, escaped as the RFC has it and cut to a bearable length.
pub fn pointer_step(key: &str) -> String {
    quote(key).replace('~', "~0").replace('/', "~1")
}

struct Walk {
    path: Vec<Step>,
}

enum Step {
    Key(String),
    Index(usize),
}

impl Walk {
    fn pointer(&self) -> String {
        self.path
            .iter()
            .map(|step| match step {
                Step::Key(key) => format!("/{}", pointer_step(key)),
                Step::Index(index) => format!("/{index}"),
            })
            .collect()
    }

    fn enter<E: de::Error>(&self) -> Result<(), E> {
        if self.path.len() >= limit::JSON_DEPTH {
            return Err(E::custom(format_args!("nested deeper than {} levels", limit::JSON_DEPTH)));
        }
        Ok(())
    }
}

struct Value<'a>(&'a mut Walk);

impl<'de> DeserializeSeed<'de> for Value<'_> {
    type Value = ();

    fn deserialize<D: de::Deserializer<'de>>(self, deserializer: D) -> Result<(), D::Error> {
        deserializer.deserialize_any(self)
    }
}

impl<'de> Visitor<'de> for Value<'_> {
    type Value = ();

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a JSON value")
    }

    fn visit_unit<E>(self) -> Result<(), E> {
        Ok(())
    }

    fn visit_bool<E>(self, _: bool) -> Result<(), E> {
        Ok(())
    }

    fn visit_i64<E>(self, _: i64) -> Result<(), E> {
        Ok(())
    }

    fn visit_u64<E>(self, _: u64) -> Result<(), E> {
        Ok(())
    }

    fn visit_f64<E>(self, _: f64) -> Result<(), E> {
        Ok(())
    }

    fn visit_str<E>(self, _: &str) -> Result<(), E> {
        Ok(())
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut seq: A) -> Result<(), A::Error> {
        self.0.enter()?;
        let mut index = 0;
        loop {
            self.0.path.push(Step::Index(index));
            if seq.next_element_seed(Value(self.0))?.is_none() {
                break;
            }
            self.0.path.pop();
            index += 1;
        }
        self.0.path.pop();
        Ok(())
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<(), A::Error> {
        self.0.enter()?;
        let mut keys = HashSet::new();
        while let Some(key) = map.next_key::<String>()? {
            self.0.path.push(Step::Key(key.clone()));
            if !keys.insert(key) {
                return Err(de::Error::custom("the key is there twice"));
            }
            map.next_value_seed(Value(self.0))?;
            self.0.path.pop();
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pointer(text: &str) -> (String, String) {
        let error = check(text.as_bytes()).unwrap_err();
        assert_eq!(error.status(), 400);
        let problem = error.problem();
        (problem.pointer.clone().unwrap(), problem.detail.clone())
    }

    #[test]
    fn check_takes_json() {
        check(br#"{"a": [1, -2.5, "x", null, {"b": true}], "c": {}}"#).unwrap();
    }

    #[test]
    fn check_points_at_the_place() {
        assert_eq!(pointer(r#"{"a": {"b": 1, "b": 2}}"#).0, "/a/b");
        assert_eq!(pointer(r#"{"a": [0, 1e999]}"#).0, "/a/1");
        assert_eq!(pointer(r#"{"a": [0, NaN]}"#).0, "/a/1");
        assert_eq!(pointer(r#"{"a/b~": NaN}"#).0, "/a~1b~0");
        assert_eq!(pointer("{").0, "");
        assert_eq!(pointer("1 2").0, "");
        assert_eq!(pointer("").0, "");
    }

    #[test]
    fn check_refuses_when_nested_deeper_than_the_limit() {
        let nest = |n: usize| "[".repeat(n) + &"]".repeat(n);
        check(nest(64).as_bytes()).unwrap();
        assert!(pointer(&nest(65)).1.contains("64"));
        pointer(&nest(100_000));
    }

    #[test]
    fn check_repeats_little_of_long_keys() {
        let key = "k".repeat(10_000);
        let (pointer, _) = pointer(&format!("{{\"{key}\": NaN}}"));
        assert!(pointer.len() < 70);
    }
}
