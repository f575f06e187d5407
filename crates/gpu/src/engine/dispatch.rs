//! Dispatch of a pass, tile by tile. Each submission is awaited and measured, so that the next tile
//! can be sized to the target time.

use std::time::Instant;

use super::Engine;
use crate::GpuError;
use crate::pass::{Pass, TileUniform};
use crate::pipeline::Compiled;
use crate::plan::{Grid, after, next_tile};

impl Engine {
    /// Runs one pass. After the last tile the outputs are copied for reading. Returns the last
    /// submission.
    pub(crate) fn dispatch(
        &mut self,
        pass: &Pass<'_>,
        compiled: &mut Compiled,
    ) -> Result<wgpu::SubmissionIndex, GpuError> {
        let group = self.bind(pass)?;
        // Tiles count from the first block of the pass.
        let part = Grid { blocks: pass.blocks.end - pass.blocks.start, ..pass.grid };
        let mut from = (0, 0);
        while let Some(tile) = next_tile(pass.programs, part, from, compiled.tile_budget.work()) {
            from = after(&tile, part.blocks);
            let is_last = from.0 as usize == pass.programs.len();
            let uniform = TileUniform {
                zero: 0,
                first_program: tile.programs.start,
                first_block: pass.blocks.start + tile.blocks.start,
                end_block: pass.blocks.start + tile.blocks.end,
                stride: pass.grid.blocks,
                samples: pass.samples,
                sums: pass.sums,
                logarithmic: pass.logarithmic.into(),
                first_sum: pass.blocks.start / pass.grid.group,
                padding: [0; 3],
            };
            let groups = (tile.blocks.end - tile.blocks.start).div_ceil(pass.grid.group);
            let programs = tile.programs.end - tile.programs.start;
            let started = Instant::now();
            let submission = self.device.scoped(|| {
                self.device.queue.write_buffer(self.tile.get(), 0, bytemuck::bytes_of(&uniform));
                let mut encoder = self.device.api.create_command_encoder(&Default::default());
                let descriptor = wgpu::ComputePassDescriptor {
                    label: None,
                    timestamp_writes: self.clock.as_ref().map(|clock| clock.writes()),
                };
                let mut compute = encoder.begin_compute_pass(&descriptor);
                compute.set_pipeline(&compiled.pipeline);
                compute.set_bind_group(0, &group, &[]);
                compute.dispatch_workgroups(groups, programs, 1);
                drop(compute);
                if let Some(clock) = &self.clock {
                    clock.resolve(&mut encoder);
                }
                if is_last {
                    let (outputs, staging) = (self.outputs.get(), self.staging.get());
                    encoder.copy_buffer_to_buffer(outputs, 0, staging, 0, pass.output_bytes);
                }
                self.device.queue.submit([encoder.finish()])
            })?;
            // Waiting also for the last tile measures its throughput; only the mapping is left to
            // the reader.
            if compiled.has_run {
                self.device.wait(submission.clone())?;
            } else {
                self.device.wait_for_first_use(submission.clone())?;
            }
            let wall_s = started.elapsed().as_secs_f64();
            let on_device_s = match &self.clock {
                Some(clock) => clock.read(&self.device, submission.clone(), wall_s)?,
                None => None,
            };
            let seconds = on_device_s.unwrap_or(wall_s);
            self.timing.add(seconds, on_device_s.is_some());
            // The first use is not measured: the driver may have compiled, which either clock
            // includes.
            if std::mem::replace(&mut compiled.has_run, true) {
                compiled.tile_budget.note(tile.work, seconds);
            }
            if is_last {
                self.timing.read_bytes += pass.output_bytes;
                return Ok(submission);
            }
        }
        unreachable!("a pass has at least one program")
    }

    /// Resizes the buffers for one pass, uploads its words and binds everything.
    fn bind(&mut self, pass: &Pass<'_>) -> Result<wgpu::BindGroup, GpuError> {
        let Self { device, layouts, tile, words, outputs, staging, .. } = self;
        let layout = &layouts[pass.kernel as usize];
        device.scoped(|| {
            staging.fit(device, pass.output_bytes);
            let words = words.fit(device, size_of_val(pass.words) as u64);
            device.queue.write_buffer(words, 0, bytemuck::cast_slice(pass.words));
            let tile = tile.fit(device, size_of::<TileUniform>() as u64);
            let outputs = outputs.fit(device, pass.output_bytes);
            let buffers = [tile, words, pass.inputs, outputs].into_iter().chain(pass.targets);
            let entries: Vec<wgpu::BindGroupEntry<'_>> = buffers
                .zip(0..)
                .map(|(buffer, binding)| wgpu::BindGroupEntry {
                    binding,
                    resource: buffer.as_entire_binding(),
                })
                .collect();
            let descriptor = wgpu::BindGroupDescriptor { label: None, layout, entries: &entries };
            device.api.create_bind_group(&descriptor)
        })
    }
}
