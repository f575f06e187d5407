//! Fits of the models of reflectance that everybody knows: one of them, or the sum of two, by their own parameters.
//!
//! Which models there are, and which words their parameters have, is a [`Form`]; the numbers that are free in it are coordinates
//! in a box, by differences or by ratios as the parameter is spread. Levenberg's and Marquardt's method finds them from many
//! starts, an evolution strategy goes on where it sticks. docs/maths/fit.md says why.

mod albedo;
mod batch;
mod checkpoint;
mod climb;
mod coordinate;
mod evolve;
mod form;
mod recover;
mod residual;
mod schedule;
mod vary;

pub use form::{Form, LobeForm};
pub use recover::{Recovered, Recovery};
pub use schedule::{Analytic, usual_kinds};
