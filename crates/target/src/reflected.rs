//! Largest directional albedo of a measured material. Measured tables often exceed 1 towards the
//! horizon.

use brood_brdf::Brdf;
use brood_eval::{LobeRule, direction_at};
use glam::DVec3;
use rayon::prelude::*;

use crate::Samples;

/// Angles from the normal, in degrees. Little is measured closer than a degree to the horizon.
const DEGREES: [f64; 14] =
    [0.0, 15.0, 30.0, 45.0, 55.0, 65.0, 72.0, 77.0, 81.0, 84.0, 86.0, 87.5, 88.5, 89.0];
/// Order of the quadrature.
const ORDER: usize = 24;

/// Largest directional albedo, and the direction of its light.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Reflected {
    /// Albedo of the channel that reflects most.
    pub albedo: f64,
    /// Angle of the light from the normal, in degrees.
    pub theta_deg: f64,
}

impl Reflected {
    /// Largest albedo of the mean of f over the exchange of light and eye, which is what is fitted.
    /// Light comes from one azimuth only.
    ///
    /// # Error
    /// 1 to 2 % of the albedo for smooth materials.
    pub(crate) fn most(brdf: &dyn Brdf) -> Self {
        let rule = LobeRule::new(ORDER);
        let of = |theta_deg: &f64| {
            let (sin, cos) = libm::sincos(theta_deg.to_radians());
            let wi = direction_at(sin, cos, 0.0);
            let (pairs, weights): (Vec<_>, Vec<f64>) = rule.nodes(wi).into_iter().unzip();
            let samples = Samples::of(brdf, pairs);
            let each = samples.values().iter().zip(weights);
            let albedo: DVec3 = each.map(|(f, weight)| DVec3::from(*f) * weight).sum();
            Self { albedo: albedo.max_element(), theta_deg: *theta_deg }
        };
        let all: Vec<Self> = DEGREES.par_iter().map(of).collect();
        let more = |a: Self, b: Self| if b.albedo > a.albedo { b } else { a };
        all.into_iter().reduce(more).expect("DEGREES is not empty")
    }

    /// True if the albedo exceeds 1 by more than the error of the quadrature.
    #[must_use]
    pub fn is_too_much(&self) -> bool {
        self.albedo > 1.02
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::FRAC_1_PI;

    use brood_brdf::{Claims, DirectionPair};

    use super::*;

    /// Lambertian material with this albedo in the green channel.
    struct Even(f64);

    impl Brdf for Even {
        fn f(&self, _: &DirectionPair) -> DVec3 {
            DVec3::new(0.1, self.0, 0.2) * FRAC_1_PI
        }

        fn claims(&self) -> Claims {
            Claims { reciprocal: true, conserving: self.0 <= 1.0 }
        }
    }

    #[test]
    fn reflected_is_the_albedo_of_a_lambertian() {
        for (albedo, is_too_much) in [(0.5, false), (1.0, false), (1.5, true)] {
            let most = Reflected::most(&Even(albedo));
            assert!((most.albedo - albedo).abs() < 4e-3 * albedo, "{most:?}");
            assert_eq!(most.is_too_much(), is_too_much, "{most:?}");
        }
    }
}
