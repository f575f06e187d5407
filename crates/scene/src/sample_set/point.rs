//! Shading of hits: incident light samples and the features by which pixels are compared.

use std::ops::Range;
use std::sync::Arc;

use brood_brdf::DirectionPair;
use brood_light::{LightSampler, PrefilteredEnvironment, Receiver};
use brood_mesh::trace::{Hit, Ray, Stack};
use brood_mesh::{Mesh, MeshParts};
use glam::{DVec2, DVec3, Vec3};

use super::frame::{ShadedPoint, above_horizon};
use super::normal_map::{MappedNormals, bumped};
use super::paint_point::{PaintBuffer, PaintPoint};
use super::values::round_to_f32;
use crate::description::{Normals, Scene, Tangents};
use crate::prefiltered::{DirectSamples, Facing};
use crate::stage::{Obstacles, Stage, TextureBumps};

/// Mesh and lights with which hits are shaded.
pub(super) struct Surface<'a> {
    pub(super) parts: &'a MeshParts,
    mesh: &'a Mesh,
    pub(super) lights: Vec<LightSampler>,
    /// Occluders of shadow rays; `None` if the scene has no shadows.
    obstacles: Option<Obstacles<'a>>,
    normals: Normals,
    pub(super) tangents: Tangents,
    /// Normal map of the mesh.
    pub(super) mapped: Option<MappedNormals<'a>>,
    /// Bumps of its material.
    bumps: Option<Arc<dyn TextureBumps>>,
    /// Reciprocal of the sum of the lights' reference irradiance, so that `shade` is at most about
    /// 1; 0 if that sum is 0 or infinite.
    shade_scale: f64,
    /// Centre of the subject in the unit frame, and the radius of the unit frame in radii of the
    /// subject.
    subject: (DVec3, f64),
}

/// Camera ray, and the seed of the light samples at its hit.
#[derive(Debug, Clone, Copy)]
pub(super) struct CameraRay {
    pub ray: Ray,
    pub seed: u64,
}

/// Distance of the start of shadow rays above the surface, in the unit frame: far above rounding
/// errors, far below what is visible.
pub(super) const START_ABOVE: f64 = 1e-6;

/// Light sample at a surface point.
#[derive(Debug, Clone, Copy)]
pub(super) struct IncidentSample {
    /// Index of the sample among those of all lights.
    pub slot: usize,
    pub wi: DVec3,
    /// Irradiance times cosine.
    pub irradiance: [f64; 3],
}

/// Surface point with its incident light samples.
#[derive(Debug, Clone, Default)]
pub(super) struct SurfacePoint {
    pub features: PixelFeatures,
    pub uv: DVec2,
    pub wo: DVec3,
    pub lit: Vec<IncidentSample>,
    /// Number of light samples skipped because no light arrives.
    pub skipped: u64,
    /// Number of light samples skipped because they are occluded.
    pub shadowed: u64,
    /// `None` if the ray misses or the point reflects nothing.
    pub facing: Option<Facing>,
    /// Present for painted materials only. Kept for its memory if the ray misses.
    pub paint: Option<Box<PaintPoint>>,
}

/// Features by which rays and neighbouring pixels are compared. Default: the ray misses.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(super) struct PixelFeatures {
    /// True if the ray hits the mesh.
    pub covered: bool,
    /// Lights that reach the point, one bit each.
    pub lights: u32,
    /// Lights in a gradual transition to dark (penumbra, fall-off of a spot), one bit each.
    pub fading: u32,
    /// Normal of the mesh, in the unit frame. A normal map makes no edges.
    pub n: Vec3,
    /// Shading normal, in the unit frame.
    pub shading_n: Vec3,
    /// Position, in the unit frame.
    pub position: Vec3,
    /// Sum of irradiance times cosine over all lights, relative to the reference irradiance.
    pub shade: f32,
}

/// Cosine of the angle between normals, 26 degrees, above which there is a crease.
const CREASE_COS: f32 = 0.9;
/// Sine of the angle, 24 degrees, between a tangent plane and the line between two hits, above
/// which the hits are on different surfaces.
const STEP_SIN: f32 = 0.4;

impl PixelFeatures {
    /// True if both miss, or both see one smooth piece of surface lit by the same lights.
    pub fn is_similar(&self, other: &Self) -> bool {
        // A gradual transition of a light is not an edge.
        let differ = (self.lights ^ other.lights) & !(self.fading | other.fading);
        if self.covered != other.covered || differ != 0 {
            return false;
        }
        if !self.covered {
            return true;
        }
        let line = other.position - self.position;
        let off_plane = self.n.dot(line).abs().max(other.n.dot(line).abs());
        self.n.dot(other.n) >= CREASE_COS && off_plane <= STEP_SIN * line.length()
    }
}

impl<'a> Surface<'a> {
    pub fn new(stage: &Stage<'a>, lights: Vec<LightSampler>, scene: &Scene) -> Self {
        let mesh = stage.mesh();
        let mut surface = Self {
            parts: mesh.parts(),
            mesh,
            lights: Vec::new(),
            obstacles: scene.shadows.then(|| stage.obstacles()),
            normals: scene.normals,
            tangents: scene.tangents,
            mapped: None,
            bumps: stage.bumps(),
            shade_scale: 0.0,
            subject: stage.subject(),
        };
        surface.light_by(lights);
        surface
    }

    fn light_by(&mut self, lights: Vec<LightSampler>) {
        let all: f64 = lights.iter().map(LightSampler::reference_irradiance).sum();
        self.shade_scale = if all > 0.0 && all.is_finite() { 1.0 / all } else { 0.0 };
        self.lights = lights;
    }

    /// Removes the environments from the lights and returns them.
    pub fn take_environments(&mut self) -> Vec<PrefilteredEnvironment> {
        self.take_environments_if(|_| true)
    }

    /// Removes some of the environments from the lights and returns them.
    pub fn take_environments_if(
        &mut self,
        is_wanted: impl Fn(&LightSampler) -> bool,
    ) -> Vec<PrefilteredEnvironment> {
        let (mut taken, mut others) = (Vec::new(), Vec::new());
        for light in std::mem::take(&mut self.lights) {
            match light.prefiltered().filter(|_| is_wanted(&light)) {
                Some(environment) => taken.push(environment),
                None => others.push(light),
            }
        }
        self.light_by(others);
        taken
    }

    /// Shades a hit and writes the result to `point`, whose memory is reused.
    pub fn shade(
        &self,
        hit: &Hit,
        camera_ray: CameraRay,
        stack: &mut Stack,
        point: &mut SurfacePoint,
    ) {
        let CameraRay { ray, seed } = camera_ray;
        let shaded = self.shaded(hit, ray);
        let position = self.in_unit_frame(shaded.position);
        let start = self.shadow_start(&shaded, hit);
        let SurfacePoint { lit, skipped, shadowed, .. } = point;
        lit.clear();
        let (mut mask, mut fading, mut shade) = (0, 0, 0.0);
        (*skipped, *shadowed) = (0, 0);
        let reflects = shaded.reflects(self.normals);
        let receiver = Receiver { position, frame: shaded.frame, wo: shaded.wo, seed };
        for (index, light) in self.lights.iter().enumerate() {
            if !reflects {
                *skipped += u64::from(light.samples);
                continue;
            }
            let (before, shadowed_before) = (lit.len(), *shadowed);
            let (mut fades, soft, mut reached) = (false, light.is_soft(), 0);
            light.for_each_sample(&receiver, |sample, light_sample| {
                let wi = shaded.frame.local(light_sample.towards);
                // Pixels are compared without bumps, which vary within a pixel.
                let cosine = match &self.bumps {
                    Some(_) => shaded.mesh_normal().dot(light_sample.towards),
                    None => wi.z,
                };
                // NaN, possible for extreme lights, is treated as unlit.
                let is_above = light.is_environment || shaded.is_above(light_sample.towards);
                if (wi.z > 0.0 || cosine > 0.0) && is_above {
                    let mut passed = 1.0;
                    if let Some((obstacles, start)) = start.filter(|_| light.casts_shadows) {
                        let ray = Ray { origin: start, direction: light_sample.towards };
                        passed = obstacles.passed(ray, light_sample.distance, stack);
                        if passed <= 0.0 {
                            *shadowed += 1;
                            return;
                        }
                    }
                    fades |= light_sample.fading;
                    reached += u64::from(cosine > 0.0);
                    let irradiance = |cosine| light_sample.irradiance.map(|e| e * cosine * passed);
                    if !soft {
                        let [red, green, blue] = irradiance(cosine.max(0.0));
                        shade += red.max(green).max(blue);
                    }
                    if wi.z <= 0.0 {
                        return;
                    }
                    let irradiance = irradiance(wi.z);
                    lit.push(IncidentSample {
                        slot: light.first_slot + sample as usize,
                        wi,
                        irradiance,
                    });
                }
            });
            let made =
                u64::try_from(lit.len() - before).expect("a light has fewer than 2^32 samples");
            let all = u64::from(light.samples);
            *skipped += all - made - (*shadowed - shadowed_before);
            mask |= u32::from(reached > 0) << index;
            // Partly lit by an extended light: no edge. With a single sample a penumbra cannot be
            // detected, so it is always assumed.
            let partly = soft && (reached < all || all == 1);
            fading |= u32::from(fades || (reached > 0 && partly)) << index;
            if soft {
                let n = if self.bumps.is_some() { shaded.mesh_normal() } else { shaded.frame.n() };
                shade += light.unoccluded_irradiance(position, n);
            }
        }
        point.uv = shaded.uv;
        point.wo = shaded.wo;
        point.facing =
            reflects.then(|| Facing { frame: shaded.frame, eye: -ray.direction, uv: shaded.uv });
        point.features = PixelFeatures {
            covered: true,
            lights: mask,
            fading,
            n: shaded.mesh_normal().as_vec3(),
            shading_n: shaded.frame.n().as_vec3(),
            position: position.as_vec3(),
            shade: round_to_f32(shade * self.shade_scale),
        };
    }

    /// Returns a position of the unit frame relative to the subject's centre, in its radii.
    pub(super) fn relative_to_subject(&self, position: DVec3) -> DVec3 {
        (position - self.subject.0) * self.subject.1
    }

    /// Returns the hit of a ray with its shading frame.
    pub(super) fn shaded(&self, hit: &Hit, ray: Ray) -> ShadedPoint {
        let shaded = ShadedPoint::new(self.parts, hit, -ray.direction, self.tangents);
        let shaded = match &self.mapped {
            Some(mapped) => mapped.apply(shaded, hit, ray),
            None => shaded,
        };
        match &self.bumps {
            Some(bumps) => bumped(bumps.as_ref(), self.parts, shaded, (hit, ray)),
            None => shaded,
        }
    }

    /// True if there are shadows.
    pub fn has_shadows(&self) -> bool {
        self.obstacles.is_some()
    }

    /// Returns the position of a hit in the unit frame.
    pub fn position(&self, hit: &Hit) -> DVec3 {
        let corners = self.parts.triangles[hit.triangle].map(|corner| corner as usize);
        let weighted = corners.iter().zip(hit.weights);
        self.in_unit_frame(weighted.map(|(corner, w)| self.parts.positions[*corner] * w).sum())
    }

    /// Returns the occluders and the start of shadow rays at a hit; `None` if there are no shadows.
    pub(super) fn shadow_start(
        &self,
        shaded: &ShadedPoint,
        hit: &Hit,
    ) -> Option<(&Obstacles<'a>, DVec3)> {
        self.obstacles.as_ref().map(|obstacles| {
            let start = self.in_unit_frame(shaded.shadow_start(self.normals, self.parts, hit));
            (obstacles, start + shaded.face() * START_ABOVE)
        })
    }

    pub(super) fn in_unit_frame(&self, position: DVec3) -> DVec3 {
        (position - self.mesh.centre()) / self.mesh.radius()
    }
}

/// Buffer of samples, as a structure of arrays.
#[derive(Default)]
pub(super) struct SampleBuffer {
    pub pairs: Vec<DirectionPair>,
    pub uvs: Vec<DVec2>,
    pub irradiance: [Vec<f32>; 3],
    /// One per sample of painted materials, else empty.
    pub paint: PaintBuffer,
}

impl SampleBuffer {
    pub fn count(&self) -> u32 {
        u32::try_from(self.pairs.len()).expect("an image has fewer than 2^32 samples")
    }

    pub fn push(&mut self, wi: DVec3, wo: DVec3, uv: DVec2, irradiance: [f64; 3]) {
        self.pairs.push(DirectionPair::new(wi, wo).expect("wi and wo are unit vectors"));
        self.uvs.push(uv);
        for (channel, e) in self.irradiance.iter_mut().zip(irradiance) {
            channel.push(round_to_f32(e));
        }
    }

    /// Adds one sample per light sample of the point; of painted materials, one for the point.
    pub fn push_point(&mut self, point: &SurfacePoint) {
        if let Some(paint) = point.paint.as_ref().filter(|_| point.features.covered) {
            self.push(paint.wi, point.wo, point.uv, [1.0; 3]);
            return self.paint.push(paint);
        }
        for lit in &point.lit {
            self.push(lit.wi, point.wo, point.uv, lit.irradiance);
        }
    }

    /// Adds the samples of environments around a point, times `weight`.
    pub fn push_environments(&mut self, light: &DirectSamples, at: &Facing, weight: f64) {
        let wo = above_horizon(at.frame.local(at.eye));
        for (towards, irradiance) in light.iter() {
            let wi = at.frame.local(*towards);
            if wi.z > 0.0 {
                self.push(wi, wo, at.uv, irradiance.map(|e| e * weight));
            }
        }
    }

    pub fn with_capacity(count: usize) -> Self {
        Self {
            pairs: Vec::with_capacity(count),
            uvs: Vec::with_capacity(count),
            irradiance: [(); 3].map(|()| Vec::with_capacity(count)),
            paint: PaintBuffer::default(),
        }
    }

    pub fn extend(&mut self, other: &Self, range: Range<usize>) {
        self.pairs.extend_from_slice(&other.pairs[range.clone()]);
        self.uvs.extend_from_slice(&other.uvs[range.clone()]);
        for (all, more) in self.irradiance.iter_mut().zip(&other.irradiance) {
            all.extend_from_slice(&more[range.clone()]);
        }
        if !other.paint.is_empty() {
            self.paint.extend(&other.paint, range);
        }
    }

    pub fn append(&mut self, other: &mut Self) {
        self.pairs.append(&mut other.pairs);
        self.uvs.append(&mut other.uvs);
        for (all, more) in self.irradiance.iter_mut().zip(&mut other.irradiance) {
            all.append(more);
        }
        self.paint.append(&mut other.paint);
    }
}
