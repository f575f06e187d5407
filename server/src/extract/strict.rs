//! Checks that serde lacks: duplicate keys, nesting depth and U+0000 in text. Errors have a JSON
//! pointer.
//!
//! Walks the document once before it is parsed into a type. serde_json's own depth limit of 128 is
//! fixed, and serde reports duplicate keys of structs only, not of maps.

use std::collections::HashSet;
use std::fmt;

use serde::de::{self, DeserializeSeed, MapAccess, SeqAccess, Visitor};
use serde_path_to_error::{Path, Segment, Track};

use crate::limit;
use crate::problem::{ApiError, quote, serde_words};

/// Checks a document for duplicate keys, nesting depth, U+0000 in text, and syntax.
///
/// # Errors
/// 400 with a pointer to the error.
pub fn check(bytes: &[u8]) -> Result<(), ApiError> {
    let mut track = Track::new();
    let mut json = serde_json::Deserializer::from_slice(bytes);
    let tracked = serde_path_to_error::Deserializer::new(&mut json, &mut track);
    let walked = Value { depth: 0 }.deserialize(tracked).and_then(|()| json.end());
    walked.map_err(|error| located(&error.to_string(), &error).at(pointer(&track.path())))
}

/// Returns a path as a JSON pointer.
pub fn pointer(path: &Path) -> String {
    let step = |segment: &Segment| match segment {
        Segment::Seq { index } => format!("/{index}"),
        Segment::Map { key } => format!("/{}", pointer_step(key)),
        Segment::Enum { .. } | Segment::Unknown => String::new(),
    };
    path.iter().map(step).collect()
}

/// Returns one step of a JSON pointer, escaped as in RFC 6901 and shortened by [`quote`].
pub fn pointer_step(key: &str) -> String {
    quote(key).replace('~', "~0").replace('/', "~1")
}

/// Converts the message of a serde error, with the error's line and column if it has them.
pub fn located(message: &str, error: &serde_json::Error) -> ApiError {
    let words = ApiError::bad_json(serde_words(message));
    let place = |n: usize| u32::try_from(n).unwrap_or(u32::MAX);
    if error.line() == 0 {
        return words;
    }
    words.at_line(place(error.line()), Some(place(error.column())))
}

/// Any JSON value at a depth.
#[derive(Clone, Copy)]
struct Value {
    depth: usize,
}

impl Value {
    fn inner<E: de::Error>(self) -> Result<Self, E> {
        if self.depth >= limit::JSON_DEPTH {
            return Err(E::custom(format_args!("nested deeper than {} levels", limit::JSON_DEPTH)));
        }
        Ok(Self { depth: self.depth + 1 })
    }
}

/// Value of a duplicate key: an error whose path includes the key.
struct Duplicate;

impl<'de> DeserializeSeed<'de> for Duplicate {
    type Value = ();

    fn deserialize<D: de::Deserializer<'de>>(self, _: D) -> Result<(), D::Error> {
        Err(de::Error::custom("the key occurs twice"))
    }
}

impl<'de> DeserializeSeed<'de> for Value {
    type Value = ();

    fn deserialize<D: de::Deserializer<'de>>(self, deserializer: D) -> Result<(), D::Error> {
        deserializer.deserialize_any(self)
    }
}

impl<'de> Visitor<'de> for Value {
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

    fn visit_str<E: de::Error>(self, text: &str) -> Result<(), E> {
        if text.contains('\0') {
            // PostgreSQL cannot store it.
            return Err(E::custom("text must not contain the character U+0000"));
        }
        Ok(())
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut seq: A) -> Result<(), A::Error> {
        let inner = self.inner()?;
        while seq.next_element_seed(inner)?.is_some() {}
        Ok(())
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<(), A::Error> {
        let inner = self.inner()?;
        let mut keys = HashSet::new();
        while let Some(key) = map.next_key::<String>()? {
            match keys.insert(key) {
                true => map.next_value_seed(inner)?,
                false => map.next_value_seed(Duplicate)?,
            }
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
    fn check_accepts_valid_json() {
        check(br#"{"a": [1, -2.5, "x", null, {"b": true}], "c": {}}"#).unwrap();
    }

    #[test]
    fn check_points_at_the_error() {
        assert_eq!(pointer(r#"{"a": {"b": 1, "b": 2}}"#).0, "/a/b");
        assert_eq!(pointer(r#"{"a": [0, 1e999]}"#).0, "/a/1");
        assert_eq!(pointer(r#"{"a": [0, NaN]}"#).0, "/a/1");
        assert_eq!(pointer(r#"{"a": [0, "b\u0000"]}"#).0, "/a/1");
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
    fn check_shortens_long_keys() {
        let key = "k".repeat(10_000);
        let (pointer, _) = pointer(&format!("{{\"{key}\": NaN}}"));
        assert!(pointer.len() < 70);
    }
}
