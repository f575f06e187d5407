//! From a mesh and a scene to its samples: one ray a subsample, rows in parallel, put together in their order.

use brood_brdf::DirectionPair;
use glam::DVec2;
use rayon::prelude::*;

use super::frame::ShadedPoint;
use super::lighting::PointLight;
use super::view::{UnitFrame, View, subsample_places};
use super::{ImageLayout, PixelSpan, SampleCounts, SampleSet, round_to_f32};
use crate::mesh::MeshParts;
use crate::trace::Tracer;
use crate::{Mesh, Scene};

/// What a row needs to know.
struct Job<'a> {
    parts: &'a MeshParts,
    mesh: &'a Mesh,
    tracer: &'a Tracer,
    view: View,
    lights: Vec<PointLight>,
    places: Vec<DVec2>,
    size_px: u32,
}

/// Samples of a row; spans count from the row's own first sample.
#[derive(Default)]
struct Row {
    pairs: Vec<DirectionPair>,
    uvs: Vec<DVec2>,
    irradiance: [Vec<f32>; 3],
    spans: Vec<PixelSpan>,
    covered: Vec<u16>,
}

pub(super) fn render(
    mesh: &Mesh,
    scene: &Scene,
    size_px: u32,
    samples_per_pixel: u32,
) -> SampleSet {
    let counted = 1..=u32::from(u16::MAX);
    assert!(counted.contains(&size_px), "size_px {size_px} is not in 1..=65535");
    assert!(
        counted.contains(&samples_per_pixel),
        "samples_per_pixel {samples_per_pixel} is not in 1..=65535"
    );
    let frame = UnitFrame::new(mesh, scene);
    let job = Job {
        parts: mesh.parts(),
        mesh,
        tracer: mesh.tracer(),
        view: View::new(&scene.camera, &frame),
        lights: PointLight::all(scene, &frame),
        places: subsample_places(samples_per_pixel),
        size_px,
    };
    let rows: Vec<Row> = (0..size_px).into_par_iter().map(|row| job.row(row)).collect();
    let rays = u64::from(size_px).pow(2) * u64::from(samples_per_pixel);
    put_together(rows, size_px, samples_per_pixel, rays)
}

impl Job<'_> {
    fn row(&self, y: u32) -> Row {
        let mut row = Row::default();
        let mut stack = Vec::new();
        for x in 0..self.size_px {
            let mut span = PixelSpan {
                pixel: y * self.size_px + x,
                start: row.count(),
                first_end: row.count(),
                end: row.count(),
            };
            let mut covered = 0u16;
            for place in &self.places {
                let place = (DVec2::new(f64::from(x), f64::from(y)) + *place)
                    * (2.0 / f64::from(self.size_px))
                    - DVec2::ONE;
                let ray = self.view.ray(DVec2::new(place.x, -place.y));
                let Some(hit) = self.tracer.trace(ray, &mut stack) else { continue };
                covered += 1;
                let point = ShadedPoint::new(self.parts, &hit, -ray.direction);
                self.light(&point, &mut row);
                if span.first_end == span.start {
                    span.first_end = row.count();
                }
            }
            span.end = row.count();
            if span.end > span.start {
                row.spans.push(span);
            }
            row.covered.push(covered);
        }
        row
    }

    /// Adds one sample for every light in front of the surface.
    fn light(&self, point: &ShadedPoint, row: &mut Row) {
        let place = (point.place - self.mesh.centre()) / self.mesh.radius();
        for light in &self.lights {
            let Some((towards, irradiance)) = light.at(place) else { continue };
            let wi = point.local(towards);
            // NaN, which a light beyond all reason could make, is unlit.
            if wi.z > 0.0 {
                let pair =
                    DirectionPair::new(wi, point.wo).expect("both have just been normalised");
                for (channel, e) in row.irradiance.iter_mut().zip(irradiance) {
                    channel.push(round_to_f32(e * pair.cos_i()));
                }
                row.pairs.push(pair);
                row.uvs.push(point.uv);
            }
        }
    }
}

impl Row {
    fn count(&self) -> u32 {
        u32::try_from(self.pairs.len()).expect("a row has fewer than 2^32 samples")
    }
}

fn put_together(rows: Vec<Row>, size_px: u32, samples_per_pixel: u32, rays: u64) -> SampleSet {
    let count = rows.iter().map(|row| row.pairs.len()).sum();
    let mut pairs = Vec::with_capacity(count);
    let mut uvs = Vec::with_capacity(count);
    let mut irradiance = [(); 3].map(|()| Vec::with_capacity(count));
    let mut image = ImageLayout {
        width: size_px,
        height: size_px,
        samples_per_pixel,
        spans: Vec::with_capacity(rows.iter().map(|row| row.spans.len()).sum()),
        covered: Vec::with_capacity(rows.iter().map(|row| row.covered.len()).sum()),
    };
    for row in rows {
        let first = u32::try_from(pairs.len()).expect("an image has fewer than 2^32 samples");
        image.spans.extend(row.spans.iter().map(|span| PixelSpan {
            pixel: span.pixel,
            start: first + span.start,
            first_end: first + span.first_end,
            end: first + span.end,
        }));
        pairs.extend(row.pairs);
        uvs.extend(row.uvs);
        for (all, row) in irradiance.iter_mut().zip(row.irradiance) {
            all.extend(row);
        }
        image.covered.extend(row.covered);
    }
    let covered = image.covered.iter().map(|covered| u64::from(*covered)).sum();
    let counts = SampleCounts { rays, covered, lit: pairs.len() as u64 };
    SampleSet::new(pairs, uvs, irradiance, Some(image), counts)
}
