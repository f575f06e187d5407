//! Diffuse surfaces: Lambert, and Oren and Nayar.

use std::f64::consts::{FRAC_1_PI, FRAC_PI_2};

use glam::DVec3;

use super::half::Half;
use super::parameter::{Parameter, Values};
use super::{Brdf, Claims};
use crate::DirectionPair;

/// The share of light that is sent back, as all tables name it.
pub(super) const ALBEDO: Parameter =
    Parameter::color("albedo", "share of light that is scattered back", [0.5; 3], (0.0, 1.0));

/// f = rho / pi.
///
/// # Source
/// Lambert 1760.
struct Lambert {
    albedo: DVec3,
}

pub(super) const LAMBERT: &[Parameter] = &[ALBEDO];

pub(super) fn lambert(values: Values<'_>) -> Box<dyn Brdf> {
    Box::new(Lambert { albedo: values.color("albedo") })
}

impl Brdf for Lambert {
    fn f(&self, pair: &DirectionPair) -> DVec3 {
        if Half::of(pair).is_some() { self.albedo * FRAC_1_PI } else { DVec3::ZERO }
    }

    fn claims(&self) -> Claims {
        Claims { reciprocal: true, conserving: true }
    }
}

/// V-shaped grooves of Lambert's surfaces, in the form without interreflection.
///
/// # Source
/// Oren and Nayar 1994, equation 30. max(0, cos(phi)) sin(alpha) tan(beta) there is max(0, wi . wo - cos_i cos_o) over the
/// larger of the cosines, which needs no angle.
///
/// # Error
/// The published form reflects up to 1.008 of what an albedo of 1 should, at grazing light and sigma below 0.3 (quadrature of
/// 360,000 points); it conserves energy up to an albedo of 0.99.
struct OrenNayar {
    albedo: DVec3,
    a: f64,
    b: f64,
}

pub(super) const OREN_NAYAR: &[Parameter] = &[
    ALBEDO,
    Parameter::scalar("sigma", "deviation of the facets' slopes", 0.35, (0.0, FRAC_PI_2))
        .in_unit("rad"),
];

pub(super) fn oren_nayar(values: Values<'_>) -> Box<dyn Brdf> {
    let sigma2 = values.scalar("sigma").powi(2);
    let a = 1.0 - 0.5 * sigma2 / (sigma2 + 0.33);
    let b = 0.45 * sigma2 / (sigma2 + 0.09);
    Box::new(OrenNayar { albedo: values.color("albedo"), a, b })
}

impl Brdf for OrenNayar {
    fn f(&self, pair: &DirectionPair) -> DVec3 {
        let Some(half) = Half::of(pair) else { return DVec3::ZERO };
        let across = (half.cos_io - half.cos_i * half.cos_o).max(0.0);
        let shade = self.a + self.b * across / half.cos_i.max(half.cos_o);
        self.albedo * (FRAC_1_PI * shade)
    }

    fn claims(&self) -> Claims {
        Claims { reciprocal: true, conserving: self.albedo.max_element() <= 0.99 }
    }
}
