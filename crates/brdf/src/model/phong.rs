//! Phong's family: as published, where the highlight is of reflected light and no BRDF at all, and normalised.
//!
//! A highlight of reflected light becomes a BRDF over cos_i, which is neither reciprocal nor bounded at grazing light; that
//! is what the originals are, and the normalised BRDF form is what to use instead. Light of irradiance pi stands for the
//! originals' light of intensity 1.

use std::f64::consts::{FRAC_1_PI, PI};

use glam::DVec3;

use super::half::Half;
use super::parameter::{Parameter, Values};
use super::{Brdf, Claims};
use crate::DirectionPair;

const DIFFUSE: Parameter =
    Parameter::color("diffuse", "k_d: of scattered light", [0.4; 3], (0.0, 1.0));
const SPECULAR: Parameter =
    Parameter::color("specular", "k_s: of the highlight", [0.3; 3], (0.0, 1.0));
const EXPONENT: Parameter =
    Parameter::scalar("exponent", "n: how narrow the highlight is", 30.0, (1.0, 100_000.0))
        .logarithmic();

pub(super) const PHONG: &[Parameter] = &[DIFFUSE, SPECULAR, EXPONENT];

/// What the power is taken of, and what it is scaled by.
#[derive(Debug, Clone, Copy)]
enum Highlight {
    /// (r . wo)^n of reflected light; r is wi mirrored at the normal. Phong 1975.
    Mirror,
    /// (n . h)^n of reflected light. Blinn 1977.
    Half,
    /// The same, scaled so that a mirror-like highlight at normal incidence reflects k_s.
    NormalisedHalf,
    /// A BRDF of (n . h)^n whose albedo is at most k_s. Akenine-Moller et al. 2008; normaliser after Giesen 2009.
    Brdf,
}

struct Phong {
    diffuse: DVec3,
    specular: DVec3,
    exponent: f64,
    highlight: Highlight,
}

pub(super) fn phong(values: Values<'_>) -> Box<dyn Brdf> {
    make(values, Highlight::Mirror)
}

pub(super) fn blinn_phong(values: Values<'_>) -> Box<dyn Brdf> {
    make(values, Highlight::Half)
}

pub(super) fn reflected_blinn_phong(values: Values<'_>) -> Box<dyn Brdf> {
    make(values, Highlight::NormalisedHalf)
}

pub(super) fn normalised_blinn_phong(values: Values<'_>) -> Box<dyn Brdf> {
    make(values, Highlight::Brdf)
}

fn make(values: Values<'_>, highlight: Highlight) -> Box<dyn Brdf> {
    Box::new(Phong {
        diffuse: values.color("diffuse"),
        specular: values.color("specular"),
        exponent: values.scalar("exponent"),
        highlight,
    })
}

impl Brdf for Phong {
    fn f(&self, pair: &DirectionPair) -> DVec3 {
        let Some(half) = Half::of(pair) else { return DVec3::ZERO };
        let n = self.exponent;
        let power = |cosine: f64| libm::pow(cosine.clamp(0.0, 1.0), n);
        let narrow = libm::exp2(-0.5 * n);
        let specular = match self.highlight {
            Highlight::Mirror => {
                let along = 2.0 * half.cos_i * half.cos_o - half.cos_io;
                FRAC_1_PI * power(along) / half.cos_i
            }
            Highlight::Half => FRAC_1_PI * power(half.h.z) / half.cos_i,
            Highlight::NormalisedHalf => {
                (n + 2.0) / (4.0 * PI * (2.0 - narrow)) * power(half.h.z) / half.cos_i
            }
            Highlight::Brdf => (n + 2.0) * (n + 4.0) / (8.0 * PI * (n + narrow)) * power(half.h.z),
        };
        self.diffuse * FRAC_1_PI + self.specular * specular
    }

    fn claims(&self) -> Claims {
        let whole = (self.diffuse + self.specular).max_element() <= 1.0;
        match self.highlight {
            Highlight::Mirror | Highlight::Half | Highlight::NormalisedHalf => Claims::default(),
            Highlight::Brdf => Claims { reciprocal: true, conserving: whole },
        }
    }
}
