//! Photometric profiles: how strongly a luminaire shines in each direction, from the bytes of an IES file (LM-63).
//!
//! Owns the format, what is told of a direction that was not measured, and the flux of the whole. Knows no scene and reads
//! no files: bytes come in, and what is malformed is refused with its line.

mod error;
mod integral;
mod profile;
mod reader;
#[cfg(test)]
mod tests;

pub use error::{IesError, IesErrorKind};
pub use profile::{IesProfile, Photometry};
