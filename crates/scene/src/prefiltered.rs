//! Distant light from all directions, integrated over nodes instead of samples.
//!
//! An isotropic material that is the same everywhere reflects f(cos_o, wi): for each angle to the
//! eye a function of two angles. [`LobeNodes`] holds nodes in these angles, dense around the mirror
//! direction. A material is tabulated at them once ([`LobeTable`]). [`PrefilteredLight`] gives the
//! mean radiance of the environments around the nodes of each surface point; the sum of their
//! products is the reflected radiance. It has no noise, and its cost does not depend on the
//! material.
//!
//! # Source
//! Křivánek and Colbert 2008, *Real-Time Shading with Filtered Importance Sampling*, for means
//! whose width follows the spacing of directions; the nodes and their tents are brood's own
//! (docs/maths/lights.md).

mod light;
mod nodes;

pub use light::{LitPoint, PrefilteredLight};
pub use nodes::{LobeNodes, LobeTable, NODES, NODES_TOGETHER};
