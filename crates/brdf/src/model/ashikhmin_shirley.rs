//! Ashikhmin and Shirley's anisotropic highlight over a diffuse base that fades where the highlight grows.

use std::f64::consts::PI;

use glam::DVec3;

use super::fresnel;
use super::half::Half;
use super::parameter::{Parameter, Values};
use super::{Brdf, Claims};
use crate::DirectionPair;

const EXPONENTS: (f64, f64) = (0.5, 100_000.0);

pub(super) const ASHIKHMIN_SHIRLEY: &[Parameter] = &[
    Parameter::color("diffuse", "R_d: share of light that is scattered back", [0.3; 3], (0.0, 1.0)),
    Parameter::color("specular", "R_s: reflectance at normal incidence", [0.05; 3], (0.0, 1.0)),
    Parameter::scalar("exponent_u", "n_u: how narrow the highlight is along u", 100.0, EXPONENTS)
        .logarithmic(),
    Parameter::scalar("exponent_v", "n_v: how narrow the highlight is along v", 100.0, EXPONENTS)
        .logarithmic(),
];

/// # Source
/// Ashikhmin and Shirley 2000, equations 4 and 5.
struct AshikhminShirley {
    diffuse: DVec3,
    specular: DVec3,
    exponents: (f64, f64),
}

pub(super) fn ashikhmin_shirley(values: Values<'_>) -> Box<dyn Brdf> {
    Box::new(AshikhminShirley {
        diffuse: values.color("diffuse"),
        specular: values.color("specular"),
        exponents: (values.scalar("exponent_u"), values.scalar("exponent_v")),
    })
}

impl Brdf for AshikhminShirley {
    fn f(&self, pair: &DirectionPair) -> DVec3 {
        let Some(half) = Half::of(pair) else { return DVec3::ZERO };
        let (u, v) = self.exponents;
        let (x2, y2) = (half.h.x * half.h.x, half.h.y * half.h.y);
        let sine2 = x2 + y2;
        let exponent = if sine2 > 0.0 { (u * x2 + v * y2) / sine2 } else { u };
        let lobe = ((u + 1.0) * (v + 1.0)).sqrt() / (8.0 * PI)
            * libm::pow(half.h.z.min(1.0), exponent)
            / (half.cos_d * half.cos_i.max(half.cos_o));
        // 1 - (1 - c / 2)^5
        let fades = |c: f64| 1.0 - (1.0 - 0.5 * c).powi(5);
        let base = 28.0 / (23.0 * PI) * (fades(half.cos_i) * fades(half.cos_o));
        self.diffuse * (DVec3::ONE - self.specular) * base
            + fresnel::schlick(self.specular, half.cos_d) * lobe
    }

    fn claims(&self) -> Claims {
        Claims { reciprocal: true, conserving: true }
    }
}
