//! Ashikhmin and Shirley's anisotropic highlight over a diffuse base that fades where the highlight
//! grows.

use std::f64::consts::PI;

use glam::{DVec2, DVec3};

use super::constants::ModelConstants;
use super::formula::{Formula, colors};
use super::fresnel;
use super::parameter::{Parameter, Values};
use super::reflect::Reflect;
use crate::block::{Half, smaller};
use crate::{Block, Claims, Elementary, Machine};

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
#[derive(Debug, Clone)]
pub(super) struct AshikhminShirley {
    /// 28 R_d (1 - R_s) / (23 pi)
    base: DVec3,
    specular: DVec3,
    exponents: (f64, f64),
    /// sqrt((n_u + 1) (n_v + 1)) / (8 pi)
    height: f64,
}

pub(super) fn ashikhmin_shirley(values: Values<'_>) -> AshikhminShirley {
    let (diffuse, specular) = (values.color("diffuse"), values.color("specular"));
    let (u, v) = (values.scalar("exponent_u"), values.scalar("exponent_v"));
    AshikhminShirley {
        base: diffuse * (DVec3::ONE - specular) * (28.0 / (23.0 * PI)),
        specular,
        exponents: (u, v),
        height: ((u + 1.0) * (v + 1.0)).sqrt() / (8.0 * PI),
    }
}

impl Formula for &AshikhminShirley {
    type Value = DVec3;

    #[inline(always)]
    fn at<F: Elementary>(&self, half: &Half, _: usize) -> DVec3 {
        let (u, v) = self.exponents;
        let (x2, y2) = (half.h.x * half.h.x, half.h.y * half.h.y);
        let sine2 = x2 + y2;
        let mixed = (u * x2 + v * y2) / sine2;
        let exponent = if sine2 > 0.0 { mixed } else { u };
        let lobe =
            self.height * F::pow(smaller(half.h.z, 1.0), exponent) / (half.cos_d * half.cos_max());
        // 1 - (1 - c / 2)^5
        let fades = |c: f64| 1.0 - fresnel::schlick_weight(0.5 * c);
        self.base * (fades(half.cos_i()) * fades(half.cos_o()))
            + fresnel::schlick(self.specular, half.cos_d) * lobe
    }
}

impl Reflect for AshikhminShirley {
    fn block<M: Machine, const N: usize>(&self, machine: M, block: &Block<N>) -> [[f64; N]; 3] {
        colors(machine, block, self)
    }

    fn claims(&self) -> Claims {
        Claims { reciprocal: true, conserving: true }
    }

    fn constants(&self) -> ModelConstants {
        ModelConstants::AshikhminShirley {
            base: self.base,
            specular: self.specular,
            exponents: DVec2::from(self.exponents),
            height: self.height,
        }
    }
}
