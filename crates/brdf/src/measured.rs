//! Measured materials: tables of reflectance, read from bytes and looked up for any pair of directions.
//!
//! It refuses to know files and pictures: whoever has the bytes of one, or the pixels, hands them over.

mod angle;
mod merl;
mod slice;

pub use merl::{Merl, MerlError};
pub use slice::{Slice, SliceError};
