//! Fits of well-known reflectance models, one or the sum of two, by their own parameters.
//!
//! A [`Form`] says which models are summed, the values of their choice parameters (those that are
//! one of a few words), and if highlights may be anisotropic. Its free parameters are coordinates
//! in a box, linear or logarithmic according to the parameter's scale. The Levenberg-Marquardt
//! method optimises them from many starts, and now and then an evolution strategy, which needs no
//! derivatives. docs/maths/fit.md explains the design.
//!
//! `schedule` runs the generations of a search over forms. `vary` makes its starting points,
//! `refine` and `evolve` optimise, `residual` evaluates models and their derivatives on samples,
//! `albedo` has the quadratures of directional albedos, `prior` the probability of parameters.
//! `recover` fits one given form, `posterior` draws materials that match the samples as well as
//! the best.

mod albedo;
mod batch;
mod checkpoint;
mod coordinate;
mod evolve;
mod form;
mod kept;
mod posterior;
mod prior;
mod recover;
mod refine;
mod residual;
mod schedule;
mod vary;

pub use form::{Form, LobeForm};
pub(crate) use posterior::OPEN_INDEPENDENT;
pub use prior::PriorMaterials;
pub use recover::{Recovered, Recovery};
pub(crate) use residual::{ROW, Space, Workspace};
pub use schedule::{Analytic, default_kinds};
pub(crate) use schedule::{EQUAL, INDEPENDENT};

/// Number of samples per block.
pub(crate) const LANES: usize = 64;
