//! Diffuse models: Lambert, and Oren and Nayar.

use std::f64::consts::{FRAC_1_PI, FRAC_PI_2};

use glam::DVec3;

use super::constants::ModelConstants;
use super::formula::{Formula, colors};
use super::parameter::{ALBEDO, Parameter, Values};
use super::reflect::Reflect;
use crate::block::{Half, larger};
use crate::{Block, Claims, Elementary, Machine};

/// f = rho / pi.
///
/// # Source
/// Lambert 1760.
#[derive(Debug, Clone)]
pub(super) struct Lambert {
    /// rho / pi
    f: DVec3,
}

pub(super) const LAMBERT: &[Parameter] = &[ALBEDO];

pub(super) fn lambert(values: Values<'_>) -> Lambert {
    Lambert { f: values.color("albedo") * FRAC_1_PI }
}

impl Formula for &Lambert {
    type Value = DVec3;

    #[inline(always)]
    fn at<F: Elementary>(&self, _: &Half, _: usize) -> DVec3 {
        self.f
    }
}

impl Reflect for Lambert {
    fn block<M: Machine, const N: usize>(&self, machine: M, block: &Block<N>) -> [[f64; N]; 3] {
        colors(machine, block, self)
    }

    fn claims(&self) -> Claims {
        Claims { reciprocal: true, conserving: true }
    }

    fn constants(&self) -> ModelConstants {
        ModelConstants::Lambert { f: self.f }
    }
}

/// V-shaped grooves of Lambertian facets, without interreflection.
///
/// # Source
/// Oren and Nayar 1994, equation 30. Its term max(0, cos(phi)) sin(alpha) tan(beta) is max(0, wi .
/// wo - cos_i cos_o) divided by the larger cosine, which needs no angle.
///
/// # Error
/// The published form reflects up to 1.008 of what an albedo of 1 should, at grazing light and
/// sigma below 0.3 (quadrature with 360,000 points). It conserves energy up to an albedo of 0.99.
#[derive(Debug, Clone)]
pub(super) struct OrenNayar {
    albedo: DVec3,
    a: f64,
    b: f64,
}

pub(super) const OREN_NAYAR: &[Parameter] = &[
    ALBEDO,
    Parameter::scalar("sigma", "deviation of the facets' slopes", 0.35, (0.0, FRAC_PI_2))
        .in_unit("rad"),
];

pub(super) fn oren_nayar(values: Values<'_>) -> OrenNayar {
    let sigma2 = values.scalar("sigma").powi(2);
    let a = 1.0 - 0.5 * sigma2 / (sigma2 + 0.33);
    let b = 0.45 * sigma2 / (sigma2 + 0.09);
    OrenNayar { albedo: values.color("albedo"), a, b }
}

impl Formula for &OrenNayar {
    type Value = DVec3;

    #[inline(always)]
    fn at<F: Elementary>(&self, half: &Half, _: usize) -> DVec3 {
        let across = larger(half.cos_io() - half.cos_i() * half.cos_o(), 0.0);
        let shade = self.a + self.b * across / half.cos_max();
        self.albedo * (FRAC_1_PI * shade)
    }
}

impl Reflect for OrenNayar {
    fn block<M: Machine, const N: usize>(&self, machine: M, block: &Block<N>) -> [[f64; N]; 3] {
        colors(machine, block, self)
    }

    fn claims(&self) -> Claims {
        Claims { reciprocal: true, conserving: self.albedo.max_element() <= 0.99 }
    }

    fn constants(&self) -> ModelConstants {
        let Self { albedo, a, b } = *self;
        ModelConstants::OrenNayar { albedo, a, b }
    }
}
