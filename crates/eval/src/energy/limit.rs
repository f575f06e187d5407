//! Result of the search for the largest albedo, and where it is searched.

use glam::{DVec2, DVec3};

use super::hemisphere::direction_at;

/// The largest directional albedo of a program and the divisor it requires.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EnergyLimit {
    /// Largest directional albedo of any channel.
    pub albedo: f64,
    /// Estimated relative error bound of the albedo.
    pub error_bound: f64,
    /// Divisor of f: max(1, albedo (1 + error bound)).
    pub divisor: f64,
    /// Angle of the largest albedo from the normal, in degrees.
    pub theta_deg: f64,
    /// Number of reflectances computed.
    pub samples: usize,
}

/// An incident direction and a texture position.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Incidence {
    /// Angle from the normal, in degrees.
    pub(super) theta_deg: f64,
    /// Azimuth from the x axis, in full turns.
    pub(super) turn: f64,
    /// Texture position.
    pub uv: DVec2,
}

impl Incidence {
    /// Returns the incident direction.
    #[must_use]
    pub fn direction(&self) -> DVec3 {
        let (sin, cos) = libm::sincos(self.theta_deg.to_radians());
        direction_at(sin, cos, self.turn)
    }
}
