//! Points of painted materials: the lights at each surface point as columns, gradients over a
//! pixel, and groups of similar points of one pixel.
//!
//! A picture of a painted material is not linear in its lights, so a sample is a point with all of
//! its lights, not a light at a point.

use brood_brdf::{Input, LightInput};
use brood_light::{LightSampler, Receiver};
use brood_mesh::trace::{Hit, Ray, Stack};
use glam::{DVec2, DVec3};

use super::paint_point::PaintPoint;
use super::point::{CameraRay, PixelFeatures, SampleBuffer, Surface, SurfacePoint};
use super::seen_point::SeenPoint;
use super::values::round_to_f32;
use crate::stage::Obstacles;

/// Largest distance of texture positions from those of a group's first point; separates the sides
/// of a seam.
const MAX_UV_DISTANCE: f64 = 0.05;

/// How painted materials are sampled.
pub(super) struct Painted {
    pub lights: PaintedLights,
    /// Distance of samples in pixels.
    pub spacing: f64,
    /// True to keep the surface point of each sample.
    pub keeps_seen: bool,
}

/// Lights as painted materials see them.
#[derive(Debug)]
pub(super) struct PaintedLights {
    /// Mean direction of each light that is the same everywhere.
    means: Vec<Option<DVec3>>,
    /// Reciprocal of the largest channel of the irradiances of all lights at the centre of the
    /// mesh.
    scale: f64,
}

impl PaintedLights {
    /// # Panics
    /// If there are more than [`Input::LIGHTS`] lights.
    pub fn new(lights: &[LightSampler]) -> Self {
        assert!(lights.len() <= Input::LIGHTS, "at most {} lights are painted", Input::LIGHTS);
        let largest = lights.iter().map(LightSampler::reference_irradiance).fold(0.0, f64::max);
        let scale = if largest > 0.0 && largest.is_finite() { 1.0 / largest } else { 0.0 };
        Self { means: lights.iter().map(LightSampler::mean_direction).collect(), scale }
    }
}

/// Rays through the pixels to the right and below, one spacing of samples away.
#[derive(Debug, Clone, Copy)]
pub(super) struct NextRays(pub [Ray; 2]);

/// A light at a point, before it is seen from there.
#[derive(Clone, Copy)]
struct Aim {
    /// `None` if the light comes from everywhere.
    towards: Option<DVec3>,
    color: [f64; 3],
}

impl Surface<'_> {
    /// Computes what painted materials read at a hit.
    pub fn paint(
        &self,
        hit: &Hit,
        (camera_ray, next): (CameraRay, NextRays),
        (painted, stack): (&Painted, &mut Stack),
        point: &mut SurfacePoint,
    ) {
        let (CameraRay { ray, seed }, Painted { lights, keeps_seen, .. }) = (camera_ray, painted);
        let shaded = self.shaded(hit, ray);
        let position = self.in_unit_frame(shaded.position);
        let neighbours = next.0.map(|ray| {
            let hit = self.hit_on_plane(hit.triangle, &ray)?;
            let shaded = self.shaded(&hit, ray);
            let at = (shaded.frame.n(), ray, self.in_unit_frame(shaded.position));
            Some((at, shaded.uv))
        });
        let footprint = neighbours.map(|neighbour| {
            // Beside a surface that is seen edge-on, the whole texture.
            let change = neighbour.map_or(DVec2::ONE, |(_, uv)| uv - shaded.uv);
            let change = if change.is_finite() { change } else { DVec2::ONE };
            change.clamp(DVec2::NEG_ONE, DVec2::ONE).as_vec2()
        });
        let neighbours = neighbours.map(|neighbour| neighbour.map(|(at, _)| at));
        let n = shaded.frame.n();
        let here = (n, ray, position);
        let step = |value: &dyn Fn((DVec3, Ray, DVec3)) -> f64| {
            let change = |neighbour: Option<_>| {
                neighbour.map_or(1.0, |neighbour| value(neighbour) - value(here))
            };
            let squared: f64 = neighbours.iter().map(|next| change(*next).powi(2)).sum();
            // Not finite if the triangle is degenerate.
            let length = squared.sqrt();
            round_to_f32(if length < 1.0 { length } else { 1.0 })
        };
        let depth = |at: (DVec3, Ray, DVec3)| self.depth(at);
        let own: [&dyn Fn((DVec3, Ray, DVec3)) -> f64; 2] = [&cosine_to_eye, &depth];
        let (u, face, eye) = (shaded.frame.u(), shaded.face(), -ray.direction);
        let seen = SeenPoint { position, n, u, face, eye, seed };
        let (light_count, keeps_seen) = (self.lights.len(), *keeps_seen);
        let mut paint = PaintPoint {
            light_count,
            wi: DVec3::Z,
            footprint,
            seen,
            keeps_seen,
            ..PaintPoint::default()
        };
        for (place, value) in own.into_iter().enumerate() {
            paint.own[place] = round_to_f32(value(here));
            paint.own[2 + place] = step(value);
        }
        paint.own[0] = paint.own[0].max(0.0);
        let start = self.shadow_start(&shaded, hit);
        let receiver = Receiver { position, frame: shaded.frame, wo: shaded.wo, seed };
        let (mut occluded, mut fading) = (0, 0);
        for (index, light) in self.lights.iter().enumerate() {
            let Some(aim) = aim(light, position, lights, index) else { continue };
            let values = &mut paint.lights[index];
            let mut set = |quantity: LightInput, value: f32| values[quantity as usize] = value;
            let visibility = match start.filter(|_| light.casts_shadows) {
                Some(start) => visibility(light, &receiver, start, stack),
                None => 1.0,
            };
            set(LightInput::Visibility, round_to_f32(visibility));
            let brightest = aim.color.into_iter().fold(0.0, f64::max);
            set(LightInput::Level, round_to_f32(brightest));
            let colors = [LightInput::Red, LightInput::Green, LightInput::Blue];
            for (quantity, channel) in colors.into_iter().zip(aim.color) {
                set(quantity, round_to_f32(channel));
            }
            let Some(towards) = aim.towards else {
                // Even light: everything faces it, and no mirror shows it.
                set(LightInput::Cos, 1.0);
                set(LightInput::Mirror, -1.0);
                continue;
            };
            let cosine = |(n, ..): (DVec3, Ray, DVec3)| n.dot(towards).clamp(-1.0, 1.0);
            let mirror = |(n, ray, _): (DVec3, Ray, DVec3)| {
                let eye = -ray.direction;
                (2.0 * n.dot(eye) * n - eye).dot(towards).clamp(-1.0, 1.0)
            };
            set(LightInput::Cos, round_to_f32(cosine(here)));
            set(LightInput::Mirror, round_to_f32(mirror(here)));
            set(LightInput::CosStep, step(&cosine));
            set(LightInput::MirrorStep, step(&mirror));
            if index == 0 {
                paint.wi = shaded.frame.local(towards);
            }
            // A shadow ends where the surface turns away from the light.
            let is_lit = cosine(here) > 0.0;
            let partly = visibility > 0.0 && (visibility < 1.0 || light.samples == 1);
            occluded |= u32::from(is_lit && visibility < 1.0) << index;
            fading |= u32::from(light.is_soft() && partly) << index;
        }
        point.uv = shaded.uv;
        point.wo = shaded.wo;
        point.lit.clear();
        (point.skipped, point.shadowed) = (0, 0);
        point.facing = None;
        point.features = PixelFeatures {
            covered: true,
            lights: occluded,
            fading,
            n: shaded.mesh_normal().as_vec3(),
            shading_n: n.as_vec3(),
            position: position.as_vec3(),
            shade: 0.0,
        };
        match &mut point.paint {
            Some(memory) => **memory = paint,
            None => point.paint = Some(Box::new(paint)),
        }
    }

    /// Depth along the ray: 0 one radius of the subject in front of its centre, 1 one radius behind
    /// it.
    fn depth(&self, (_, ray, position): (DVec3, Ray, DVec3)) -> f64 {
        0.5 * (1.0 + self.relative_to_subject(position).dot(ray.direction))
    }

    /// Returns the hit of a ray with the plane of a triangle, in or outside of the triangle; `None`
    /// if they do not cross in front of the ray.
    fn hit_on_plane(&self, triangle: usize, ray: &Ray) -> Option<Hit> {
        let corners = self.parts.triangles[triangle]
            .map(|corner| self.in_unit_frame(self.parts.positions[corner as usize]));
        let [a, b, c] = corners;
        let (ab, ac) = (b - a, c - a);
        let normal = ab.cross(ac);
        let along = normal.dot(ray.direction);
        let distance = normal.dot(a - ray.origin) / along;
        let from_a = ray.origin + ray.direction * distance - a;
        let area = normal.length_squared();
        let (second, third) =
            (normal.dot(from_a.cross(ac)) / area, normal.dot(ab.cross(from_a)) / area);
        let is_in_front = distance > 0.0 && second.is_finite() && third.is_finite();
        is_in_front.then(|| Hit::on_plane(triangle, [1.0 - second - third, second, third]))
    }
}

fn cosine_to_eye((n, ray, _): (DVec3, Ray, DVec3)) -> f64 {
    -n.dot(ray.direction)
}

/// Direction and colour of a light at a position.
fn aim(light: &LightSampler, position: DVec3, lights: &PaintedLights, index: usize) -> Option<Aim> {
    let central = light.central(position, lights.means[index])?;
    let color = central.irradiance.map(|channel| {
        let channel = channel * lights.scale;
        // NaN, possible for extreme lights, counts as dark.
        if channel > 0.0 { channel.min(1.0) } else { 0.0 }
    });
    Some(Aim { towards: central.towards, color })
}

/// Share of a light's irradiance that is not occluded; 1 if no light arrives.
fn visibility(
    light: &LightSampler,
    receiver: &Receiver,
    (obstacles, start): (&Obstacles<'_>, DVec3),
    stack: &mut Stack,
) -> f64 {
    let (mut all, mut visible) = (0.0, 0.0);
    light.for_each_sample(receiver, |_, sample| {
        let cosine = receiver.frame.local(sample.towards).z;
        if cosine > 0.0 {
            let irradiance = sample.irradiance.into_iter().fold(0.0, f64::max) * cosine;
            let ray = Ray { origin: start, direction: sample.towards };
            all += irradiance;
            visible += irradiance * obstacles.passed(ray, sample.distance, stack);
        }
    });
    let share = visible / all;
    if share.is_finite() { share } else { 1.0 }
}

/// Similar points of one pixel, whose means make one sample.
struct Group {
    features: PixelFeatures,
    first_uv: DVec2,
    weight: f64,
    /// The first point; all footprints are over a whole pixel.
    first: PaintPoint,
    wi: DVec3,
    wo: DVec3,
    uv: DVec2,
    own: [f64; 4],
    lights: [[f64; LightInput::ALL.len()]; Input::LIGHTS],
}

/// Groups weighted points of a pixel and adds one sample per group, whose irradiance is its weight.
/// Returns the covered fraction of the pixel.
pub(super) fn push_groups<'a>(
    points: impl Iterator<Item = (&'a SurfacePoint, f64)>,
    out: &mut SampleBuffer,
) -> f64 {
    let mut groups: Vec<Group> = Vec::new();
    let mut coverage = 0.0;
    for (point, weight) in points {
        let Some(paint) = point.paint.as_deref().filter(|_| point.features.covered) else {
            continue;
        };
        coverage += weight;
        if weight > 0.0 {
            join(&mut groups, point, paint, weight);
        }
    }
    for group in groups {
        let mean = |sum: f64| round_to_f32(sum / group.weight);
        let paint = PaintPoint {
            own: group.own.map(mean),
            lights: group.lights.map(|values| values.map(mean)),
            wi: group.wi.try_normalize().unwrap_or(DVec3::Z),
            ..group.first
        };
        let wo = group.wo.try_normalize().unwrap_or(DVec3::Z);
        out.push(paint.wi, wo, group.uv / group.weight, [group.weight; 3]);
        out.paint.push(&paint);
    }
    coverage
}

/// Adds a point to the first group of similar points, or to a new one.
fn join(groups: &mut Vec<Group>, point: &SurfacePoint, paint: &PaintPoint, weight: f64) {
    let is_near = |group: &Group| {
        group.features.is_similar(&point.features)
            && (group.first_uv - point.uv).abs().max_element() <= MAX_UV_DISTANCE
    };
    let found = groups.iter().position(is_near);
    let index = found.unwrap_or_else(|| {
        groups.push(Group {
            features: point.features,
            first_uv: point.uv,
            weight: 0.0,
            first: *paint,
            wi: DVec3::ZERO,
            wo: DVec3::ZERO,
            uv: DVec2::ZERO,
            own: [0.0; 4],
            lights: [[0.0; LightInput::ALL.len()]; Input::LIGHTS],
        });
        groups.len() - 1
    });
    let group = &mut groups[index];
    group.weight += weight;
    group.wi += paint.wi * weight;
    group.wo += point.wo * weight;
    group.uv += point.uv * weight;
    let sums = group.own.iter_mut().zip(&paint.own);
    let lights = group.lights.as_flattened_mut().iter_mut().zip(paint.lights.as_flattened());
    sums.chain(lights).for_each(|(sum, value)| *sum += weight * f64::from(*value));
}
