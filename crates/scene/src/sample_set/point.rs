//! From a hit to what lights and eye see of it.

use std::ops::Range;

use brood_brdf::DirectionPair;
use glam::{DVec2, DVec3, Vec3};

use super::frame::ShadedPoint;
use super::lighting::{Lamp, Receiver};
use super::round_to_f32;
use crate::mesh::MeshParts;
use crate::trace::{Hit, Ray, Stack, Tracer};
use crate::{Mesh, Normals, Scene};

/// What hits are made into points with.
pub(super) struct Surface<'a> {
    parts: &'a MeshParts,
    mesh: &'a Mesh,
    lamps: Vec<Lamp>,
    /// What is in the way of light; `None` where nothing is.
    obstacles: Option<&'a Tracer>,
    normals: Normals,
    /// 1 over the sum of the lights' irradiance at the centre of the mesh, so that shades are about 1 at most.
    shade_scale: f64,
}

/// A ray of the camera, and what the samples of lights are drawn by where it hits.
#[derive(Debug, Clone, Copy)]
pub(super) struct Sight {
    pub ray: Ray,
    pub seed: u64,
}

/// How far above the surface rays to the lights start, in the unit frame: far more than rounding, far less than is seen.
const START_ABOVE: f64 = 1e-6;

/// One sample of a light on one point.
#[derive(Debug, Clone, Copy)]
pub(super) struct Lit {
    /// Number of the sample among those of all lights.
    pub slot: usize,
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
    /// Samples of lights that were not made because nothing arrives.
    pub skipped: u64,
    /// Samples of lights that were not made because something is in the way.
    pub shadowed: u64,
}

/// What neighbours compare. Default: nothing is seen.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(super) struct Mark {
    /// Whether the mesh is seen.
    pub covered: bool,
    /// Which lights reach it, a bit each.
    pub lights: u32,
    /// Which of them are on their way to nothing there, a bit each.
    pub fading: u32,
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
        // From light to half-light and from there to the dark is no edge.
        let differ = (self.lights ^ other.lights) & !(self.fading | other.fading);
        if self.covered != other.covered || differ != 0 {
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
    pub fn new(mesh: &'a Mesh, lamps: Vec<Lamp>, scene: &Scene) -> Self {
        let all: f64 = lamps.iter().map(Lamp::usual).sum();
        let shade_scale = if all > 0.0 && all.is_finite() { 1.0 / all } else { 0.0 };
        let obstacles = scene.shadows.then(|| mesh.tracer());
        Self { parts: mesh.parts(), mesh, lamps, obstacles, normals: scene.normals, shade_scale }
    }

    /// Makes `point` the point of a hit. Reuses its memory.
    pub fn look(&self, hit: &Hit, sight: Sight, stack: &mut Stack, point: &mut Point) {
        let Sight { ray, seed } = sight;
        let shaded = ShadedPoint::new(self.parts, hit, -ray.direction);
        let place = self.in_unit_frame(shaded.place);
        let start = self.obstacles.map(|tracer| {
            let start = self.in_unit_frame(shaded.shadow_start(self.normals, self.parts, hit));
            (tracer, start + shaded.face() * START_ABOVE)
        });
        let Point { lit, skipped, shadowed, .. } = point;
        lit.clear();
        let (mut mask, mut fading, mut shade) = (0, 0, 0.0);
        (*skipped, *shadowed) = (0, 0);
        let reflects = shaded.reflects(self.normals);
        for (index, lamp) in self.lamps.iter().enumerate() {
            if !reflects {
                *skipped += u64::from(lamp.samples);
                continue;
            }
            let (before, shadowed_before) = (lit.len(), *shadowed);
            let (mut fades, soft) = (false, lamp.is_soft());
            lamp.arrivals(&Receiver { place, shaded: &shaded, seed }, |sample, arrival| {
                let wi = shaded.local(arrival.towards);
                // NaN, which a light beyond all reason could make, is unlit.
                if wi.z > 0.0 {
                    if let Some((tracer, start)) = start {
                        let ray = Ray { origin: start, direction: arrival.towards };
                        if tracer.is_occluded(ray, arrival.distance, stack) {
                            *shadowed += 1;
                            return;
                        }
                    }
                    fades |= arrival.fading;
                    let irradiance = arrival.irradiance.map(|e| e * wi.z);
                    if !soft {
                        shade += irradiance[0].max(irradiance[1]).max(irradiance[2]);
                    }
                    lit.push(Lit { slot: lamp.first_slot + sample as usize, wi, irradiance });
                }
            });
            let made = u64::try_from(lit.len() - before).expect("lights have few samples");
            let all = u64::from(lamp.samples);
            *skipped += all - made - (*shadowed - shadowed_before);
            mask |= u32::from(made > 0) << index;
            // Partly in the light of a lamp that has extent: there is no edge. One sample alone cannot tell.
            let partly = soft && (made < all || all == 1);
            fading |= u32::from(fades || (made > 0 && partly)) << index;
            if soft {
                shade += lamp.outline(place, shaded.n);
            }
        }
        point.uv = shaded.uv;
        point.wo = shaded.wo;
        point.mark = Mark {
            covered: true,
            lights: mask,
            fading,
            n: shaded.n.as_vec3(),
            place: place.as_vec3(),
            shade: round_to_f32(shade * self.shade_scale),
        };
    }

    fn in_unit_frame(&self, place: DVec3) -> DVec3 {
        (place - self.mesh.centre()) / self.mesh.radius()
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
