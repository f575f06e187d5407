//! Microfacets: how their normals are distributed, and how they shadow and mask each other.
//!
//! Each function is finite and non-negative down to the least roughness of the parameter tables and for any cosines above 0;
//! shadowing is computed together with the 1 / (4 cos_i cos_o) that goes with it, which alone would be infinite at grazing
//! angles.

use std::f64::consts::PI;

use glam::{DVec2, DVec3};

use super::half::Half;

/// Distribution of the facets' normals; with its roughness along x and along y.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Distribution {
    /// Trowbridge and Reitz 1975, named GGX by Walter 2007.
    Ggx(DVec2),
    /// Beckmann 1963, normalised as in Walter 2007, equation 25.
    Beckmann(DVec2),
    /// Torrance and Sparrow 1967: a Gaussian of the angle, scaled by the number so that projected areas add up to 1.
    Gaussian(f64, f64),
    /// Blinn 1977, normalised: (n + 2) / (2 pi) (n . h)^n with n = 2 / alpha^2 - 2.
    Blinn(f64),
}

/// How facets hide each other.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Shadowing {
    /// Cook and Torrance 1982: V-shaped grooves.
    Groove,
    /// Smith 1967, independently for both directions.
    Separable,
    /// Smith, both directions seen at the same height (Heitz 2014, equation 99).
    Correlated,
}

/// What the tables call the distributions, in the order in which [`Distribution::named`] knows them.
pub(super) const DISTRIBUTIONS: &[&str] = &["ggx", "beckmann", "gaussian", "blinn-phong"];
/// What the tables call the kinds of shadowing.
pub(super) const SHADOWINGS: &[&str] = &["smith", "smith-correlated", "v-groove"];

impl Distribution {
    /// # Panics
    /// Where it is none of [`DISTRIBUTIONS`]. Only the first two know a direction: the others take the mean roughness.
    pub(super) fn named(word: &str, alpha: DVec2) -> Self {
        let mean = (alpha.x * alpha.y).sqrt();
        match word {
            "ggx" => Self::Ggx(alpha),
            "beckmann" => Self::Beckmann(alpha),
            "gaussian" => Self::Gaussian(mean, 1.0 / gaussian_area(mean)),
            "blinn-phong" => Self::Blinn(mean),
            _ => panic!("there is no distribution {word}"),
        }
    }

    /// D(h) in 1/sr: the integral of D (n . h) over the hemisphere is 1.
    pub(super) fn d(&self, half: &Half) -> f64 {
        let h = half.h;
        match *self {
            Self::Ggx(alpha) => {
                let q = (h.x / alpha.x).powi(2) + (h.y / alpha.y).powi(2) + h.z * h.z;
                1.0 / (PI * alpha.x * alpha.y * q * q)
            }
            Self::Beckmann(alpha) => {
                let slope2 = ((h.x / alpha.x).powi(2) + (h.y / alpha.y).powi(2)) / (h.z * h.z);
                // 1 / cos^4 alone overflows where the exponential is 0 already.
                let steep = -slope2 - 4.0 * libm::log(h.z);
                libm::exp(steep) / (PI * alpha.x * alpha.y)
            }
            Self::Gaussian(alpha, scale) => {
                let theta = libm::atan2(libm::hypot(h.x, h.y), h.z);
                scale * libm::exp(-(theta / alpha).powi(2))
            }
            Self::Blinn(alpha) => {
                let n = exponent(alpha);
                (n + 2.0) / (2.0 * PI) * libm::pow(h.z.min(1.0), n)
            }
        }
    }

    /// G / (4 cos_i cos_o): the share of facets that are seen and lit, over what a flat surface would show of them.
    pub(super) fn visibility(
        &self,
        shadowing: Shadowing,
        half: &Half,
        wi: DVec3,
        wo: DVec3,
    ) -> f64 {
        match shadowing {
            Shadowing::Groove => {
                let most = half.cos_i.max(half.cos_o);
                let flat = 1.0 / (4.0 * half.cos_i * half.cos_o);
                flat.min(half.h.z / (2.0 * half.cos_d * most))
            }
            Shadowing::Separable => 0.25 * (self.masking(wi) * self.masking(wo)),
            Shadowing::Correlated => {
                // 1 + L(i) + L(o) of 1 / (1 + L) = cos masking.
                let (i, o) = (self.masking(wi), self.masking(wo));
                let both = i * o;
                0.25 * both / (half.cos_o * o + half.cos_i * i - half.cos_i * half.cos_o * both)
            }
        }
    }

    /// Smith's G1(w) / cos(w), finite at the horizon.
    pub(super) fn masking(&self, w: DVec3) -> f64 {
        match *self {
            Self::Ggx(alpha) => {
                let across = (alpha.x * w.x).powi(2) + (alpha.y * w.y).powi(2);
                2.0 / (w.z + (w.z * w.z + across).sqrt())
            }
            Self::Beckmann(alpha) => {
                masking_beckmann(libm::hypot(alpha.x * w.x, alpha.y * w.y), w.z)
            }
            // Walter 2007, section 5.2: the shadowing of Beckmann at the roughness that looks alike.
            Self::Gaussian(alpha, _) | Self::Blinn(alpha) => {
                masking_beckmann(alpha * libm::hypot(w.x, w.y), w.z)
            }
        }
    }
}

impl Shadowing {
    /// # Panics
    /// Where it is none of [`SHADOWINGS`].
    pub(super) fn named(word: &str) -> Self {
        match word {
            "smith" => Self::Separable,
            "smith-correlated" => Self::Correlated,
            "v-groove" => Self::Groove,
            _ => panic!("there is no shadowing {word}"),
        }
    }
}

/// Blinn's exponent that is as wide as Beckmann's roughness, at least 0.
fn exponent(alpha: f64) -> f64 {
    (2.0 / (alpha * alpha) - 2.0).max(0.0)
}

/// G1 / cos for Beckmann, exactly: G1 = 1 / (1 + L), L = (erf(a) - 1) / 2 + exp(-a^2) / (2 a sqrt(pi)), a = cos / across.
///
/// # Source
/// Smith 1967; Walter 2007, equation 27 and the text above it.
fn masking_beckmann(across: f64, cos: f64) -> f64 {
    let a = cos / across.max(f64::MIN_POSITIVE);
    if a > 6.0 {
        return 1.0 / cos;
    }
    let root_pi = PI.sqrt();
    // 1 / (cos (1 + L)) with the pole of L at cos = 0 taken out of the denominator.
    2.0 / (cos * (1.0 + libm::erf(a)) + across * libm::exp(-a * a) / root_pi)
}

/// The integral of exp(-(theta / alpha)^2) cos(theta) over the hemisphere, by Simpson's rule to 1e-12.
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
