//! Microfacet models: Cook and Torrance with Schlick's reflectance, metals with their optical
//! constants, and a coat over a diffuse base.

use std::f64::consts::FRAC_1_PI;

use glam::{DVec2, DVec3};

use super::constants::{ModelConstants, Shadowing};
use super::formula::{Formula, colors};
use super::fresnel::{self, Conductor};
use super::microfacet::{DISTRIBUTIONS, Distribution, SHADOWINGS};
use super::parameter::{ALBEDO, IOR, Parameter, ROUGHNESS, Values};
use super::reflect::Reflect;
use crate::block::Half;
use crate::{Block, Claims, Elementary, Machine};

const DISTRIBUTION: Parameter =
    Parameter::choice("distribution", "D: how the facets' normals are distributed", DISTRIBUTIONS);
const SHADOWING: Parameter =
    Parameter::choice("shadowing", "G: how facets hide each other", SHADOWINGS);
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

/// Reflectance of the facets.
#[derive(Debug, Clone, Copy)]
enum Boundary {
    Schlick(DVec3),
    Conductor([Conductor; 3]),
    Dielectric(f64),
}

/// f = diffuse / pi + D F G / (4 cos_i cos_o).
///
/// # Source
/// Cook and Torrance 1982 with 1/4 in place of 1/pi, which belongs to an unnormalised D: with 1/pi
/// a white metal of m = 0.3 reflects 1.27 of the incident light.
#[derive(Debug, Clone)]
pub(super) struct Microfacet {
    /// Diffuse albedo over pi.
    diffuse: DVec3,
    boundary: Boundary,
    distribution: Distribution,
    shadowing: Shadowing,
}

pub(super) fn cook_torrance(values: Values<'_>) -> Microfacet {
    make(values, values.color("diffuse"), Boundary::Schlick(values.color("f0")))
}

pub(super) fn conductor(values: Values<'_>) -> Microfacet {
    let (eta, k) = (values.color("eta"), values.color("k"));
    let metals = [0, 1, 2].map(|channel| Conductor::new(eta[channel], k[channel]));
    make(values, DVec3::ZERO, Boundary::Conductor(metals))
}

pub(super) fn coated(values: Values<'_>) -> Microfacet {
    make(values, values.color("albedo"), Boundary::Dielectric(values.scalar("ior")))
}

fn make(values: Values<'_>, diffuse: DVec3, boundary: Boundary) -> Microfacet {
    let half_stretch = libm::exp2(0.5 * values.scalar("stretch"));
    let roughness = values.scalar("roughness");
    let alpha = DVec2::new(roughness * half_stretch, roughness / half_stretch);
    Microfacet {
        diffuse: diffuse * FRAC_1_PI,
        boundary,
        distribution: Distribution::named(values.choice("distribution"), alpha),
        shadowing: Shadowing::named(values.choice("shadowing")),
    }
}

/// Formula of [`Microfacet`] with the boundary as a type, so that the loop has no branch.
struct Bounded<'a, B, const N: usize> {
    diffuse: DVec3,
    boundary: B,
    /// D G / (4 cos_i cos_o) of each lane.
    facets: &'a [f64; N],
}

/// Boundary with Schlick's reflectance, given that at normal incidence.
struct Schlick(DVec3);
/// Boundary to a metal, for each channel.
struct Metal<'a>(&'a [Conductor; 3]);
/// Boundary to a dielectric, by its refractive index.
struct Coat(f64);

impl<const N: usize> Formula for Bounded<'_, Schlick, N> {
    type Value = DVec3;

    #[inline(always)]
    fn at<F: Elementary>(&self, half: &Half, k: usize) -> DVec3 {
        self.diffuse + fresnel::schlick(self.boundary.0, half.cos_d) * self.facets[k]
    }
}

impl<const N: usize> Formula for Bounded<'_, Metal<'_>, N> {
    type Value = DVec3;

    #[inline(always)]
    fn at<F: Elementary>(&self, half: &Half, k: usize) -> DVec3 {
        let [red, green, blue] = self.boundary.0;
        let reflected = DVec3::new(
            red.reflectance(half.cos_d),
            green.reflectance(half.cos_d),
            blue.reflectance(half.cos_d),
        );
        reflected * self.facets[k]
    }
}

impl<const N: usize> Formula for Bounded<'_, Coat, N> {
    type Value = DVec3;

    #[inline(always)]
    fn at<F: Elementary>(&self, half: &Half, k: usize) -> DVec3 {
        let Coat(eta) = self.boundary;
        // Share of the light that passes the boundary twice and reaches the base.
        let passes = |c| 1.0 - fresnel::dielectric(eta, c);
        let passed = passes(half.cos_i()) * passes(half.cos_o());
        let reflected = fresnel::dielectric(eta, half.cos_d) * self.facets[k];
        self.diffuse * passed + DVec3::splat(reflected)
    }
}

impl Reflect for Microfacet {
    fn block<M: Machine, const N: usize>(&self, machine: M, block: &Block<N>) -> [[f64; N]; 3] {
        let facets = &self.distribution.facets(self.shadowing, machine, block);
        let diffuse = self.diffuse;
        match &self.boundary {
            Boundary::Schlick(f0) => {
                colors(machine, block, Bounded { diffuse, boundary: Schlick(*f0), facets })
            }
            Boundary::Conductor(metals) => {
                colors(machine, block, Bounded { diffuse, boundary: Metal(metals), facets })
            }
            Boundary::Dielectric(eta) => {
                colors(machine, block, Bounded { diffuse, boundary: Coat(*eta), facets })
            }
        }
    }

    fn claims(&self) -> Claims {
        // V-grooves conserve energy only with their own distribution, and a diffuse part that
        // the facets do not shade adds to their albedo.
        let one_part =
            self.diffuse == DVec3::ZERO || matches!(self.boundary, Boundary::Dielectric(_));
        Claims { reciprocal: true, conserving: one_part && self.conserving_facets() }
    }

    fn constants(&self) -> ModelConstants {
        let (diffuse, facets) = (self.diffuse, self.distribution.constants(self.shadowing));
        match self.boundary {
            Boundary::Schlick(f0) => ModelConstants::CookTorrance { diffuse, f0, facets },
            Boundary::Conductor(metals) => {
                let metals = metals.map(|metal| metal.constants());
                ModelConstants::Conductor { metals, facets }
            }
            Boundary::Dielectric(ior) => ModelConstants::Coated { base: diffuse, ior, facets },
        }
    }
}

impl Microfacet {
    /// True if the shadowing is Smith's and derived for this distribution.
    fn conserving_facets(&self) -> bool {
        let own = matches!(self.distribution, Distribution::Ggx(_) | Distribution::Beckmann(_));
        own && self.shadowing != Shadowing::Groove
    }
}
