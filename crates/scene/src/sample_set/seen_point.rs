//! Points of a surface as the eye sees them, from which rays leave.

use brood_mesh::trace::Ray;
use glam::{DVec3, Vec2};

/// Changes of the texture position over a pixel, to the right and down.
pub(super) type Footprint = [Vec2; 2];

/// Point of a surface as the eye sees it.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct SeenPoint {
    pub position: DVec3,
    /// Shading normal, on the side of the eye.
    pub n: DVec3,
    /// Tangent along u, at a right angle to `n`.
    pub u: DVec3,
    /// Normal of the triangle, on the side of the eye.
    pub face: DVec3,
    /// Direction to the eye.
    pub eye: DVec3,
    /// Seed of the light samples at the point.
    pub seed: u64,
}

/// Ray that leaves a body, with the seed of the light samples where it ends.
#[derive(Debug, Clone, Copy)]
pub struct LeavingRay {
    /// The ray, in the unit frame of the body.
    pub ray: Ray,
    /// Seed of light samples.
    pub seed: u64,
}
