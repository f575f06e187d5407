//! Sample of a light, and the surface point that receives it.

use brood_mesh::LocalFrame;
use glam::DVec3;

/// Sample of a light as it arrives at a position.
#[derive(Debug, Clone, Copy)]
pub struct LightSample {
    /// Unit direction towards the light.
    pub towards: DVec3,
    /// Share of this sample in the light's irradiance at normal incidence.
    pub irradiance: [f64; 3],
    /// Distance of the light, in the unit frame; infinite for distant lights.
    pub distance: f64,
    /// True in a gradual fall-off, whose end is not an edge.
    pub fading: bool,
}

/// Light at a position as if all of it came from one direction.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CentralLight {
    /// Unit direction towards the middle of the light; `None` if it comes evenly from everywhere.
    pub towards: Option<DVec3>,
    /// Irradiance at normal incidence.
    pub irradiance: [f64; 3],
}

/// Surface point that receives light.
#[derive(Debug, Clone, Copy)]
pub struct Receiver {
    /// Position in the unit frame.
    pub position: DVec3,
    /// Shading frame at that position, its normal on the side that faces the eye.
    pub frame: LocalFrame,
    /// Direction to the eye, in the local frame.
    pub wo: DVec3,
    /// Seed of the samples.
    pub seed: u64,
}

/// Returns the largest channel.
pub(crate) fn brightest([r, g, b]: [f64; 3]) -> f64 {
    r.max(g).max(b)
}
