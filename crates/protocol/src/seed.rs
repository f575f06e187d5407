//! Seeds: u64, serialised as JSON numbers. Decimal strings are accepted as well, because JavaScript
//! loses integers above 2^53.

use serde::{Deserialize, Deserializer, Serialize, de};

/// Seed of a random stream: an integer from 0 to 18446744073709551615, given as a number or as a
/// decimal string.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, utoipa::ToSchema)]
#[schema(value_type = u64)]
#[serde(transparent)]
pub struct Seed(pub u64);

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
