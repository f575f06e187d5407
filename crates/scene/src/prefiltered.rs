//! Light from environments, integrated over nodes instead of samples.
//!
//! Seen from one direction, an isotropic homogeneous material is a function of the half vector.
//! [`LobeNodes`] holds nodes of half vectors, dense near the normal, for a number of angles to the
//! eye. [`LobeTable`] holds a material at the nodes. [`PrefilteredLight`] computes the mean
//! radiance of the environments around the nodes of each surface point. Reflected radiance is the
//! sum of their products: it has no noise, and its cost does not depend on the material.
//!
//! # Source
//! Křivánek and Colbert 2008, *Real-Time Shading with Filtered Importance Sampling*, for means
//! whose width follows the spacing of directions; the nodes and their tents are brood's own
//! (docs/maths/lights.md).

mod light;
mod nodes;
mod spheres;

pub use light::{LitPoint, PrefilteredLight};
pub use nodes::{LobeNodes, LobeTable, NODES, NODES_TOGETHER};
pub use spheres::SPHERES_ACROSS;
