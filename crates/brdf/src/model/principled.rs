//! Reflective parts of Burley's principled model.

use std::f64::consts::{FRAC_1_PI, PI};

use glam::{DVec2, DVec3};

use super::constants::{ClearCoatConstants, ModelConstants, PrincipledConstants, Shadowing};
use super::formula::{Formula, colors, scalars};
use super::fresnel;
use super::microfacet::{Distribution, square};
use super::parameter::{Parameter, Values};
use super::reflect::Reflect;
use crate::block::Half;
use crate::{Block, Claims, Elementary, Machine};

const UNIT: (f64, f64) = (0.0, 1.0);

pub(super) const PRINCIPLED: &[Parameter] = &[
    Parameter::color("base_color", "colour of the body, or of the metal", [0.5; 3], UNIT),
    Parameter::scalar("roughness", "of body and highlight; its square is alpha", 0.5, UNIT),
    Parameter::scalar("anisotropic", "how far the highlight is drawn out along u", 0.0, UNIT),
    Parameter::scalar("metallic", "0: a dielectric over a body; 1: a metal", 0.0, UNIT),
    Parameter::scalar("specular", "0.08 of it is the reflectance at normal incidence", 0.5, UNIT),
    Parameter::scalar("spec_tint", "how far the base colour tints the highlight", 0.0, UNIT),
    Parameter::scalar("sheen", "light from the side, as of cloth", 0.0, UNIT),
    Parameter::scalar("sheen_tint", "how far the base colour tints the sheen", 0.0, UNIT),
    Parameter::scalar("clearcoat", "a second, white highlight", 0.0, UNIT),
    Parameter::scalar("clearcoat_gloss", "how narrow that is", 1.0, UNIT),
    Parameter::choice(
        "coat_form",
        "burley: over 4 cos_i cos_o, as published; mitsuba: not",
        &["burley", "mitsuba"],
    ),
];

/// # Source
/// Burley 2012, "Physically-based shading at Disney". Fresnel term and parameters follow Mitsuba's
/// plugin, which uses the exact reflectance of a dielectric instead of Schlick's. Mitsuba's clear
/// coat omits 1 / (4 cos_i cos_o).
#[derive(Debug, Clone)]
pub(super) struct Principled {
    base: DVec3,
    /// Reflectance at normal incidence of the tinted part of the highlight.
    tinted_f0: DVec3,
    roughness: f64,
    metallic: f64,
    /// Refractive index whose reflectance at normal incidence is 0.08 times the parameter
    /// `specular`.
    eta: f64,
    spec_tint: f64,
    /// Colour times strength.
    sheen: DVec3,
    /// Clear coat, if its strength is above 0.
    coat: Option<Coat>,
    distribution: Distribution,
}

/// Clear coat, the second highlight.
///
/// # Source
/// Burley 2012, equation 4 of the appendix with gamma = 1.
#[derive(Debug, Clone)]
struct Coat {
    /// alpha^2 - 1
    narrow: f64,
    /// Strength times (alpha^2 - 1) / (pi ln alpha^2) / 4.
    height: f64,
    /// True for Burley's form, which is divided by 4 cos_i cos_o.
    published: bool,
}

/// Roughness for the clear coat's shadowing.
const COAT_SHADOWING: f64 = 0.25;
/// Luminance of linear sRGB.
const LUMINANCE: DVec3 = DVec3::new(0.212_671, 0.715_160, 0.072_169);
/// Reflectance of the clear coat at normal incidence.
const COAT_F0: f64 = 0.04;

pub(super) fn principled(values: Values<'_>) -> Principled {
    let base = values.color("base_color");
    let luminance = base.dot(LUMINANCE);
    let tint = if luminance > 0.0 { base / luminance } else { DVec3::ONE };
    let roughness = values.scalar("roughness");
    let aspect = (1.0 - 0.9 * values.scalar("anisotropic")).sqrt();
    let alpha = |value: f64| (roughness * roughness * value).max(0.001);
    let eta = 2.0 / (1.0 - (0.08 * values.scalar("specular")).sqrt()) - 1.0;
    let white = DVec3::ONE;
    Principled {
        base,
        tinted_f0: tint * square((eta - 1.0) / (eta + 1.0)),
        roughness,
        metallic: values.scalar("metallic"),
        eta,
        spec_tint: values.scalar("spec_tint"),
        sheen: (white + (tint - white) * values.scalar("sheen_tint")) * values.scalar("sheen"),
        coat: coat(values),
        distribution: Distribution::ggx(DVec2::new(alpha(1.0 / aspect), alpha(aspect))),
    }
}

fn coat(values: Values<'_>) -> Option<Coat> {
    let strength = values.scalar("clearcoat");
    let alpha = 0.1 + (0.001 - 0.1) * values.scalar("clearcoat_gloss");
    let narrow = alpha * alpha - 1.0;
    let height = 0.25 * strength * narrow / (PI * libm::log(alpha * alpha));
    let published = values.choice("coat_form") == "burley";
    (strength > 0.0).then_some(Coat { narrow, height, published })
}

/// cos / G1 of the clear coat.
#[inline(always)]
fn cos_over_g1_coat(cos: f64) -> f64 {
    const ALPHA2: f64 = COAT_SHADOWING * COAT_SHADOWING;
    0.5 * (cos + (cos * cos + ALPHA2 * (1.0 - cos * cos)).sqrt())
}

impl Coat {
    /// F D G times `over` / (cos_i cos_o). `over` is the part that the two forms differ in.
    #[inline(always)]
    fn at(&self, half: &Half, over: f64) -> f64 {
        let d = self.height / (1.0 + self.narrow * half.h.z * half.h.z);
        let (i, o) = (cos_over_g1_coat(half.cos_i()), cos_over_g1_coat(half.cos_o()));
        fresnel::schlick(DVec3::splat(COAT_F0), half.cos_d).x * d * (over / (i * o))
    }

    fn constants(&self) -> ClearCoatConstants {
        ClearCoatConstants {
            narrow: self.narrow,
            height: self.height,
            published: self.published,
            f0: COAT_F0,
            shadowing: COAT_SHADOWING,
        }
    }
}

/// Burley's form, divided by 4 cos_i cos_o.
struct BurleyForm<'a>(&'a Coat);
/// Mitsuba's form, without that division.
struct MitsubaForm<'a>(&'a Coat);

impl Formula for BurleyForm<'_> {
    type Value = f64;

    #[inline(always)]
    fn at<F: Elementary>(&self, half: &Half, _: usize) -> f64 {
        self.0.at(half, 0.25)
    }
}

impl Formula for MitsubaForm<'_> {
    type Value = f64;

    #[inline(always)]
    fn at<F: Elementary>(&self, half: &Half, _: usize) -> f64 {
        self.0.at(half, half.cos_i() * half.cos_o())
    }
}

/// The body plus the main highlight, whose `facets` are D G / (4 cos_i cos_o).
struct Uncoated<'a, const N: usize> {
    model: &'a Principled,
    facets: &'a [f64; N],
}

/// `Uncoated` plus the clear coat.
struct Coated<'a, const N: usize> {
    uncoated: Uncoated<'a, N>,
    coat: &'a [f64; N],
}

impl<const N: usize> Formula for Uncoated<'_, N> {
    type Value = DVec3;

    #[inline(always)]
    fn at<F: Elementary>(&self, half: &Half, k: usize) -> DVec3 {
        self.model.body(half) + self.model.reflectance(half.cos_d) * self.facets[k]
    }
}

impl<const N: usize> Formula for Coated<'_, N> {
    type Value = DVec3;

    #[inline(always)]
    fn at<F: Elementary>(&self, half: &Half, k: usize) -> DVec3 {
        self.uncoated.at::<F>(half, k) + DVec3::splat(self.coat[k])
    }
}

impl Principled {
    /// Body: darker at grazing angles where smooth, brighter there where rough.
    #[inline(always)]
    fn body(&self, half: &Half) -> DVec3 {
        let (fi, fo) =
            (fresnel::schlick_weight(half.cos_i()), fresnel::schlick_weight(half.cos_o()));
        let retro = 2.0 * self.roughness * half.cos_d * half.cos_d;
        let both = fi * fo;
        let even = (1.0 - 0.5 * fi) * (1.0 - 0.5 * fo);
        let back = retro * (fi + fo + both * (retro - 1.0));
        let sheen = self.sheen * fresnel::schlick_weight(half.cos_d);
        (self.base * (FRAC_1_PI * (even + back)) + sheen) * (1.0 - self.metallic)
    }

    /// Reflectance of the main highlight.
    #[inline(always)]
    fn reflectance(&self, c: f64) -> DVec3 {
        let dielectric = 1.0 - self.metallic;
        let even = (dielectric * (1.0 - self.spec_tint)) * fresnel::dielectric(self.eta, c);
        let tinted = fresnel::schlick(self.tinted_f0, c) * (dielectric * self.spec_tint);
        fresnel::schlick(self.base, c) * self.metallic + tinted + DVec3::splat(even)
    }
}

impl Reflect for Principled {
    fn block<M: Machine, const N: usize>(&self, machine: M, block: &Block<N>) -> [[f64; N]; 3] {
        let facets = &self.distribution.facets(Shadowing::Separable, machine, block);
        let uncoated = Uncoated { model: self, facets };
        let coat = match &self.coat {
            None => return colors(machine, block, uncoated),
            Some(coat) if coat.published => scalars(machine, block, BurleyForm(coat)),
            Some(coat) => scalars(machine, block, MitsubaForm(coat)),
        };
        colors(machine, block, Coated { uncoated, coat: &coat })
    }

    fn claims(&self) -> Claims {
        // Body, highlight, sheen and coat add up without reducing each other.
        Claims { reciprocal: true, conserving: false }
    }

    fn constants(&self) -> ModelConstants {
        ModelConstants::Principled(Box::new(PrincipledConstants {
            base: self.base,
            tinted_f0: self.tinted_f0,
            roughness: self.roughness,
            metallic: self.metallic,
            ior: self.eta,
            spec_tint: self.spec_tint,
            sheen: self.sheen,
            coat: self.coat.as_ref().map(Coat::constants),
            facets: self.distribution.constants(Shadowing::Separable),
        }))
    }
}
