//! Result of the search for the largest albedo, and the places where it is searched.

use glam::{DVec2, DVec3};

use super::hemisphere::direction_at;

/// Angle from the normal up to which tilts are equal steps of the angle, in degrees.
const KNEE_DEG: f64 = 80.0;
/// Cosine of the flattest incident direction.
pub const FLATTEST_COS: f64 = 1e-6;

/// The largest directional albedo of a program and the divisor it requires.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EnergyLimit {
    /// Largest directional albedo of any channel.
    pub albedo: f64,
    /// Relative amount by which the true maximum may be larger.
    pub error_bound: f64,
    /// Divisor of f: max(1, albedo (1 + error bound)).
    pub divisor: f64,
    /// Angle of the largest albedo from the normal, in degrees.
    pub theta_deg: f64,
    /// Number of reflectances computed.
    pub samples: usize,
}

impl EnergyLimit {
    /// Returns the upper bound of the directional albedo: that found, plus its error bound.
    #[must_use]
    pub fn bound(&self) -> f64 {
        self.albedo * (1.0 + self.error_bound)
    }
}

/// An incident direction and a texture position.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Incidence {
    /// Distance from the normal: 0 there, 1 at [`KNEE_DEG`], with equal steps of the angle; then
    /// equal steps of the logarithm of the cosine, to 2 at [`FLATTEST_COS`].
    pub(super) tilt: f64,
    /// Azimuth from the x axis, in full turns.
    pub(super) turn: f64,
    /// Texture position.
    pub uv: DVec2,
}

impl Incidence {
    /// Returns the place with that angle from the normal in degrees and that azimuth in turns.
    #[must_use]
    pub fn at(theta_deg: f64, turn: f64, uv: DVec2) -> Self {
        let tilt = match theta_deg <= KNEE_DEG {
            true => theta_deg / KNEE_DEG,
            false => tilt_of(libm::cos(theta_deg.to_radians())),
        };
        Self { tilt, turn, uv }
    }

    /// Returns the cosine of the angle from the normal.
    #[must_use]
    pub fn cos(&self) -> f64 {
        if self.tilt <= 1.0 {
            return libm::cos((self.tilt * KNEE_DEG).to_radians());
        }
        let knee = knee_cos();
        knee * libm::exp(libm::log(FLATTEST_COS / knee) * (self.tilt - 1.0))
    }

    /// Returns the angle from the normal, in degrees.
    #[must_use]
    pub fn theta_deg(&self) -> f64 {
        if self.tilt <= 1.0 { self.tilt * KNEE_DEG } else { libm::acos(self.cos()).to_degrees() }
    }

    /// Returns the incident direction.
    #[must_use]
    pub fn direction(&self) -> DVec3 {
        let cos = self.cos();
        let sin = match self.tilt <= 1.0 {
            true => libm::sin((self.tilt * KNEE_DEG).to_radians()),
            false => ((1.0 - cos) * (1.0 + cos)).sqrt(),
        };
        direction_at(sin, cos, self.turn)
    }
}

/// Returns the tilt of a cosine below that of [`KNEE_DEG`].
pub(super) fn tilt_of(cos: f64) -> f64 {
    let knee = knee_cos();
    1.0 + libm::log(cos / knee) / libm::log(FLATTEST_COS / knee)
}

fn knee_cos() -> f64 {
    libm::cos(KNEE_DEG.to_radians())
}
