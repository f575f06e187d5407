//! Sample set: the batch of shading samples that every evaluator takes.
//!
//! Owns the direction pairs, the program inputs computed from them on first use, the irradiance of
//! each sample, and the mapping from samples to pixels. Independent of programs and colours.

#[cfg(test)]
mod adaptive_tests;
mod clear;
mod cluster;
mod fixed;
mod frame;
mod images;
mod layout;
mod light_terms;
#[cfg(test)]
mod light_terms_tests;
#[cfg(test)]
mod light_tests;
mod lit_angles;
mod normal_map;
mod paint;
mod paint_point;
#[cfg(test)]
mod paint_tests;
mod pick;
mod point;
mod points;
mod quadrature;
mod ray_ends;
mod rays;
mod render;
mod sampling;
mod seen_point;
mod select;
mod set;
#[cfg(test)]
mod shape_tests;
mod size;
#[cfg(test)]
mod tests;
mod values;
mod view;

pub use clear::WayOut;
pub use frame::above_horizon;
pub use layout::{ImageLayout, PixelRun, PixelSpan, SampleCounts};
pub use light_terms::{LightTerms, PixelTerms};
pub use lit_angles::{LitAngles, Toggles};
pub use ray_ends::{PixelRays, RayEnd, RayEnds};
pub use rays::Seen;
pub use sampling::{PixelArea, PixelAreaError, Raster, Sampling, SamplingError};
pub use seen_point::LeavingRay;
pub use set::SampleSet;
pub use size::{PictureSize, PictureSizeError};
pub(crate) use view::{View, looking_at};
