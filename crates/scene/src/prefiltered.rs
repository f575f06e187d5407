//! Light from environments, integrated over nodes instead of samples.
//!
//! Seen from one direction, an isotropic homogeneous material is a function of the half vector.
//! [`LobeNodes`] holds nodes of half vectors, dense near the normal, for a number of angles to the
//! eye. [`LobeTable`] holds a material at the nodes. [`PrefilteredLight`] computes the mean
//! radiance of the environments around the nodes of each surface point. Reflected radiance is the
//! sum of their products: it has no noise, and its cost does not depend on the material. Where a
//! picture is smooth, pixels between points take means of their radiances ([`PixelBetween`]).
//!
//! # Source
//! Křivánek and Colbert 2008, *Real-Time Shading with Filtered Importance Sampling*, for means
//! whose width follows the spacing of directions; the nodes and their tents are brood's own
//! (docs/maths/lights.md).

mod between;
mod direct;
mod facing;
mod light;
mod nodes;
mod point;
mod spheres;

pub use between::PixelBetween;
pub use direct::LobeShape;
pub(crate) use direct::{DirectLight, DirectSamples};
pub(crate) use facing::{Facing, groups};
pub use light::PrefilteredLight;
pub use nodes::{LobeNodes, LobeTable, NODES, NODES_TOGETHER};
pub use point::LitPoint;
pub use spheres::SphereLayout;
