//! Sums of errors on the device: one number per program and 256 samples is read back instead of all
//! reflectances.

use std::ops::Range;

use brood_program::Program;

use super::Engine;
use crate::GpuError;
use crate::encode::{encode, pack};
use crate::pass::Pass;
use crate::plan::{count, grid, padded};
use crate::residency::Rows;
use crate::shader::{Kernel, SUM_SAMPLES};
use crate::sums::{ResidentTargets, Targets};

impl Engine {
    /// Returns the sums of errors of some programs over a range of sums, [`SUM_SAMPLES`] samples
    /// each.
    ///
    /// # Shapes
    /// [program][sum of the range].
    pub(crate) fn sums(
        &mut self,
        programs: &[&Program],
        rows: &Rows<'_>,
        targets: &Targets<'_>,
        range: Range<usize>,
    ) -> Result<Vec<f32>, GpuError> {
        let mut out = vec![0.0; programs.len() * range.len()];
        if out.is_empty() {
            return Ok(out);
        }
        let mask = self.residency.mask(rows);
        let encoded = encode(programs, mask)?;
        let (variant, mut compiled) = self.pipeline(Kernel::Fitness, &encoded)?;
        let width = SUM_SAMPLES as usize;
        let bounds = self.bounds();
        // A buffer holds the six rows of targets, another one the rows of inputs.
        let slab = bounds.slab(mask.len().max(6));
        for start in (0..rows.len).step_by(slab) {
            let samples = start..rows.len.min(start + slab);
            // All sums of this slab, and the requested ones.
            let all = start / width..samples.end.div_ceil(width);
            let here = all.start.max(range.start)..all.end.min(range.end);
            if here.is_empty() {
                continue;
            }
            let (inputs, sent) = self.residency.inputs(&self.device, rows, mask, &samples)?;
            self.timing.uploaded_bytes += sent;
            let rows_of_targets = self.targets(targets, &samples)?;
            let whole = grid(samples.len(), variant.style, Kernel::Fitness);
            let first_sum = count(here.start - all.start);
            let sums = count(here.len());
            let bytes = u64::from(sums) * 4;
            for group in bounds.groups(&encoded, bytes) {
                let first = group.start;
                let programs = &encoded[group];
                let pass = Pass {
                    kernel: Kernel::Fitness,
                    programs,
                    words: &pack(programs),
                    inputs: &inputs,
                    targets: Some(&rows_of_targets),
                    grid: whole,
                    blocks: first_sum * whole.group..(first_sum + sums) * whole.group,
                    samples: count(samples.len()),
                    sums,
                    logarithmic: targets.logarithmic,
                    output_bytes: bytes * programs.len() as u64,
                };
                let submission = self.dispatch(&pass, &mut compiled)?;
                let staging = self.staging.get();
                self.device.read(staging, pass.output_bytes, submission, |view| {
                    let values: &[f32] = bytemuck::cast_slice(view);
                    for (index, row) in values.chunks_exact(here.len()).enumerate() {
                        let target = (first + index) * range.len() + here.start - range.start;
                        out[target..][..here.len()].copy_from_slice(row);
                    }
                })?;
            }
        }
        self.keep(variant, compiled);
        Ok(out)
    }

    /// Returns a buffer of six rows, values to reach and then weights, and uploads it if it is not
    /// the last one used.
    fn targets(
        &mut self,
        targets: &Targets<'_>,
        samples: &Range<usize>,
    ) -> Result<wgpu::Buffer, GpuError> {
        if let Some(resident) = &self.resident_targets
            && (resident.set, resident.first_sample) == (targets.set, samples.start)
        {
            return Ok(resident.buffer.clone());
        }
        let row_bytes = padded(samples.len()) * 4;
        let device = &self.device;
        let buffer = device.scoped(|| {
            let usage = wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_DST;
            let buffer = device.buffer("targets", 6 * row_bytes, usage);
            let rows = targets.values.iter().chain(&targets.weights);
            for (row, offset) in rows.zip((0..).step_by(row_bytes as usize)) {
                let bytes = bytemuck::cast_slice(&row[samples.clone()]);
                device.queue.write_buffer(&buffer, offset, bytes);
            }
            buffer
        })?;
        self.timing.uploaded_bytes += 6 * row_bytes;
        self.resident_targets = Some(ResidentTargets {
            set: targets.set,
            first_sample: samples.start,
            buffer: buffer.clone(),
        });
        Ok(buffer)
    }
}
