//! Rough plastic: light that enters through the coat is scattered by the base, and partly reflected back to it from below.

use std::f64::consts::{FRAC_1_PI, TAU};

use glam::{DVec2, DVec3};

use super::cook_torrance::{IOR, ROUGHNESS};
use super::diffuse::ALBEDO;
use super::formula::{Formula, colors};
use super::microfacet::{Distribution, Shadowing};
use super::parameter::{Parameter, Values};
use super::prepared::{Prepared, Reflect};
use super::{Claims, fresnel};
use crate::block::{Half, larger, smaller, unit};
use crate::{Block, Elementary, Libm, Machine};

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
        "how R is integrated; exact: to 1e-4; mitsuba: as there, 1.5 % less",
        &["exact", "mitsuba"],
    ),
    Parameter::choice(
        "scattering",
        "linear: the base is scattered from once; nonlinear: again and again, which saturates its colour",
        &["linear", "nonlinear"],
    ),
];

/// Cosines that transmittance is tabled for, from 0 to 1.
const TABLED: usize = 64;
/// Points of the quadrature over the facets' normals, along each of two axes.
const POINTS: u32 = 40;
/// The same where it need not be exact.
const COARSE_POINTS: u32 = 8;

/// f = D F G / (4 cos_i cos_o) + rho T(i) T(o) / (pi eta^2 (1 - rho' R)): T is the share of light that passes the rough coat
/// from outside, R what it reflects back from inside; rho' is 1 for linear scattering, rho otherwise.
///
/// # Source
/// Jakob 2010, the roughplastic plugin of Mitsuba, whose tables are made as here: integrals over the visible normals of
/// Smith's masking times what Fresnel's equations let through. R there is the mean of 64 values in place of their integral,
/// which is 1.5 % too little; `internal mitsuba` does the same.
#[derive(Debug, Clone)]
pub(super) struct RoughPlastic {
    /// rho / (pi eta^2 (1 - rho' R))
    base: DVec3,
    eta: f64,
    distribution: Distribution,
    passes: [f64; TABLED],
}

/// What takes long to prepare of rough plastic: what passes its coat, and what the coat sends back. The same for all colours of
/// the base.
#[derive(Debug, Clone, PartialEq)]
pub struct CoatTables {
    passes: [f64; TABLED],
    /// Sum over the tabled cosines, and that of the last.
    back: (f64, f64),
}

/// How finely tables are made.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum TableDetail {
    /// As models are defined.
    Full,
    /// In a thirtieth of the time, off by some thousandths: for derivatives, and to come near.
    Coarse,
}

impl CoatTables {
    pub(super) fn new(values: Values<'_>, detail: TableDetail) -> Self {
        let eta = values.scalar("ior");
        let alpha = values.scalar("roughness");
        let distribution = Distribution::named(values.choice("distribution"), DVec2::splat(alpha));
        let cosine = |k: usize| (k as f64 / (TABLED - 1) as f64).max(1e-6);
        let turns = half_turns(match detail {
            TableDetail::Full => POINTS,
            TableDetail::Coarse => COARSE_POINTS,
        });
        let passes =
            std::array::from_fn(|k| through(distribution, &turns, (alpha, eta), cosine(k)));
        let inside =
            |k: usize| 2.0 * cosine(k) * back(distribution, &turns, (alpha, 1.0 / eta), cosine(k));
        let all = (0..TABLED).map(inside).sum();
        Self { passes, back: (all, inside(TABLED - 1)) }
    }
}

pub(super) fn rough_plastic(values: Values<'_>) -> Prepared {
    rough_plastic_with(values, &CoatTables::new(values, TableDetail::Full))
}

pub(super) fn rough_plastic_with(values: Values<'_>, tables: &CoatTables) -> Prepared {
    let eta = values.scalar("ior");
    let alpha = values.scalar("roughness");
    let distribution = Distribution::named(values.choice("distribution"), DVec2::splat(alpha));
    let (all, last) = tables.back;
    // Over the hemisphere, of light that is even there: by the trapezoid rule, or by the mean of the values.
    let back = match values.choice("internal") {
        "mitsuba" => all / TABLED as f64,
        _ => (all - 0.5 * last) / (TABLED - 1) as f64,
    };
    let albedo = values.color("albedo");
    let again = match values.choice("scattering") {
        "nonlinear" => albedo * back,
        _ => DVec3::splat(back),
    };
    let base = albedo * FRAC_1_PI / (eta * eta) / (DVec3::ONE - again);
    Prepared::RoughPlastic(Box::new(RoughPlastic {
        base,
        eta,
        distribution,
        passes: tables.passes,
    }))
}

impl RoughPlastic {
    /// Linear between the tabled cosines.
    #[inline(always)]
    fn passes(&self, cosine: f64) -> f64 {
        /// 2^52: what is added to it becomes whole, and stands in the low bits.
        const WHOLE: f64 = 4_503_599_627_370_496.0;
        const LAST: f64 = (TABLED - 2) as f64;
        let at = unit(cosine) * (TABLED - 1) as f64;
        let rounded = smaller(larger(at - 0.5, 0.0), LAST) + WHOLE;
        let share = at - (rounded - WHOLE);
        #[expect(
            clippy::cast_possible_truncation,
            reason = "the low bits are a place in the table"
        )]
        let low = rounded.to_bits() as usize % TABLED;
        self.passes[low] * (1.0 - share) + self.passes[(low + 1) % TABLED] * share
    }
}

/// The coat's light, of which `facets` is D G / (4 cos_i cos_o), and what comes from below it.
struct Coated<'a, const N: usize> {
    model: &'a RoughPlastic,
    facets: &'a [f64; N],
}

impl<const N: usize> Formula for Coated<'_, N> {
    type Value = DVec3;

    #[inline(always)]
    fn at<F: Elementary>(&self, half: &Half, k: usize) -> DVec3 {
        let coat = fresnel::dielectric(self.model.eta, half.cos_d) * self.facets[k];
        let through = self.model.passes(half.cos_i()) * self.model.passes(half.cos_o());
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
}

/// Cosines and sines around half of the circle; the other half is the same mirrored.
fn half_turns(count: u32) -> Vec<(f64, f64)> {
    let turn = |column: u32| 0.5 * TAU * (f64::from(column) + 0.5) / f64::from(count);
    (0..count).map(turn).map(|phi| (libm::cos(phi), libm::sin(phi))).collect()
}

/// The share of the light from one direction that a rough boundary lets through.
fn through(
    distribution: Distribution,
    turns: &[(f64, f64)],
    (alpha, eta): (f64, f64),
    cosine: f64,
) -> f64 {
    over_facets(distribution, turns, (alpha, cosine), |wi, m, c, weight| {
        let reflected = fresnel::dielectric(eta, c);
        let cos_t = (1.0 - (1.0 - c * c) / (eta * eta)).max(0.0).sqrt();
        let refracted = m * (c / eta - cos_t) - wi / eta;
        if reflected < 1.0 && refracted.z < 0.0 {
            let below = DVec3::new(refracted.x, refracted.y, -refracted.z);
            let seen = distribution.masking::<Libm>(below) * below.z;
            return weight * (1.0 - reflected) * seen;
        }
        0.0
    })
}

/// The share that it sends back.
fn back(
    distribution: Distribution,
    turns: &[(f64, f64)],
    (alpha, eta): (f64, f64),
    cosine: f64,
) -> f64 {
    over_facets(distribution, turns, (alpha, cosine), |wi, m, c, weight| {
        let mirrored = m * (2.0 * c) - wi;
        if mirrored.z > 0.0 {
            let seen = distribution.masking::<Libm>(mirrored);
            return weight * fresnel::dielectric(eta, c) * seen * mirrored.z;
        }
        0.0
    })
}

/// The mean of what `share` makes of the direction of light, a facet's normal, the cosine between these and the facet's weight
/// among those that are seen, by the midpoint rule over the facets' normals, which are drawn as they are distributed.
/// `turns` are the cosines and sines of the columns; there are as many rows.
#[inline(always)]
fn over_facets(
    distribution: Distribution,
    turns: &[(f64, f64)],
    (alpha, cosine): (f64, f64),
    share: impl Fn(DVec3, DVec3, f64, f64) -> f64,
) -> f64 {
    let wi = DVec3::new((1.0 - cosine * cosine).sqrt(), 0.0, cosine);
    let seen_from_wi = distribution.masking::<Libm>(wi);
    let mut sum = 0.0;
    let rows = turns.len();
    for row in 0..rows {
        let at = (row as f64 + 0.5) / rows as f64;
        // What a grazing view sees is far out in GGX's tail: by this substitution rows stand closer there.
        let left = 1.0 - at;
        let rest = left * left * left;
        let density = 3.0 * left * left;
        let tan2 = match distribution {
            Distribution::Beckmann(_) => -alpha * alpha * libm::log(rest),
            _ => alpha * alpha * (1.0 - rest) / rest,
        };
        let z = 1.0 / (1.0 + tan2).sqrt();
        let r = (1.0 - z * z).max(0.0).sqrt();
        for (cos_phi, sin_phi) in turns {
            let m = DVec3::new(r * cos_phi, r * sin_phi, z);
            let c = wi.dot(m);
            if c <= 0.0 {
                continue;
            }
            // Of the facets that are seen from wi.
            let weight = density * seen_from_wi * c / z;
            sum += share(wi, m, c, weight);
        }
    }
    sum / (rows * rows) as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_passes_is_that_of_many_more_normals() {
        for word in ["ggx", "beckmann"] {
            for alpha in [0.02, 0.1, 0.3, 0.8] {
                let distribution = Distribution::named(word, DVec2::splat(alpha));
                for cosine in [1e-6, 0.05, 0.2, 0.5, 1.0] {
                    let of =
                        |count| through(distribution, &half_turns(count), (alpha, 1.5), cosine);
                    let off = (of(POINTS) - of(1000)).abs();
                    assert!(off < 1.5e-3, "{word} {alpha} {cosine}: {off}");
                }
            }
        }
    }

    #[test]
    fn what_comes_back_over_the_hemisphere_is_that_of_many_more_normals() {
        for alpha in [0.02, 0.1, 0.3, 0.8] {
            let distribution = Distribution::named("ggx", DVec2::splat(alpha));
            let of = |count| {
                let turns = half_turns(count);
                let cosine = |k: u32| (f64::from(k) / 63.0).max(1e-6);
                let inside =
                    |k: u32| cosine(k) * back(distribution, &turns, (alpha, 1.0 / 1.5), cosine(k));
                (0..64).map(inside).sum::<f64>() / 32.0
            };
            let off = (of(POINTS) - of(300)).abs();
            assert!(off < 1e-3, "{alpha}: {off}");
        }
    }
}
