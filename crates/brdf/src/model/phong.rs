//! Phong's family: as published, where the highlight is of reflected light and no BRDF at all, and normalised.
//!
//! A highlight of reflected light becomes a BRDF over cos_i, which is neither reciprocal nor bounded at grazing light; that
//! is what the originals are, and the normalised BRDF form is what to use instead. Light of irradiance pi stands for the
//! originals' light of intensity 1.

use std::f64::consts::{FRAC_1_PI, PI};

use glam::DVec3;

use super::formula::{Formula, colors};
use super::parameter::{Parameter, Values};
use super::prepared::{Prepared, Reflect};
use super::{Claims, ModelConstants};
use crate::block::{Half, unit};
use crate::{Block, Elementary, Machine};

const DIFFUSE: Parameter =
    Parameter::color("diffuse", "k_d: of scattered light", [0.4; 3], (0.0, 1.0));
const SPECULAR: Parameter =
    Parameter::color("specular", "k_s: of the highlight", [0.3; 3], (0.0, 1.0));
const EXPONENT: Parameter =
    Parameter::scalar("exponent", "n: how narrow the highlight is", 30.0, (1.0, 100_000.0))
        .logarithmic();

pub(super) const PHONG: &[Parameter] = &[DIFFUSE, SPECULAR, EXPONENT];

/// What the power of a highlight is taken of, and what it is scaled by.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Highlight {
    /// (r . wo)^n of reflected light; r is wi mirrored at the normal. Phong 1975.
    Mirror,
    /// (n . h)^n of reflected light. Blinn 1977.
    Half,
    /// The same, scaled so that a mirror-like highlight at normal incidence reflects k_s.
    NormalisedHalf,
    /// A BRDF of (n . h)^n whose albedo is at most k_s. Akenine-Moller et al. 2008; normaliser after Giesen 2009.
    Brdf,
}

#[derive(Debug, Clone)]
pub(super) struct Phong {
    lobe: Lobe,
    highlight: Highlight,
    /// Whether diffuse and specular add up to 1 at most.
    whole: bool,
}

pub(super) fn phong(values: Values<'_>) -> Prepared {
    make(values, Highlight::Mirror)
}

pub(super) fn blinn_phong(values: Values<'_>) -> Prepared {
    make(values, Highlight::Half)
}

pub(super) fn reflected_blinn_phong(values: Values<'_>) -> Prepared {
    make(values, Highlight::NormalisedHalf)
}

pub(super) fn normalised_blinn_phong(values: Values<'_>) -> Prepared {
    make(values, Highlight::Brdf)
}

fn make(values: Values<'_>, highlight: Highlight) -> Prepared {
    let (diffuse, specular) = (values.color("diffuse"), values.color("specular"));
    let n = values.scalar("exponent");
    let narrow = libm::exp2(-0.5 * n);
    let height = match highlight {
        Highlight::Mirror | Highlight::Half => FRAC_1_PI,
        Highlight::NormalisedHalf => (n + 2.0) / (4.0 * PI * (2.0 - narrow)),
        Highlight::Brdf => (n + 2.0) * (n + 4.0) / (8.0 * PI * (n + narrow)),
    };
    let whole = (diffuse + specular).max_element() <= 1.0;
    let (diffuse, specular) = (diffuse * FRAC_1_PI, specular * height);
    Prepared::Phong(Phong { lobe: Lobe { diffuse, specular, n }, highlight, whole })
}

/// diffuse + specular (m . wo)^n / cos_i, m being mirrored wi.
struct Mirrored(Lobe);
/// diffuse + specular (n . h)^n / cos_i.
struct OverCosine(Lobe);
/// diffuse + specular (n . h)^n.
struct Bounded(Lobe);

/// With all that they are scaled by.
#[derive(Debug, Clone, Copy)]
struct Lobe {
    diffuse: DVec3,
    specular: DVec3,
    n: f64,
}

impl Lobe {
    #[inline(always)]
    fn at<F: Elementary>(&self, cosine: f64, over: f64) -> DVec3 {
        self.diffuse + self.specular * (F::pow(unit(cosine), self.n) / over)
    }
}

impl Formula for Mirrored {
    type Value = DVec3;

    #[inline(always)]
    fn at<F: Elementary>(&self, half: &Half, _: usize) -> DVec3 {
        let along = 2.0 * half.cos_i() * half.cos_o() - half.cos_io();
        self.0.at::<F>(along, half.cos_i())
    }
}

impl Formula for OverCosine {
    type Value = DVec3;

    #[inline(always)]
    fn at<F: Elementary>(&self, half: &Half, _: usize) -> DVec3 {
        self.0.at::<F>(half.h.z, half.cos_i())
    }
}

impl Formula for Bounded {
    type Value = DVec3;

    #[inline(always)]
    fn at<F: Elementary>(&self, half: &Half, _: usize) -> DVec3 {
        self.0.at::<F>(half.h.z, 1.0)
    }
}

impl Reflect for Phong {
    fn block<M: Machine, const N: usize>(&self, machine: M, block: &Block<N>) -> [[f64; N]; 3] {
        match self.highlight {
            Highlight::Mirror => colors(machine, block, Mirrored(self.lobe)),
            Highlight::Half | Highlight::NormalisedHalf => {
                colors(machine, block, OverCosine(self.lobe))
            }
            Highlight::Brdf => colors(machine, block, Bounded(self.lobe)),
        }
    }

    fn claims(&self) -> Claims {
        match self.highlight {
            Highlight::Mirror | Highlight::Half | Highlight::NormalisedHalf => Claims::default(),
            Highlight::Brdf => Claims { reciprocal: true, conserving: self.whole },
        }
    }

    fn constants(&self) -> ModelConstants {
        let Lobe { diffuse, specular, n } = self.lobe;
        ModelConstants::Phong { highlight: self.highlight, diffuse, specular, exponent: n }
    }
}
