//! Microfacets: distributions of their normals, and shadowing and masking.
//!
//! Each function is finite and non-negative down to the least roughness of the parameter tables and
//! for any cosines above 0. Shadowing is computed together with the factor 1 / (4 cos_i cos_o),
//! which alone would be infinite at grazing angles.

use std::f64::consts::PI;

use glam::{DVec2, DVec3};

use super::constants::{DistributionConstants, FacetConstants, Shadowing};
use super::formula::{Formula, scalars};
use crate::block::{Half, larger, smaller};
use crate::{Block, Elementary, Machine};

/// Distribution of facet normals.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Distribution {
    /// Trowbridge and Reitz 1975, named GGX by Walter 2007.
    Ggx(Ggx),
    /// Beckmann 1963, normalised as in Walter 2007, equation 25.
    Beckmann(Beckmann),
    /// Torrance and Sparrow 1967: Gaussian of the angle.
    Gaussian(Gaussian),
    /// Blinn 1977, normalised.
    Blinn(Blinn),
}

/// Words of the parameter `distribution`, which [`Distribution::named`] accepts.
pub(super) const DISTRIBUTIONS: &[&str] = &["ggx", "beckmann", "gaussian", "blinn-phong"];
/// Words of the parameter `shadowing`.
pub(super) const SHADOWINGS: &[&str] = &["smith", "smith-correlated", "v-groove"];

/// Facets of one distribution. Implementors are types of their own, so that the loop over lanes has
/// no branch.
pub(super) trait Facets: Copy {
    /// D(h) in 1/sr, normalised: the integral of D (n . h) over the hemisphere is 1.
    fn d<F: Elementary>(&self, half: &Half) -> f64;

    /// Returns cos(w) / G1(w) with Smith's masking G1. Above 0 and finite at the horizon.
    fn cos_over_g1<F: Elementary>(&self, w: DVec3) -> f64;
}

impl Distribution {
    /// Only `ggx` and `beckmann` are anisotropic: the others use the geometric mean of the
    /// roughness.
    ///
    /// # Panics
    /// If the word is not in [`DISTRIBUTIONS`].
    pub(super) fn named(word: &str, alpha: DVec2) -> Self {
        let mean = (alpha.x * alpha.y).sqrt();
        match word {
            "ggx" => Self::ggx(alpha),
            "beckmann" => Self::Beckmann(Beckmann {
                alpha,
                inverse: 1.0 / alpha,
                height: 1.0 / (PI * alpha.x * alpha.y),
            }),
            "gaussian" => Self::Gaussian(Gaussian {
                alpha: mean,
                inverse: 1.0 / mean,
                height: 1.0 / gaussian_area(mean),
            }),
            "blinn-phong" => {
                let n = exponent(mean);
                Self::Blinn(Blinn { alpha: mean, n, height: (n + 2.0) / (2.0 * PI) })
            }
            _ => panic!("unknown distribution {word}"),
        }
    }

    /// GGX with this roughness along x and along y.
    pub(super) fn ggx(alpha: DVec2) -> Self {
        let height = 1.0 / (PI * alpha.x * alpha.y);
        Self::Ggx(Ggx { alpha2: alpha * alpha, inverse: 1.0 / alpha, height })
    }

    /// Returns D G / (4 cos_i cos_o) of each lane.
    #[inline]
    pub(super) fn facets<const N: usize>(
        &self,
        shadowing: Shadowing,
        machine: impl Machine,
        block: &Block<N>,
    ) -> [f64; N] {
        match self {
            Self::Ggx(facets) => shadowed(*facets, shadowing, machine, block),
            Self::Beckmann(facets) => shadowed(*facets, shadowing, machine, block),
            Self::Gaussian(facets) => shadowed(*facets, shadowing, machine, block),
            Self::Blinn(facets) => shadowed(*facets, shadowing, machine, block),
        }
    }

    /// Constants of [`Distribution::facets`], for exporters.
    pub(super) fn constants(&self, shadowing: Shadowing) -> FacetConstants {
        let distribution = match *self {
            Self::Ggx(Ggx { inverse, height, .. }) => {
                DistributionConstants::Ggx { alpha: 1.0 / inverse, height }
            }
            Self::Beckmann(Beckmann { alpha, height, .. }) => {
                DistributionConstants::Beckmann { alpha, height }
            }
            Self::Gaussian(Gaussian { alpha, height, .. }) => {
                DistributionConstants::Gaussian { alpha, height }
            }
            Self::Blinn(Blinn { alpha, n, height }) => {
                DistributionConstants::Blinn { alpha, exponent: n, height }
            }
        };
        FacetConstants { distribution, shadowing }
    }

    /// Smith's G1(w) / cos(w), finite at the horizon.
    #[cfg(test)]
    pub(super) fn g1_over_cos<F: Elementary>(&self, w: DVec3) -> f64 {
        1.0 / match self {
            Self::Ggx(facets) => facets.cos_over_g1::<F>(w),
            Self::Beckmann(facets) => facets.cos_over_g1::<F>(w),
            Self::Gaussian(facets) => facets.cos_over_g1::<F>(w),
            Self::Blinn(facets) => facets.cos_over_g1::<F>(w),
        }
    }

    #[cfg(test)]
    pub(super) fn d<F: Elementary>(&self, half: &Half) -> f64 {
        match self {
            Self::Ggx(facets) => facets.d::<F>(half),
            Self::Beckmann(facets) => facets.d::<F>(half),
            Self::Gaussian(facets) => facets.d::<F>(half),
            Self::Blinn(facets) => facets.d::<F>(half),
        }
    }
}

#[inline]
fn shadowed<const N: usize>(
    facets: impl Facets,
    shadowing: Shadowing,
    machine: impl Machine,
    block: &Block<N>,
) -> [f64; N] {
    match shadowing {
        Shadowing::Groove => scalars(machine, block, Groove(facets)),
        Shadowing::Separable => scalars(machine, block, Separable(facets)),
        Shadowing::Correlated => scalars(machine, block, Correlated(facets)),
    }
}

/// D G / (4 cos_i cos_o) with [`Shadowing::Groove`].
struct Groove<S>(S);
/// D G / (4 cos_i cos_o) with [`Shadowing::Separable`].
struct Separable<S>(S);
/// D G / (4 cos_i cos_o) with [`Shadowing::Correlated`].
struct Correlated<S>(S);

impl<S: Facets> Formula for Groove<S> {
    type Value = f64;

    #[inline(always)]
    fn at<F: Elementary>(&self, half: &Half, _: usize) -> f64 {
        let flat = 1.0 / (4.0 * half.cos_i() * half.cos_o());
        let steep = half.h.z / (2.0 * half.cos_d * half.cos_max());
        self.0.d::<F>(half) * smaller(flat, steep)
    }
}

impl<S: Facets> Formula for Separable<S> {
    type Value = f64;

    #[inline(always)]
    fn at<F: Elementary>(&self, half: &Half, _: usize) -> f64 {
        let both = self.0.cos_over_g1::<F>(half.wi) * self.0.cos_over_g1::<F>(half.wo);
        self.0.d::<F>(half) * (0.25 / both)
    }
}

impl<S: Facets> Formula for Correlated<S> {
    type Value = f64;

    #[inline(always)]
    fn at<F: Elementary>(&self, half: &Half, _: usize) -> f64 {
        // cos_i cos_o (1 + L(i) + L(o)), from cos / G1 = cos (1 + L) with Smith's Lambda, L.
        let (i, o) = (self.0.cos_over_g1::<F>(half.wi), self.0.cos_over_g1::<F>(half.wo));
        let (cos_i, cos_o) = (half.cos_i(), half.cos_o());
        let both = cos_o * i + cos_i * o - cos_i * cos_o;
        self.0.d::<F>(half) * (0.25 / both)
    }
}

impl Shadowing {
    /// # Panics
    /// If the word is not in [`SHADOWINGS`].
    pub(super) fn named(word: &str) -> Self {
        match word {
            "smith" => Self::Separable,
            "smith-correlated" => Self::Correlated,
            "v-groove" => Self::Groove,
            _ => panic!("unknown shadowing {word}"),
        }
    }
}

/// D = 1 / (pi alpha_x alpha_y q^2), q = (h_x / alpha_x)^2 + (h_y / alpha_y)^2 + h_z^2.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Ggx {
    alpha2: DVec2,
    inverse: DVec2,
    height: f64,
}

impl Facets for Ggx {
    #[inline(always)]
    fn d<F: Elementary>(&self, half: &Half) -> f64 {
        let h = half.h;
        let q = square(h.x * self.inverse.x) + square(h.y * self.inverse.y) + h.z * h.z;
        self.height / (q * q)
    }

    #[inline(always)]
    fn cos_over_g1<F: Elementary>(&self, w: DVec3) -> f64 {
        let across = self.alpha2.x * (w.x * w.x) + self.alpha2.y * (w.y * w.y);
        0.5 * (w.z + (w.z * w.z + across).sqrt())
    }
}

/// D = exp(-slope^2) / (pi alpha_x alpha_y h_z^4), slope^2 = ((h_x / alpha_x)^2 +
/// (h_y / alpha_y)^2) / h_z^2.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Beckmann {
    alpha: DVec2,
    inverse: DVec2,
    height: f64,
}

impl Facets for Beckmann {
    #[inline(always)]
    fn d<F: Elementary>(&self, half: &Half) -> f64 {
        self.height * gaussian_over_cos4::<F>(half, self.inverse)
    }

    #[inline(always)]
    fn cos_over_g1<F: Elementary>(&self, w: DVec3) -> f64 {
        cos_over_g1_beckmann::<F>(square(self.alpha.x * w.x) + square(self.alpha.y * w.y), w.z)
    }
}

/// D = exp(-(theta / alpha)^2), scaled so that the projected areas integrate to 1.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Gaussian {
    alpha: f64,
    inverse: f64,
    height: f64,
}

impl Facets for Gaussian {
    #[inline(always)]
    fn d<F: Elementary>(&self, half: &Half) -> f64 {
        let theta = F::angle(half.sin2().sqrt(), half.h.z);
        self.height * F::exp(-square(theta * self.inverse))
    }

    #[inline(always)]
    fn cos_over_g1<F: Elementary>(&self, w: DVec3) -> f64 {
        cos_over_g1_isotropic::<F>(self.alpha, w)
    }
}

/// D = (n + 2) / (2 pi) (n . h)^n.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Blinn {
    alpha: f64,
    n: f64,
    height: f64,
}

impl Facets for Blinn {
    #[inline(always)]
    fn d<F: Elementary>(&self, half: &Half) -> f64 {
        self.height * F::pow(smaller(half.h.z, 1.0), self.n)
    }

    #[inline(always)]
    fn cos_over_g1<F: Elementary>(&self, w: DVec3) -> f64 {
        cos_over_g1_isotropic::<F>(self.alpha, w)
    }
}

/// Blinn's exponent with the same width as a Beckmann roughness, at least 0.
fn exponent(alpha: f64) -> f64 {
    (2.0 / (alpha * alpha) - 2.0).max(0.0)
}

#[inline(always)]
pub(super) fn square(x: f64) -> f64 {
    x * x
}

/// exp(-slope^2) / h_z^4, with the slope of [`Beckmann`]; `inverse` is 1 / alpha along x and y.
#[inline(always)]
pub(super) fn gaussian_over_cos4<F: Elementary>(half: &Half, inverse: DVec2) -> f64 {
    let h = half.h;
    let slope2 = (square(h.x * inverse.x) + square(h.y * inverse.y)) / (h.z * h.z);
    // One exponential of the sum, because 1 / cos^4 alone overflows where exp(-slope^2) is 0.
    F::exp(-slope2 - 4.0 * F::ln(h.z))
}

/// Masking of the equivalent Beckmann roughness, as in Walter 2007, section 5.2.
#[inline(always)]
fn cos_over_g1_isotropic<F: Elementary>(alpha: f64, w: DVec3) -> f64 {
    cos_over_g1_beckmann::<F>(alpha * alpha * (w.x * w.x + w.y * w.y), w.z)
}

/// cos / G1 for Beckmann, exact: G1 = 1 / (1 + L), L = (erf(a) - 1) / 2 + exp(-a^2) / (2 a
/// sqrt(pi)), a = cos / across. `across2` is across^2 = (alpha_x w_x)^2 + (alpha_y w_y)^2.
///
/// # Source
/// Smith 1967; Walter 2007, equation 27 and the text above it.
#[inline(always)]
fn cos_over_g1_beckmann<F: Elementary>(across2: f64, cos: f64) -> f64 {
    /// 1 / sqrt(pi)
    const FRAC_1_SQRT_PI: f64 = 0.5 * std::f64::consts::FRAC_2_SQRT_PI;
    let across = across2.sqrt();
    let a = cos / larger(across, f64::MIN_POSITIVE);
    // Beyond 6, L is below the rounding of f64, and `erf` is not defined.
    let is_open = a > 6.0;
    let a = smaller(a, 6.0);
    // cos (1 + L), with the pole of L at cos = 0 cancelled.
    let masked = 0.5 * (cos * (1.0 + F::erf(a)) + across * (FRAC_1_SQRT_PI * F::exp(-(a * a))));
    if is_open { cos } else { masked }
}

/// Integral of exp(-(theta / alpha)^2) cos(theta) over the hemisphere, by Simpson's rule to 1e-12.
fn gaussian_area(alpha: f64) -> f64 {
    const STEPS: u32 = 4096;
    let end = (0.5 * PI).min(8.0 * alpha);
    let step = end / f64::from(STEPS);
    let value = |k: u32| {
        let theta = step * f64::from(k);
        PI * libm::sin(2.0 * theta) * libm::exp(-(theta / alpha).powi(2))
    };
    let inner: f64 = (1..STEPS).map(|k| if k % 2 == 1 { 4.0 } else { 2.0 } * value(k)).sum();
    (value(0) + inner + value(STEPS)) * step / 3.0
}
