//! Test material that reflects more light than it receives.

use std::f64::consts::FRAC_1_PI;

use brood_brdf::{Brdf, Claims, DirectionPair};
use glam::DVec3;

/// Reflects more towards the horizon, up to eleven times the incident light.
pub(crate) struct Shining;

impl Brdf for Shining {
    fn f(&self, pair: &DirectionPair) -> DVec3 {
        let (cos_i, cos_o) = (pair.cos_i(), pair.cos_o());
        DVec3::new(0.9, 0.5, 0.1) * (1.0 + 0.05 / (cos_i * cos_o)) * FRAC_1_PI
    }

    fn claims(&self) -> Claims {
        Claims { reciprocal: true, conserving: false }
    }
}
