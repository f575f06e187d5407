//! Comparison of materials, for the command line and the API: curves over the angle of incidence,
//! numbers for physical phenomena, exposures over the light orbit, differences between pictures.

mod curve;
mod difference;
mod exposure;
mod exposures;
mod flip;
mod itp;
mod phenomena;
mod similarity;
mod specimen;

pub use curve::{CurvePoint, curves, luminance};
pub use difference::{HdrFlip, LinearImage, LinearImageError, flip};
pub use exposure::LightOrbit;
pub use exposures::Exposures;
pub use phenomena::Phenomena;
pub use specimen::Specimen;

use std::ops::RangeInclusive;

/// Number of materials in a comparison. More do not fit on the page and are indistinguishable in a
/// chart.
pub const COMPARED: RangeInclusive<usize> = 2..=6;
/// Angle from the scene's light to the second light of a comparison, along the light orbit, in
/// degrees.
pub const OTHER_LIGHT_DEG: f64 = 60.0;
