//! Hashes that identify content, written as 64 hexadecimal digits.

use serde::{Deserialize, Deserializer, Serialize, Serializer, de};
use std::str::FromStr;

/// Error of parsing a hash.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("a hash must be 64 hexadecimal digits")]
pub struct HashError;

/// Declares the type of a BLAKE3 hash.
///
/// ```
/// brood_genome::content_hash! {
///     /// Identity of a note.
///     NoteHash
/// }
/// assert_eq!(NoteHash::from_bytes([10; 32]).to_string(), "0a".repeat(32));
/// ```
#[macro_export]
macro_rules! content_hash {
    ($(#[$about:meta])* $name:ident) => {
        $(#[$about])*
        #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
        pub struct $name([u8; 32]);

        impl $name {
            /// Returns the 32 bytes.
            #[must_use]
            pub fn as_bytes(&self) -> &[u8; 32] {
                &self.0
            }

            /// Creates a hash from its bytes.
            #[must_use]
            pub fn from_bytes(bytes: [u8; 32]) -> Self {
                Self(bytes)
            }
        }

        impl std::fmt::Display for $name {
            fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                self.0.iter().try_for_each(|byte| write!(f, "{byte:02x}"))
            }
        }
    };
}

/// Declares hashes that are computed here, and read from text and JSON.
macro_rules! hashes {
    ($($(#[$about:meta])* $name:ident;)*) => {$(
        content_hash! { $(#[$about])* $name }

        impl $name {
            /// Returns the hash of content.
            #[must_use]
            pub fn of(content: &[u8]) -> Self {
                Self(*blake3::hash(content).as_bytes())
            }
        }

        impl FromStr for $name {
            type Err = HashError;

            fn from_str(text: &str) -> Result<Self, HashError> {
                let hash = blake3::Hash::from_hex(text).map_err(|_| HashError)?;
                Ok(Self(*hash.as_bytes()))
            }
        }

        impl Serialize for $name {
            fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
                serializer.collect_str(self)
            }
        }

        impl<'de> Deserialize<'de> for $name {
            fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
                String::deserialize(deserializer)?.parse().map_err(de::Error::custom)
            }
        }
    )*};
}

hashes! {
    /// Identity of a genome: BLAKE3 hash of its canonical bytes. Hashes are equal exactly if all
    /// parts have the same bits; `==` of genomes does not distinguish constants 0 and -0.
    GenomeHash;
    /// Identity of a control image: BLAKE3 hash of its file.
    ImageHash;
}
