//! Rough plastic: a diffuse base below a rough coat that reflects part of the scattered light back
//! to the base.

use std::f64::consts::FRAC_1_PI;

use glam::{DVec2, DVec3};

use super::coat::{CoatTables, TABLE_SIZE};
use super::constants::{ModelConstants, Shadowing};
use super::formula::{Formula, colors};
use super::fresnel;
use super::microfacet::Distribution;
use super::parameter::{ALBEDO, IOR, Parameter, ROUGHNESS, Values};
use super::reflect::Reflect;
use crate::block::{Half, larger, smaller, unit};
use crate::{Block, Claims, Elementary, Machine};

pub(super) const ROUGH_PLASTIC: &[Parameter] = &[
    ALBEDO,
    IOR,
    ROUGHNESS,
    Parameter::choice(
        "distribution",
        "D: how the facets' normals are distributed",
        &["ggx", "beckmann"],
    ),
    Parameter::choice(
        "internal",
        "how R is integrated; exact: to 1e-3 of 1 - R; mitsuba: as there, 1.5 % less",
        &["exact", "mitsuba"],
    ),
    Parameter::choice(
        "scattering",
        "linear: the base is scattered from once; nonlinear: again and again, which saturates its colour",
        &["linear", "nonlinear"],
    ),
];

/// f = D F G / (4 cos_i cos_o) + rho T(i) T(o) / (pi eta^2 (1 - rho' R)). T is the transmittance of
/// the rough coat from outside, R its reflectance of diffuse light from inside; rho' is 1 for
/// linear scattering, otherwise rho.
///
/// # Source
/// Jakob 2010, the roughplastic plugin of Mitsuba. Its tables are computed as here, by integrals
/// over the visible normals of Smith's masking times the Fresnel transmittance. There R is the mean
/// of 64 values instead of their integral, which is 1.5 % too small; `internal mitsuba` reproduces
/// that.
#[derive(Debug, Clone)]
pub(super) struct RoughPlastic {
    /// rho / (pi eta^2 (1 - rho' R))
    base: DVec3,
    eta: f64,
    distribution: Distribution,
    transmittance: [f64; TABLE_SIZE],
}

pub(super) fn rough_plastic(values: Values<'_>, tables: &CoatTables) -> RoughPlastic {
    let eta = values.scalar("ior");
    let alpha = values.scalar("roughness");
    let distribution = Distribution::named(values.choice("distribution"), DVec2::splat(alpha));
    let back = tables.back;
    let albedo = values.color("albedo");
    let again = match values.choice("scattering") {
        "nonlinear" => albedo * back,
        _ => DVec3::splat(back),
    };
    let base = albedo * FRAC_1_PI / (eta * eta) / (DVec3::ONE - again);
    RoughPlastic { base, eta, distribution, transmittance: tables.transmittance }
}

impl RoughPlastic {
    /// Transmittance, interpolated linearly between the tabulated cosines.
    #[inline(always)]
    fn transmittance(&self, cosine: f64) -> f64 {
        /// 2^52: adding it rounds to an integer and leaves that integer in the low bits.
        const WHOLE: f64 = 4_503_599_627_370_496.0;
        const LAST: f64 = (TABLE_SIZE - 2) as f64;
        let at = unit(cosine) * (TABLE_SIZE - 1) as f64;
        let rounded = smaller(larger(at - 0.5, 0.0), LAST) + WHOLE;
        let share = at - (rounded - WHOLE);
        #[expect(
            clippy::cast_possible_truncation,
            reason = "the low bits are an index of the table"
        )]
        let low = rounded.to_bits() as usize % TABLE_SIZE;
        self.transmittance[low] * (1.0 - share) + self.transmittance[(low + 1) % TABLE_SIZE] * share
    }
}

/// Highlight of the coat plus the light that the base scatters. `facets` is D G / (4 cos_i cos_o).
struct Coated<'a, const N: usize> {
    model: &'a RoughPlastic,
    facets: &'a [f64; N],
}

impl<const N: usize> Formula for Coated<'_, N> {
    type Value = DVec3;

    #[inline(always)]
    fn at<F: Elementary>(&self, half: &Half, k: usize) -> DVec3 {
        let coat = fresnel::dielectric(self.model.eta, half.cos_d) * self.facets[k];
        let through =
            self.model.transmittance(half.cos_i()) * self.model.transmittance(half.cos_o());
        self.model.base * through + DVec3::splat(coat)
    }
}

impl Reflect for RoughPlastic {
    fn block<M: Machine, const N: usize>(&self, machine: M, block: &Block<N>) -> [[f64; N]; 3] {
        let facets = &self.distribution.facets(Shadowing::Separable, machine, block);
        colors(machine, block, Coated { model: self, facets })
    }

    fn claims(&self) -> Claims {
        Claims { reciprocal: true, conserving: true }
    }

    fn constants(&self) -> ModelConstants {
        ModelConstants::RoughPlastic {
            base: self.base,
            ior: self.eta,
            facets: self.distribution.constants(Shadowing::Separable),
            transmittance: self.transmittance.to_vec(),
        }
    }
}
