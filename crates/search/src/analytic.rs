//! Fits of well-known reflectance models, one or the sum of two, by their own parameters.
//!
//! A [`Form`] says which models are summed and which choices their parameters have. Its free
//! parameters are coordinates in a box, linear or logarithmic according to the parameter's scale.
//! The Levenberg-Marquardt method optimises them from many starts; an evolution strategy takes over
//! where it gets stuck. docs/maths/fit.md explains the design.

mod albedo;
mod batch;
mod checkpoint;
mod coordinate;
mod evolve;
mod form;
mod recover;
mod refine;
mod residual;
mod schedule;
mod vary;

pub use form::{Form, LobeForm};
pub use recover::{Recovered, Recovery};
pub use schedule::{Analytic, default_kinds};
