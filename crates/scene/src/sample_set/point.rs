//! From a hit to what lights and eye see of it.

use std::ops::Range;

use brood_brdf::DirectionPair;
use glam::{DVec2, DVec3, Vec3};

use super::frame::ShadedPoint;
use super::lighting::PointLight;
use super::round_to_f32;
use crate::Mesh;
use crate::mesh::MeshParts;
use crate::trace::{Hit, Ray};

/// What hits are made into points with.
pub(super) struct Surface<'a> {
    parts: &'a MeshParts,
    mesh: &'a Mesh,
    lights: Vec<PointLight>,
    /// 1 over the sum of the lights' irradiance at the centre of the mesh, so that shades are about 1 at most.
    shade_scale: f64,
}

/// One light on one point.
#[derive(Debug, Clone, Copy)]
pub(super) struct Lit {
    pub light: usize,
    pub wi: DVec3,
    /// Irradiance times cosine.
    pub irradiance: [f64; 3],
}

/// A point of the surface with the lights in front of it.
#[derive(Debug, Clone, Default)]
pub(super) struct Point {
    pub mark: Mark,
    pub uv: DVec2,
    pub wo: DVec3,
    pub lit: Vec<Lit>,
}

/// What neighbours compare. Default: nothing is seen.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(super) struct Mark {
    /// Whether the mesh is seen.
    pub covered: bool,
    /// Which lights reach it, a bit each.
    pub lights: u32,
    /// Normal and place, in the unit frame.
    pub n: Vec3,
    pub place: Vec3,
    /// Irradiance times cosine over all lights, relative to that at normal incidence.
    pub shade: f32,
}

/// Normals that differ by more than 26 degrees are a crease.
const CREASE_COS: f32 = 0.9;
/// Places are on two surfaces where the way from one to the other leaves a tangent plane by more than 24 degrees.
const STEP_SIN: f32 = 0.4;

impl Mark {
    /// Whether both see one smooth piece of surface in the same light.
    pub fn is_like(&self, other: &Self) -> bool {
        if self.covered != other.covered || self.lights != other.lights {
            return false;
        }
        if !self.covered {
            return true;
        }
        let way = other.place - self.place;
        let off = self.n.dot(way).abs().max(other.n.dot(way).abs());
        self.n.dot(other.n) >= CREASE_COS && off <= STEP_SIN * way.length()
    }
}

impl<'a> Surface<'a> {
    pub fn new(mesh: &'a Mesh, lights: Vec<PointLight>) -> Self {
        let brightest = |light: &PointLight| {
            light.at(DVec3::ZERO).map_or(0.0, |(_, [r, g, b])| r.max(g).max(b))
        };
        let all: f64 = lights.iter().map(brightest).sum();
        let shade_scale = if all > 0.0 && all.is_finite() { 1.0 / all } else { 0.0 };
        Self { parts: mesh.parts(), mesh, lights, shade_scale }
    }

    /// Makes `point` the point of a hit. Reuses its memory.
    pub fn look(&self, hit: &Hit, ray: Ray, point: &mut Point) {
        let shaded = ShadedPoint::new(self.parts, hit, -ray.direction);
        let place = (shaded.place - self.mesh.centre()) / self.mesh.radius();
        point.lit.clear();
        let (mut mask, mut shade) = (0, 0.0);
        for (index, light) in self.lights.iter().enumerate() {
            let Some((towards, irradiance)) = light.at(place) else { continue };
            let wi = shaded.local(towards);
            // NaN, which a light beyond all reason could make, is unlit.
            if wi.z > 0.0 {
                mask |= 1 << index;
                let irradiance = irradiance.map(|e| e * wi.z);
                shade += irradiance[0].max(irradiance[1]).max(irradiance[2]);
                point.lit.push(Lit { light: index, wi, irradiance });
            }
        }
        point.uv = shaded.uv;
        point.wo = shaded.wo;
        point.mark = Mark {
            covered: true,
            lights: mask,
            n: shaded.n.as_vec3(),
            place: place.as_vec3(),
            shade: round_to_f32(shade * self.shade_scale),
        };
    }
}

/// Samples in the making, with the pixels they belong to.
#[derive(Default)]
pub(super) struct Gathered {
    pub pairs: Vec<DirectionPair>,
    pub uvs: Vec<DVec2>,
    pub irradiance: [Vec<f32>; 3],
}

impl Gathered {
    pub fn count(&self) -> u32 {
        u32::try_from(self.pairs.len()).expect("an image has fewer than 2^32 samples")
    }

    pub fn push(&mut self, wi: DVec3, wo: DVec3, uv: DVec2, irradiance: [f64; 3]) {
        self.pairs.push(DirectionPair::new(wi, wo).expect("both have just been normalised"));
        self.uvs.push(uv);
        for (channel, e) in self.irradiance.iter_mut().zip(irradiance) {
            channel.push(round_to_f32(e));
        }
    }

    /// One sample for every light on the point.
    pub fn push_point(&mut self, point: &Point) {
        for lit in &point.lit {
            self.push(lit.wi, point.wo, point.uv, lit.irradiance);
        }
    }

    pub fn with_capacity(count: usize) -> Self {
        Self {
            pairs: Vec::with_capacity(count),
            uvs: Vec::with_capacity(count),
            irradiance: [(); 3].map(|()| Vec::with_capacity(count)),
        }
    }

    pub fn extend(&mut self, other: &Self, range: Range<usize>) {
        self.pairs.extend_from_slice(&other.pairs[range.clone()]);
        self.uvs.extend_from_slice(&other.uvs[range.clone()]);
        for (all, more) in self.irradiance.iter_mut().zip(&other.irradiance) {
            all.extend_from_slice(&more[range.clone()]);
        }
    }

    pub fn append(&mut self, other: &mut Self) {
        self.pairs.append(&mut other.pairs);
        self.uvs.append(&mut other.uvs);
        for (all, more) in self.irradiance.iter_mut().zip(&mut other.irradiance) {
            all.append(more);
        }
    }
}
