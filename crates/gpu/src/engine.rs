//! One device with its pipelines and buffers: takes a batch of programs and rows of inputs, gives reflectances.
//!
//! It knows neither sample sets nor evaluators; what happens after a failure is its owner's business.

use std::collections::{HashMap, HashSet};
use std::ops::Range;
use std::time::Instant;

use brood_brdf::InputMask;
use brood_program::Program;

use crate::device::Device;
use crate::encode::{Encoded, LANES, WORKGROUP, pack};
use crate::pipeline::{bind_group_layout, build_pipeline};
use crate::plan::{Bounds, Pace, after, next_tile, padded};
use crate::shader::{REGISTER_FILES, Variant};
use crate::{GpuError, GpuOptions};

/// The inputs of a batch: one row for each input of `mask`, in the order of their indices, all of length `len`.
#[derive(Debug)]
pub(crate) struct Rows<'a> {
    pub mask: InputMask,
    pub rows: Vec<&'a [f32]>,
    pub len: usize,
}

/// The uniform block of one dispatch: `Tile` of interpreter.wgsl, padded to whole vectors.
#[derive(Debug, Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
struct TileUniform {
    zero: u32,
    first_program: u32,
    first_block: u32,
    end_block: u32,
    stride: u32,
    padding: [u32; 3],
}

#[derive(Debug)]
pub(crate) struct Engine {
    pub device: Device,
    barrier: bool,
    layout: wgpu::BindGroupLayout,
    pipelines: HashMap<Variant, wgpu::ComputePipeline>,
    /// Pipelines that have run; drivers may put compilation off until then.
    compiled: HashSet<Variant>,
    tile: Slot,
    words: Slot,
    inputs: Slot,
    outputs: Slot,
    staging: Slot,
    pace: Pace,
}

impl Engine {
    pub(crate) fn open(options: &GpuOptions, barrier: bool) -> Result<Self, GpuError> {
        use wgpu::BufferUsages as Usage;
        let device = Device::open(options)?;
        let layout = device.scoped(|| bind_group_layout(&device.api))?;
        Ok(Self {
            device,
            barrier,
            layout,
            pipelines: HashMap::new(),
            compiled: HashSet::new(),
            tile: Slot::new("tile", Usage::UNIFORM | Usage::COPY_DST),
            words: Slot::new("words", Usage::STORAGE | Usage::COPY_DST),
            inputs: Slot::new("inputs", Usage::STORAGE | Usage::COPY_DST),
            outputs: Slot::new("outputs", Usage::STORAGE | Usage::COPY_SRC),
            staging: Slot::new("staging", Usage::MAP_READ | Usage::COPY_DST),
            pace: Pace::new(options.submission.as_secs_f64()),
        })
    }

    /// Changes whether pipelines carry barriers from now on.
    pub(crate) fn set_barrier(&mut self, barrier: bool) {
        self.barrier = barrier;
    }

    /// Evaluates all programs on all samples.
    ///
    /// # Shapes
    /// `out` is filled as [program][channel][sample].
    pub(crate) fn run(
        &mut self,
        programs: &[&Program],
        rows: &Rows<'_>,
        out: &mut [f32],
    ) -> Result<(), GpuError> {
        if programs.is_empty() || rows.len == 0 {
            return Ok(());
        }
        let encoded = programs
            .iter()
            .map(|program| Encoded::new(program, rows.mask))
            .collect::<Result<Vec<_>, _>>()?;
        let (variant, pipeline) = self.pipeline(&encoded)?;
        let bounds = Bounds { buffer_bytes: self.device.buffer_bytes };
        let slab = bounds.slab(rows.rows.len());
        for start in (0..rows.len).step_by(slab) {
            let samples = start..rows.len.min(start + slab);
            self.upload_inputs(rows, &samples)?;
            for group in bounds.groups(&encoded, samples.len()) {
                let first = group.start;
                let pass = Pass {
                    variant,
                    pipeline: &pipeline,
                    programs: &encoded[group],
                    samples: samples.len(),
                };
                let (submission, bytes) = self.dispatch(&pass)?;
                let stride = usize::try_from(padded(samples.len())).expect("fits a buffer");
                let staging = self.staging.get();
                self.device.read(staging, bytes, submission, |view| {
                    let values: &[f32] = bytemuck::cast_slice(view);
                    for (index, row) in values.chunks_exact(stride).enumerate() {
                        let target = (3 * first + index) * rows.len;
                        out[target..][samples.clone()].copy_from_slice(&row[..samples.len()]);
                    }
                })?;
            }
        }
        Ok(())
    }

    /// The pipeline with the smallest register file that holds every program.
    fn pipeline(
        &mut self,
        programs: &[Encoded],
    ) -> Result<(Variant, wgpu::ComputePipeline), GpuError> {
        let needed = programs.iter().map(Encoded::registers).max().unwrap_or(0);
        let Some(registers) = REGISTER_FILES.into_iter().find(|file| *file >= needed) else {
            let most = REGISTER_FILES[REGISTER_FILES.len() - 1] as usize;
            return Err(GpuError::TooLarge {
                what: "live registers",
                given: needed as usize,
                most,
            });
        };
        let variant = Variant { registers, barrier: self.barrier };
        if let Some(pipeline) = self.pipelines.get(&variant) {
            return Ok((variant, pipeline.clone()));
        }
        let api = &self.device.api;
        let build = || build_pipeline(api, &self.layout, variant);
        let pipeline = self.device.scoped(build)?;
        self.pipelines.insert(variant, pipeline.clone());
        Ok((variant, pipeline))
    }

    fn upload_inputs(&mut self, rows: &Rows<'_>, samples: &Range<usize>) -> Result<(), GpuError> {
        let row_bytes = padded(samples.len()) * 4;
        let Self { device, inputs, .. } = self;
        device.scoped(|| {
            // A binding must not be empty, even where no program of the batch reads an input.
            let buffer = inputs.fit(device, row_bytes * rows.rows.len().max(1) as u64);
            for (row, offset) in rows.rows.iter().zip((0..).step_by(row_bytes as usize)) {
                let bytes = bytemuck::cast_slice(&row[samples.clone()]);
                device.queue.write_buffer(buffer, offset, bytes);
            }
        })
    }

    /// Runs one pass tile by tile, each waited for; behind the last the outputs are copied for reading.
    /// Returns the last submission and how many bytes there will be.
    fn dispatch(&mut self, pass: &Pass<'_>) -> Result<(wgpu::SubmissionIndex, u64), GpuError> {
        let words = pack(pass.programs);
        let stride = u32::try_from(padded(pass.samples) / u64::from(LANES)).expect("fits a buffer");
        let bytes = padded(pass.samples) * 4 * 3 * pass.programs.len() as u64;
        let group = self.prepare(&words, bytes)?;
        let mut from = (0, 0);
        let mut tile = next_tile(pass.programs, stride, from, self.pace.budget())
            .expect("a pass has at least one program");
        loop {
            from = after(&tile, stride);
            let is_last = from.0 as usize == pass.programs.len();
            let started = Instant::now();
            let submission = self.device.scoped(|| {
                let uniform = TileUniform {
                    zero: 0,
                    first_program: tile.programs.start,
                    first_block: tile.blocks.start,
                    end_block: tile.blocks.end,
                    stride,
                    padding: [0; 3],
                };
                let queue = &self.device.queue;
                queue.write_buffer(self.tile.get(), 0, bytemuck::bytes_of(&uniform));
                let mut encoder = self.device.api.create_command_encoder(&Default::default());
                let mut compute = encoder.begin_compute_pass(&Default::default());
                compute.set_pipeline(pass.pipeline);
                compute.set_bind_group(0, &group, &[]);
                let blocks = tile.blocks.end - tile.blocks.start;
                let programs = tile.programs.end - tile.programs.start;
                compute.dispatch_workgroups(blocks.div_ceil(WORKGROUP), programs, 1);
                drop(compute);
                if is_last {
                    let (outputs, staging) = (self.outputs.get(), self.staging.get());
                    encoder.copy_buffer_to_buffer(outputs, 0, staging, 0, bytes);
                }
                queue.submit([encoder.finish()])
            })?;
            // Waiting also for the last tile keeps the pace measured; what is left for the reader is the mapping.
            if self.compiled.insert(pass.variant) {
                self.device.wait_for_first_use(submission.clone())?;
            } else {
                self.device.wait(submission.clone())?;
                self.pace.note(tile.work, started.elapsed().as_secs_f64());
            }
            match next_tile(pass.programs, stride, from, self.pace.budget()) {
                Some(next) => tile = next,
                None => return Ok((submission, bytes)),
            }
        }
    }

    /// Makes room for one pass, uploads its words and binds everything.
    fn prepare(&mut self, words: &[u32], bytes: u64) -> Result<wgpu::BindGroup, GpuError> {
        let Self { device, layout, tile, words: programs, inputs, outputs, staging, .. } = self;
        device.scoped(|| {
            let buffers = [
                tile.fit(device, size_of::<TileUniform>() as u64),
                programs.fit(device, size_of_val(words) as u64),
                inputs.get(),
                outputs.fit(device, bytes),
            ];
            staging.fit(device, bytes);
            device.queue.write_buffer(buffers[1], 0, bytemuck::cast_slice(words));
            let mut binding = 0;
            let entries = buffers.map(|buffer| {
                binding += 1;
                wgpu::BindGroupEntry { binding: binding - 1, resource: buffer.as_entire_binding() }
            });
            let descriptor = wgpu::BindGroupDescriptor { label: None, layout, entries: &entries };
            device.api.create_bind_group(&descriptor)
        })
    }
}

/// What one round of dispatches and one reading back are about.
struct Pass<'a> {
    variant: Variant,
    pipeline: &'a wgpu::ComputePipeline,
    programs: &'a [Encoded],
    samples: usize,
}

/// A buffer that is kept between calls and made anew only where it is too small.
#[derive(Debug)]
struct Slot {
    label: &'static str,
    usage: wgpu::BufferUsages,
    buffer: Option<wgpu::Buffer>,
}

impl Slot {
    fn new(label: &'static str, usage: wgpu::BufferUsages) -> Self {
        Self { label, usage, buffer: None }
    }

    /// The buffer, with at least that many bytes.
    fn fit(&mut self, device: &Device, bytes: u64) -> &wgpu::Buffer {
        if self.buffer.as_ref().is_none_or(|buffer| buffer.size() < bytes) {
            let roomy = bytes.next_power_of_two().min(device.buffer_bytes.max(bytes));
            self.buffer = Some(device.api.create_buffer(&wgpu::BufferDescriptor {
                label: Some(self.label),
                size: roomy.next_multiple_of(16),
                usage: self.usage,
                mapped_at_creation: false,
            }));
        }
        self.get()
    }

    fn get(&self) -> &wgpu::Buffer {
        self.buffer.as_ref().expect("a pass is prepared before it runs")
    }
}
