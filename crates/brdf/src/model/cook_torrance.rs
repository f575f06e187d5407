//! Microfacet models: Cook and Torrance with Schlick's reflectance, metals by their optical constants, and a coat over a
//! diffuse base.

use std::f64::consts::FRAC_1_PI;

use glam::{DVec2, DVec3};

use super::diffuse::ALBEDO;
use super::fresnel;
use super::half::Half;
use super::microfacet::{DISTRIBUTIONS, Distribution, SHADOWINGS, Shadowing};
use super::parameter::{Parameter, Values};
use super::{Brdf, Claims};
use crate::DirectionPair;

const DISTRIBUTION: Parameter =
    Parameter::choice("distribution", "D: how the facets' normals are distributed", DISTRIBUTIONS);
const SHADOWING: Parameter =
    Parameter::choice("shadowing", "G: how facets hide each other", SHADOWINGS);
/// Also the width of the highlight: alpha of GGX, m of Beckmann.
pub(super) const ROUGHNESS: Parameter =
    Parameter::scalar("roughness", "slope of the facets, alpha or m", 0.2, (1e-4, 1.0))
        .logarithmic();
const STRETCH: Parameter = Parameter::scalar(
    "stretch",
    "log2 of roughness along u over that along v; 0: the same all around",
    0.0,
    (-4.0, 4.0),
);
const F0: Parameter =
    Parameter::color("f0", "reflectance at normal incidence", [0.04; 3], (0.0, 1.0));
const ETA: Parameter =
    Parameter::color("eta", "refractive index", [0.143, 0.375, 1.442], (0.02, 10.0)).logarithmic();
const K: Parameter =
    Parameter::color("k", "extinction", [3.983, 2.386, 1.603], (1e-3, 20.0)).logarithmic();
pub(super) const IOR: Parameter =
    Parameter::scalar("ior", "refractive index of the coat", 1.5, (1.01, 3.0)).logarithmic();

pub(super) const COOK_TORRANCE: &[Parameter] = &[
    Parameter::color("diffuse", "share of light that is scattered back", [0.0; 3], (0.0, 1.0)),
    F0,
    ROUGHNESS,
    STRETCH,
    DISTRIBUTION,
    SHADOWING,
];
pub(super) const CONDUCTOR: &[Parameter] = &[ETA, K, ROUGHNESS, STRETCH, DISTRIBUTION, SHADOWING];
pub(super) const COATED: &[Parameter] = &[ALBEDO, IOR, ROUGHNESS, STRETCH, DISTRIBUTION, SHADOWING];

/// What the facets are made of.
#[derive(Debug, Clone, Copy)]
enum Boundary {
    Schlick(DVec3),
    Conductor(DVec3, DVec3),
    Dielectric(f64),
}

/// f = diffuse / pi + D F G / (4 cos_i cos_o).
///
/// # Source
/// Cook and Torrance 1982 with 1/4 in place of 1/pi, which belongs to an unnormalised D: with 1/pi a white metal of m = 0.3
/// reflects 1.27 of the light.
struct Microfacet {
    diffuse: DVec3,
    boundary: Boundary,
    distribution: Distribution,
    shadowing: Shadowing,
}

pub(super) fn cook_torrance(values: Values<'_>) -> Box<dyn Brdf> {
    make(values, values.color("diffuse"), Boundary::Schlick(values.color("f0")))
}

pub(super) fn conductor(values: Values<'_>) -> Box<dyn Brdf> {
    make(values, DVec3::ZERO, Boundary::Conductor(values.color("eta"), values.color("k")))
}

pub(super) fn coated(values: Values<'_>) -> Box<dyn Brdf> {
    make(values, values.color("albedo"), Boundary::Dielectric(values.scalar("ior")))
}

fn make(values: Values<'_>, diffuse: DVec3, boundary: Boundary) -> Box<dyn Brdf> {
    let half_stretch = libm::exp2(0.5 * values.scalar("stretch"));
    let roughness = values.scalar("roughness");
    let alpha = DVec2::new(roughness * half_stretch, roughness / half_stretch);
    Box::new(Microfacet {
        diffuse,
        boundary,
        distribution: Distribution::named(values.choice("distribution"), alpha),
        shadowing: Shadowing::named(values.choice("shadowing")),
    })
}

impl Boundary {
    fn reflectance(&self, c: f64) -> DVec3 {
        match *self {
            Self::Schlick(f0) => fresnel::schlick(f0, c),
            Self::Conductor(eta, k) => DVec3::new(
                fresnel::conductor(eta.x, k.x, c),
                fresnel::conductor(eta.y, k.y, c),
                fresnel::conductor(eta.z, k.z, c),
            ),
            Self::Dielectric(eta) => DVec3::splat(fresnel::dielectric(eta, c)),
        }
    }

    /// What of the light is left for the base after passing the boundary twice.
    fn passed(&self, half: &Half) -> f64 {
        match *self {
            Self::Schlick(_) | Self::Conductor(..) => 1.0,
            Self::Dielectric(eta) => {
                let passes = |c| 1.0 - fresnel::dielectric(eta, c);
                passes(half.cos_i) * passes(half.cos_o)
            }
        }
    }
}

impl Brdf for Microfacet {
    fn f(&self, pair: &DirectionPair) -> DVec3 {
        let Some(half) = Half::of(pair) else { return DVec3::ZERO };
        let facets = self.distribution.d(&half)
            * self.distribution.visibility(self.shadowing, &half, pair.wi(), pair.wo());
        let base = self.diffuse * (FRAC_1_PI * self.boundary.passed(&half));
        base + self.boundary.reflectance(half.cos_d) * facets
    }

    fn claims(&self) -> Claims {
        // V-grooves belong to no distribution of normals but their own, and a diffuse part beside facets that keep nothing
        // from it adds up.
        let one_part =
            self.diffuse == DVec3::ZERO || matches!(self.boundary, Boundary::Dielectric(_));
        Claims { reciprocal: true, conserving: one_part && self.conserving_facets() }
    }
}

impl Microfacet {
    /// Smith's shadowing of the distribution that it was derived for.
    fn conserving_facets(&self) -> bool {
        let own = matches!(self.distribution, Distribution::Ggx(_) | Distribution::Beckmann(_));
        own && self.shadowing != Shadowing::Groove
    }
}
