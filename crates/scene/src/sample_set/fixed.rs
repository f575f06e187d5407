//! Rows of samples, and pixels with a fixed number of rays.

use glam::DVec2;

use super::layout::{PixelRun, SampleCounts};
use super::point::SampleBuffer;
use super::quadrature::{PixelSampler, Scratch};
use super::sampling::PixelArea;
use crate::prefiltered::{DirectSamples, LitPoint};

/// Number of rays per pixel from which the pixel's triangles are gathered once for all of them.
const MIN_RAYS_FOR_CANDIDATES: usize = 4;

/// Samples of a row of the area.
#[derive(Default)]
pub(super) struct Row {
    pub buffer: SampleBuffer,
    pub runs: Vec<PixelRun>,
    pub coverage: Vec<f32>,
    pub counts: SampleCounts,
    pub points: Vec<LitPoint>,
}

impl Row {
    /// Adds the coverage and the run of a pixel; its samples may be added before or after. The
    /// counts are those of [`PixelRun`]: all samples, those of the centre, and those not summed for
    /// radiance.
    pub fn finish_pixel(
        &mut self,
        pixel: u32,
        (samples, centre, radiance_start): (u32, u32, u32),
        coverage: f32,
    ) {
        self.coverage.push(coverage);
        if samples == 0 {
            return;
        }
        let start = self.runs.last().map_or(0, PixelRun::end);
        let run = PixelRun { pixel, pixels: 1, start, samples, centre, radiance_start };
        if !self.runs.last_mut().is_some_and(|last| last.extend(&run)) {
            self.runs.push(run);
        }
    }
}

/// Samples a row with the same rays in every pixel.
pub(super) fn fixed_row(
    sampler: &PixelSampler<'_>,
    area: PixelArea,
    row: u32,
    offsets: &[DVec2],
    scratch: &mut Scratch,
) -> Row {
    let mut out = Row::default();
    for column in 0..area.width {
        let pixel = (area.x + column, area.y + row);
        fixed_pixel(sampler, pixel, offsets, scratch, (row * area.width + column, &mut out));
    }
    out
}

/// Samples a pixel and adds it with that index.
pub(super) fn fixed_pixel(
    sampler: &PixelSampler<'_>,
    (x, y): (u32, u32),
    offsets: &[DVec2],
    scratch: &mut Scratch,
    (index, out): (u32, &mut Row),
) {
    let start = out.buffer.count();
    let (mut centre, mut covered) = (0, 0u16);
    let mut environments: Option<DirectSamples> = None;
    let mut point = std::mem::take(&mut scratch.fixed);
    let use_candidates = offsets.len() >= MIN_RAYS_FOR_CANDIDATES;
    if use_candidates {
        sampler.gather_candidates(x, y, scratch);
    }
    for (k, offset) in offsets.iter().enumerate() {
        let ray = sampler.camera_ray((x, y), *offset, k);
        let hit = if use_candidates {
            sampler.trace_in_pixel((ray, *offset), scratch, &mut point)
        } else {
            sampler.trace(ray, &mut scratch.stack, &mut point)
        };
        if hit {
            covered += 1;
            out.counts.add_unlit((point.skipped, point.shadowed));
            out.buffer.push_point(&point);
            if let (Some(light), Some(facing)) = (&sampler.environments, &point.facing) {
                let near = environments.take().filter(|near| near.is_near(facing));
                let near = near.unwrap_or_else(|| light.at(facing));
                out.buffer.push_environments(&near, facing, 1.0);
                environments = Some(near);
            }
        }
        if k == 0 {
            centre = out.buffer.count() - start;
        }
    }
    scratch.fixed = point;
    out.counts.rays += offsets.len() as u64;
    out.counts.covered += u64::from(covered);
    let samples = out.buffer.count() - start;
    out.finish_pixel(index, (samples, centre, 0), f32::from(covered) / offsets.len() as f32);
}
