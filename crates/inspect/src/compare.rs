//! Materials side by side: what is shown of each, and how far they are apart. The same on the command line and over HTTP.
//!
//! Owns the figures: curves over the angle of incidence, phenomena in numbers, the common exposure, differences of pictures. It
//! refuses to know who renders the pictures and where they are shown.

mod curve;
mod difference;
mod exposure;
mod phenomena;
mod similarity;
mod specimen;

pub use curve::{CurvePoint, curves, luminance};
pub use difference::{LinearImage, LinearImageError};
pub use exposure::LightCircle;
pub use phenomena::Phenomena;
pub use specimen::Specimen;

use std::ops::RangeInclusive;

/// How many materials are compared: more would neither fit beside each other nor be told apart in a chart.
pub const COMPARED: RangeInclusive<usize> = 2..=6;
/// The other light: this much further along the light circle, in degrees.
pub const OTHER_LIGHT_DEG: f64 = 60.0;
