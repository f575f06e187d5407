//! Burley's principled model: the parts of it that reflect.

use std::f64::consts::{FRAC_1_PI, PI};

use glam::{DVec2, DVec3};

use super::fresnel;
use super::half::Half;
use super::microfacet::{Distribution, Shadowing};
use super::parameter::{Parameter, Values};
use super::{Brdf, Claims};
use crate::DirectionPair;

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
/// Burley 2012, "Physically-based shading at Disney"; Fresnel term and parameters in the form of Mitsuba's plugin, which
/// takes the exact reflectance of a dielectric in place of Schlick's. Its clear coat leaves out 1 / (4 cos_i cos_o).
struct Principled {
    base: DVec3,
    /// The base colour at luminance 1.
    tint: DVec3,
    roughness: f64,
    metallic: f64,
    eta: f64,
    spec_tint: f64,
    sheen: DVec3,
    clearcoat: f64,
    coat_alpha: f64,
    coat_published: bool,
    distribution: Distribution,
}

/// Roughness of the clear coat's shadowing.
const COAT_SHADOWING: f64 = 0.25;
/// Luminance of linear sRGB.
const LUMINANCE: DVec3 = DVec3::new(0.212_671, 0.715_160, 0.072_169);
/// Reflectance of the clear coat at normal incidence.
const COAT_F0: f64 = 0.04;

pub(super) fn principled(values: Values<'_>) -> Box<dyn Brdf> {
    let base = values.color("base_color");
    let luminance = base.dot(LUMINANCE);
    let tint = if luminance > 0.0 { base / luminance } else { DVec3::ONE };
    let roughness = values.scalar("roughness");
    let aspect = (1.0 - 0.9 * values.scalar("anisotropic")).sqrt();
    let alpha = |value: f64| (roughness * roughness * value).max(0.001);
    let white = DVec3::ONE;
    Box::new(Principled {
        base,
        tint,
        roughness,
        metallic: values.scalar("metallic"),
        eta: 2.0 / (1.0 - (0.08 * values.scalar("specular")).sqrt()) - 1.0,
        spec_tint: values.scalar("spec_tint"),
        sheen: (white + (tint - white) * values.scalar("sheen_tint")) * values.scalar("sheen"),
        clearcoat: values.scalar("clearcoat"),
        coat_alpha: 0.1 + (0.001 - 0.1) * values.scalar("clearcoat_gloss"),
        coat_published: values.choice("coat_form") == "burley",
        distribution: Distribution::Ggx(DVec2::new(alpha(1.0 / aspect), alpha(aspect))),
    })
}

impl Principled {
    /// (1 - c)^5
    fn weight(c: f64) -> f64 {
        (1.0 - c).clamp(0.0, 1.0).powi(5)
    }

    /// The body: darker at grazing light where it is smooth, brighter where it is rough.
    fn body(&self, half: &Half) -> DVec3 {
        let (fi, fo) = (Self::weight(half.cos_i), Self::weight(half.cos_o));
        let retro = 2.0 * self.roughness * half.cos_d * half.cos_d;
        let both = fi * fo;
        let even = (1.0 - 0.5 * fi) * (1.0 - 0.5 * fo);
        let back = retro * (fi + fo + both * (retro - 1.0));
        let sheen = self.sheen * Self::weight(half.cos_d);
        (self.base * (FRAC_1_PI * (even + back)) + sheen) * (1.0 - self.metallic)
    }

    /// What the main highlight reflects.
    fn reflectance(&self, c: f64) -> DVec3 {
        let dielectric = 1.0 - self.metallic;
        let even = (dielectric * (1.0 - self.spec_tint)) * fresnel::dielectric(self.eta, c);
        let f0 = ((self.eta - 1.0) / (self.eta + 1.0)).powi(2);
        let tinted = fresnel::schlick(self.tint * f0, c) * (dielectric * self.spec_tint);
        fresnel::schlick(self.base, c) * self.metallic + tinted + DVec3::splat(even)
    }

    /// The second highlight.
    fn coat(&self, half: &Half, pair: &DirectionPair) -> f64 {
        if self.clearcoat <= 0.0 {
            return 0.0;
        }
        let alpha2 = self.coat_alpha * self.coat_alpha;
        // Burley 2012, equation 4 of the appendix: gamma = 1.
        let d = (alpha2 - 1.0)
            / (PI * libm::log(alpha2) * (1.0 + (alpha2 - 1.0) * half.h.z * half.h.z));
        let shadowing = Distribution::Ggx(DVec2::splat(COAT_SHADOWING));
        let visible = shadowing.visibility(Shadowing::Separable, half, pair.wi(), pair.wo());
        let seen =
            if self.coat_published { visible } else { visible * (4.0 * half.cos_i * half.cos_o) };
        0.25 * self.clearcoat * fresnel::schlick(DVec3::splat(COAT_F0), half.cos_d).x * d * seen
    }
}

impl Brdf for Principled {
    fn f(&self, pair: &DirectionPair) -> DVec3 {
        let Some(half) = Half::of(pair) else { return DVec3::ZERO };
        let facets = self.distribution.d(&half)
            * self.distribution.visibility(Shadowing::Separable, &half, pair.wi(), pair.wo());
        self.body(&half)
            + self.reflectance(half.cos_d) * facets
            + DVec3::splat(self.coat(&half, pair))
    }

    fn claims(&self) -> Claims {
        // Body, highlight, sheen and coat are added without taking from each other.
        Claims { reciprocal: true, conserving: false }
    }
}
