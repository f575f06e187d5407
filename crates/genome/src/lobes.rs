//! A family of smooth functions that becomes a short program: sums of exponentials of quantities
//! that do not change when `wi` and `wo` are exchanged. docs/maths/fit.md explains it.
//!
//! Searches fit its parameters to samples; [`believable`](crate::believable) draws them.

mod program;
mod shape;

pub(crate) use program::Code;
pub use program::LobesError;
pub use shape::Shape;
