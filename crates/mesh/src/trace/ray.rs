//! Rays.

use glam::DVec3;

/// Ray in the unit frame.
#[derive(Debug, Clone, Copy)]
pub struct Ray {
    /// Start point.
    pub origin: DVec3,
    /// Unit direction.
    pub direction: DVec3,
}
