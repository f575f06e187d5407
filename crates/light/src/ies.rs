//! Photometric profiles: luminous intensity of a luminaire per direction, from an IES file (LM-63).
//!
//! Owns the file format, the interpolation between measured directions and the total flux. Takes
//! bytes and opens no files; malformed input is rejected with its line.

mod error;
mod integral;
mod profile;
mod reader;
#[cfg(test)]
mod tests;

pub use error::{IesError, IesErrorKind};
pub use profile::{IesProfile, Photometry};
