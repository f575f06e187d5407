//! Phong's family: as published, where the highlight is reflected radiance and not a BRDF, and
//! normalised.
//!
//! A highlight of reflected radiance becomes a BRDF by division by cos_i, which is neither
//! reciprocal nor bounded at grazing light. The originals are kept that way; the normalised BRDF
//! form is the one to use. Light of irradiance pi stands for the originals' light of intensity 1.

use std::f64::consts::{FRAC_1_PI, PI};

use glam::DVec3;

use super::constants::{ModelConstants, PhongHighlight};
use super::formula::{Formula, colors};
use super::parameter::{Parameter, Values};
use super::reflect::Reflect;
use crate::block::{Half, unit};
use crate::{Block, Claims, Elementary, Machine};

const DIFFUSE: Parameter =
    Parameter::color("diffuse", "k_d: coefficient of scattered light", [0.4; 3], (0.0, 1.0));
const SPECULAR: Parameter =
    Parameter::color("specular", "k_s: coefficient of the highlight", [0.3; 3], (0.0, 1.0));
const EXPONENT: Parameter =
    Parameter::scalar("exponent", "n: how narrow the highlight is", 30.0, (1.0, 100_000.0))
        .logarithmic();

pub(super) const PHONG: &[Parameter] = &[DIFFUSE, SPECULAR, EXPONENT];

/// A diffuse part and a highlight of any of the forms.
#[derive(Debug, Clone)]
pub(super) struct Phong {
    lobe: Lobe,
    highlight: PhongHighlight,
    /// True if diffuse and specular albedo add up to at most 1.
    is_conserving: bool,
}

pub(super) fn phong(values: Values<'_>) -> Phong {
    make(values, PhongHighlight::Mirror)
}

pub(super) fn blinn_phong(values: Values<'_>) -> Phong {
    make(values, PhongHighlight::Half)
}

pub(super) fn reflected_blinn_phong(values: Values<'_>) -> Phong {
    make(values, PhongHighlight::NormalisedHalf)
}

pub(super) fn normalised_blinn_phong(values: Values<'_>) -> Phong {
    make(values, PhongHighlight::Brdf)
}

fn make(values: Values<'_>, highlight: PhongHighlight) -> Phong {
    let (diffuse, specular) = (values.color("diffuse"), values.color("specular"));
    let n = values.scalar("exponent");
    let narrow = libm::exp2(-0.5 * n);
    let height = match highlight {
        PhongHighlight::Mirror | PhongHighlight::Half => FRAC_1_PI,
        PhongHighlight::NormalisedHalf => (n + 2.0) / (4.0 * PI * (2.0 - narrow)),
        PhongHighlight::Brdf => (n + 2.0) * (n + 4.0) / (8.0 * PI * (n + narrow)),
    };
    let is_conserving = (diffuse + specular).max_element() <= 1.0;
    let (diffuse, specular) = (diffuse * FRAC_1_PI, specular * height);
    Phong { lobe: Lobe { diffuse, specular, n }, highlight, is_conserving }
}

/// diffuse + specular (m . wo)^n / cos_i, where m is wi mirrored at the normal.
struct Mirrored(Lobe);
/// diffuse + specular (n . h)^n / cos_i.
struct OverCosine(Lobe);
/// diffuse + specular (n . h)^n.
struct Bounded(Lobe);

/// Coefficients with their normalisation, and the exponent.
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
            PhongHighlight::Mirror => colors(machine, block, Mirrored(self.lobe)),
            PhongHighlight::Half | PhongHighlight::NormalisedHalf => {
                colors(machine, block, OverCosine(self.lobe))
            }
            PhongHighlight::Brdf => colors(machine, block, Bounded(self.lobe)),
        }
    }

    fn claims(&self) -> Claims {
        match self.highlight {
            PhongHighlight::Mirror | PhongHighlight::Half | PhongHighlight::NormalisedHalf => {
                Claims::default()
            }
            PhongHighlight::Brdf => Claims { reciprocal: true, conserving: self.is_conserving },
        }
    }

    fn constants(&self) -> ModelConstants {
        let Lobe { diffuse, specular, n } = self.lobe;
        ModelConstants::Phong { highlight: self.highlight, diffuse, specular, exponent: n }
    }
}
