//! Samples of given rays instead of those of a camera, for what clear bodies show.

use brood_brdf::Lighting;
use brood_light::LightAssets;
use brood_mesh::trace::Ray;
use glam::DVec3;
use rayon::prelude::*;

use super::fixed::Row;
use super::layout::ImageLayout;
use super::paint::{NextRays, Painted, PaintedLights};
use super::paint_point::PaintBuffer;
use super::point::{CameraRay, SurfacePoint};
use super::quadrature::{PixelSampler, Scratch};
use super::render::{ROWS, concatenate, direct_sampler};
use super::sampling::{PixelArea, Sampling};
use super::seen_point::LeavingRay;
use super::set::SampleSet;
use super::size::PictureSize;
use crate::description::Scene;
use crate::prefiltered::LobeShape;
use crate::stage::Stage;

/// Number of rays that a thread traces at a time.
const TOGETHER: usize = 256;

/// Kind of samples at the ends of rays.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Seen {
    /// Light, for BRDFs; of environments as in [`SampleSet::render_direct`] if the lobes are given.
    Light(Option<LobeShape>),
    /// Points, for painted materials.
    Points,
}

impl SampleSet {
    /// Samples what rays see of the part of a stage, as a picture of one row with a pixel for each
    /// ray. The rays are in the unit frame of the part `from`. Pixels of rays that miss the part,
    /// or that another part hides, are not covered. Gradients are those over the angle of a pixel
    /// of a picture with that size.
    ///
    /// # Domain
    /// As [`SampleSet::render`], and for points as [`SampleSet::render_points`].
    ///
    /// # Panics
    /// If the stage has no part `from`, there are 2^32 rays, or too many lights for points.
    #[must_use]
    pub fn of_rays(
        (stage, from): (&Stage<'_>, usize),
        (scene, assets): (&Scene, &LightAssets),
        (size_px, rays): (PictureSize, &[LeavingRay]),
        seen: Seen,
    ) -> Self {
        match seen {
            Seen::Light(lobes) => {
                let sampler = direct_sampler((stage, scene, assets), size_px, lobes);
                Self::sampled(&sampler, (stage, from), (size_px, rays)).0
            }
            Seen::Points => {
                let (set, points) =
                    Self::points_of_rays((stage, from), (scene, assets), (size_px, rays), false);
                let lighting = set.lighting().expect("the samples are points");
                set.with_lights(lighting, points.columns(lighting))
            }
        }
    }

    /// As [`SampleSet::of_rays`] with [`Seen::Points`], with the points instead of their columns.
    pub(super) fn points_of_rays(
        (stage, from): (&Stage<'_>, usize),
        (scene, assets): (&Scene, &LightAssets),
        (size_px, rays): (PictureSize, &[LeavingRay]),
        keeps_seen: bool,
    ) -> (Self, PaintBuffer) {
        let mut sampler = direct_sampler((stage, scene, assets), size_px, None);
        let lights = PaintedLights::new(&sampler.surface.lights);
        sampler.painted = Some(Painted { lights, spacing: 1.0, keeps_seen });
        let (set, points) = Self::sampled(&sampler, (stage, from), (size_px, rays));
        let lights = sampler.surface.lights.len();
        let lighting = Lighting { lights, has_shadows: sampler.surface.has_shadows() };
        (set.with_lights(lighting, []), points)
    }

    fn sampled(
        sampler: &PixelSampler<'_>,
        (stage, from): (&Stage<'_>, usize),
        (size_px, rays): (PictureSize, &[LeavingRay]),
    ) -> (Self, PaintBuffer) {
        let change = stage.change_from(from);
        let width = u32::try_from(rays.len()).expect("there are fewer than 2^32 rays");
        let firsts = (0..width).into_par_iter().step_by(TOGETHER);
        let rows = rays.par_chunks(TOGETHER).zip(firsts);
        let rows = rows.with_max_len(ROWS).map_init(Scratch::default, |scratch, (rays, first)| {
            let (mut out, mut point) = (Row::default(), SurfacePoint::default());
            for (index, leaving) in (first..).zip(rays) {
                let ray = change.as_ref().map_or(leaving.ray, |change| change.ray(leaving.ray));
                let camera_ray = CameraRay { ray, seed: leaving.seed };
                let next = beside(ray, sampler.view.pixel_width(size_px, ray.origin));
                let start = out.buffer.count();
                let stack = &mut scratch.stack;
                let is_hit = sampler.trace_beside((camera_ray, next), stack, &mut point);
                if is_hit {
                    out.counts.covered += 1;
                    out.counts.add_unlit((point.skipped, point.shadowed));
                    out.buffer.push_point(&point);
                    if let (Some(light), Some(facing)) = (&sampler.environments, &point.facing) {
                        out.buffer.push_environments(&light.at(facing), facing, 1.0);
                    }
                }
                out.counts.rays += 1;
                let samples = out.buffer.count() - start;
                out.finish_pixel(index, (samples, samples, 0), f32::from(u8::from(is_hit)));
            }
            out
        });
        let image = ImageLayout {
            width,
            height: 1,
            size_px: PictureSize { width, height: 1 },
            area: PixelArea { x: 0, y: 0, width, height: 1 },
            sampling: Sampling::Fixed(1),
            scale: 1.0,
            runs: Vec::new(),
            coverage: Vec::new().into(),
        };
        concatenate(rows.collect(), image)
    }
}

/// Returns two rays beside a ray, as far away as the next pixels would be without curvature.
fn beside(ray: Ray, (angle, width): (f64, f64)) -> NextRays {
    let (right, down) = ray.direction.any_orthonormal_pair();
    let moved = |by: DVec3| Ray {
        origin: ray.origin + by * width,
        direction: (ray.direction + by * angle).normalize(),
    };
    NextRays([moved(right), moved(down)])
}
