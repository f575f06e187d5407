//! Seeds: u64, serialised as JSON numbers. Decimal strings are accepted as well, because JavaScript
//! loses integers above 2^53.

use std::io;

use serde::{Deserialize, Deserializer, Serialize, de};

use utoipa::openapi::RefOr;
use utoipa::openapi::schema::{ObjectBuilder, Schema, Type};
use utoipa::{PartialSchema, ToSchema};

use crate::random::random_bytes;

/// Seed of a random stream: an integer from 0 to 18446744073709551615, given as a number or as a
/// decimal string.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize)]
#[serde(transparent)]
pub struct Seed(pub u64);

// Without the format `int64`, which has a sign.
impl PartialSchema for Seed {
    fn schema() -> RefOr<Schema> {
        let words = "Seed of a random stream: an integer from 0 to 18446744073709551615, given as a number or as \
                     a decimal string.";
        let integer = ObjectBuilder::new().schema_type(Type::Integer).description(Some(words));
        integer.minimum(Some(0)).maximum(Some(usize::MAX)).into()
    }
}

impl ToSchema for Seed {}

impl Seed {
    /// Draws a random seed below 2^53, which JavaScript represents exactly.
    ///
    /// # Errors
    /// [`io::Error`] if the system has no random bytes.
    pub fn draw() -> io::Result<Self> {
        Ok(Self(u64::from_le_bytes(random_bytes()?) >> 11))
    }
}

impl<'de> Deserialize<'de> for Seed {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Visitor;

        impl de::Visitor<'_> for Visitor {
            type Value = Seed;

            fn expecting(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                f.write_str(
                    "a whole number from 0 to 18446744073709551615, as a number or a string",
                )
            }

            fn visit_u64<E: de::Error>(self, value: u64) -> Result<Seed, E> {
                Ok(Seed(value))
            }

            fn visit_i64<E: de::Error>(self, value: i64) -> Result<Seed, E> {
                u64::try_from(value).map(Seed).map_err(|_| E::custom("a seed must not be negative"))
            }

            fn visit_str<E: de::Error>(self, text: &str) -> Result<Seed, E> {
                let digits = !text.is_empty() && text.bytes().all(|b| b.is_ascii_digit());
                text.parse().ok().filter(|_| digits).map(Seed).ok_or_else(|| {
                    E::custom("a seed must be decimal digits, at most 18446744073709551615")
                })
            }
        }

        deserializer.deserialize_any(Visitor)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn drawn_seeds_are_below_2_to_the_53() {
        for _ in 0..100 {
            assert!(Seed::draw().unwrap().0 < 1 << 53);
        }
    }
}
