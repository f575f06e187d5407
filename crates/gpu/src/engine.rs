//! Engine: one device with its pipelines and buffers, which evaluates a batch of programs on rows
//! of inputs. plan.rs defines how a batch is divided.
//!
//! Independent of sample sets and evaluators; the owner of an engine handles failures.

mod batch;
mod dispatch;
mod own;
mod sums;

use std::collections::HashMap;

use brood_program::Program;

use crate::clock::Clock;
use crate::device::Device;
use crate::encode::{Encoded, encode, pack};
use crate::guard::Guard;
use crate::own::OwnPipelines;
use crate::pass::Pass;
use crate::pipeline::{Compiled, bind_group_layout, build_pipeline};
use crate::plan::{Bounds, TileBudget, count, grid, padded, reflectance_bytes};
use crate::residency::{Residency, Rows};
use crate::shader::{Kernel, REGISTER_FILES, Style, Variant, source};
use crate::slot::Slot;
use crate::straight;
use crate::sums::ResidentTargets;
use crate::threads;
use crate::timing::BatchTiming;
use crate::{GpuError, GpuOptions};
use batch::{Batch, BatchShader};

/// Number of values whose copying is worth a thread of its own: it takes 0.1 ms or more.
const COPIED: usize = 1 << 18;

/// A device with everything that evaluations on it need.
#[derive(Debug)]
pub(crate) struct Engine {
    pub device: Device,
    /// Style of the shaders of the next batches.
    pub style: Style,
    /// Guards at which shaders contract deliberately, for tests of the guard search.
    pub contracting: Vec<Guard>,
    /// Cost since it was last reset.
    pub timing: BatchTiming,
    /// Straight-line pipelines of single programs.
    own: OwnPipelines,
    /// Inputs on the device.
    pub(crate) residency: Residency,
    /// Targets on the device.
    resident_targets: Option<ResidentTargets>,
    /// Timestamps, if the device has them.
    pub(crate) clock: Option<Clock>,
    /// Layouts of the bindings, by [`Kernel`].
    layouts: [wgpu::BindGroupLayout; 2],
    /// Uniform block of a dispatch.
    tile: Slot,
    /// Encoded programs.
    words: Slot,
    /// Results on the device.
    outputs: Slot,
    /// Copy of the results that the CPU can map.
    staging: Slot,
    /// Pipelines of the interpreter.
    pipelines: HashMap<Variant, Compiled>,
    /// Target time of one submission, in seconds.
    submission_s: f64,
}

impl Engine {
    /// Opens the best adapter that the options allow.
    pub(crate) fn open(options: &GpuOptions, style: Style) -> Result<Self, GpuError> {
        use wgpu::BufferUsages as Usage;
        let device = Device::open(options)?;
        let kernels = [Kernel::Reflectance, Kernel::Fitness];
        let layouts = device.scoped(|| kernels.map(|k| bind_group_layout(&device.api, k)))?;
        Ok(Self {
            clock: Clock::new(&device)?,
            device,
            style,
            contracting: Vec::new(),
            timing: BatchTiming::default(),
            own: OwnPipelines::new(options.own_pipelines),
            residency: Residency::new(options.resident_bytes),
            resident_targets: None,
            layouts,
            tile: Slot::new("tile", Usage::UNIFORM | Usage::COPY_DST),
            words: Slot::new("words", Usage::STORAGE | Usage::COPY_DST),
            outputs: Slot::new("outputs", Usage::STORAGE | Usage::COPY_SRC),
            staging: Slot::new("staging", Usage::MAP_READ | Usage::COPY_DST),
            pipelines: HashMap::new(),
            submission_s: options.submission.as_secs_f64(),
        })
    }

    /// Sets the style of code from now on.
    pub(crate) fn set_style(&mut self, style: Style) {
        self.style = Style { contracts: self.contracting.contains(&style.guard), ..style };
    }

    /// Evaluates all programs on all samples. A single program runs in its own pipeline if it has
    /// one; otherwise it is interpreted, and its own pipeline is compiled if that has become worth
    /// while.
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
        let mask = self.residency.mask(rows);
        let encoded = encode(programs, mask)?;
        let (variant, mut compiled) = self.pipeline(Kernel::Reflectance, &encoded)?;
        let mut batch = Batch { shader: BatchShader::Interpreter, encoded: &encoded, rows, mask };
        let [program] = programs else {
            self.reflectances(&batch, variant.style, &mut compiled, out)?;
            self.keep(variant, compiled);
            return Ok(());
        };
        let hash = program.hash();
        if let Some(mut own) = self.own.pipeline(hash) {
            batch.shader = BatchShader::Own(program);
            self.reflectances(&batch, self.style, &mut own, out)?;
            self.own.store(hash, own);
            self.timing.own_pipeline = true;
            return Ok(());
        }
        let before_s = self.timing.device_s;
        let is_measured = compiled.has_run;
        self.reflectances(&batch, variant.style, &mut compiled, out)?;
        self.keep(variant, compiled);
        // The first run may include the compilation of the interpreter.
        if is_measured {
            self.own.note(hash, self.timing.device_s - before_s);
        }
        if self.own.is_worth_while(hash, program.steps().len()) {
            batch.shader = BatchShader::Own(program);
            self.compile_own(program, &batch, out)?;
        }
        Ok(())
    }

    /// Returns the pipeline of the interpreter with the smallest register file that holds every
    /// program.
    pub(crate) fn pipeline(
        &mut self,
        kernel: Kernel,
        programs: &[Encoded],
    ) -> Result<(Variant, Compiled), GpuError> {
        let needed = programs.iter().map(Encoded::registers).max().unwrap_or(0);
        let Some(registers) = REGISTER_FILES.into_iter().find(|file| *file >= needed) else {
            let most = REGISTER_FILES[REGISTER_FILES.len() - 1] as usize;
            return Err(GpuError::TooLarge {
                what: "live registers",
                given: needed as usize,
                most,
            });
        };
        let variant = Variant::new(kernel, self.style, registers, self.device.workgroup_bytes);
        if let Some(compiled) = self.pipelines.get(&variant) {
            return Ok((variant, compiled.clone()));
        }
        let compiled = self.compile(kernel, &source(variant), variant.style.guard)?;
        self.pipelines.insert(variant, compiled.clone());
        Ok((variant, compiled))
    }

    /// Stores a pipeline with its measured throughput.
    pub(crate) fn keep(&mut self, variant: Variant, compiled: Compiled) {
        self.pipelines.insert(variant, compiled);
    }

    /// Compiles a shader.
    pub(crate) fn compile(
        &self,
        kernel: Kernel,
        text: &str,
        guard: Guard,
    ) -> Result<Compiled, GpuError> {
        let layout = &self.layouts[kernel as usize];
        Ok(Compiled {
            pipeline: build_pipeline(&self.device, layout, text, guard)?,
            has_run: false,
            tile_budget: TileBudget::new(self.submission_s),
        })
    }

    pub(crate) fn bounds(&self) -> Bounds {
        Bounds { buffer_bytes: self.device.buffer_bytes }
    }

    /// Runs a batch with one pipeline, divided into parts that fit the buffers.
    pub(crate) fn reflectances(
        &mut self,
        batch: &Batch<'_, '_>,
        style: Style,
        compiled: &mut Compiled,
        out: &mut [f32],
    ) -> Result<(), GpuError> {
        let Batch { rows, mask, .. } = *batch;
        let bounds = self.bounds();
        let slab = bounds.slab(mask.len());
        for start in (0..rows.len).step_by(slab) {
            let samples = start..rows.len.min(start + slab);
            let (inputs, sent) = self.residency.inputs(&self.device, rows, mask, &samples)?;
            self.timing.uploaded_bytes += sent;
            let bytes = reflectance_bytes(samples.len());
            for group in bounds.groups(batch.encoded, bytes) {
                let first = group.start;
                let programs = &batch.encoded[group];
                let grid = grid(samples.len(), style, Kernel::Reflectance);
                let pass = Pass {
                    kernel: Kernel::Reflectance,
                    programs,
                    words: &match batch.shader {
                        BatchShader::Interpreter => pack(programs),
                        BatchShader::Own(program) => straight::words(program, mask),
                    },
                    inputs: &inputs,
                    targets: None,
                    grid,
                    blocks: 0..grid.blocks,
                    samples: count(samples.len()),
                    sums: 0,
                    logarithmic: false,
                    output_bytes: bytes * programs.len() as u64,
                };
                let submission = self.dispatch(&pass, compiled)?;
                let stride =
                    usize::try_from(padded(samples.len())).expect("samples of a slab fit a buffer");
                let staging = self.staging.get();
                self.device.read(staging, pass.output_bytes, submission, |view| {
                    let values: &[f32] = bytemuck::cast_slice(view);
                    let targets = out[3 * first * rows.len..].chunks_exact_mut(rows.len);
                    let pairs = values.chunks_exact(stride).zip(targets).collect();
                    threads::map(pairs, COPIED.div_ceil(stride), |(row, target)| {
                        target[samples.clone()].copy_from_slice(&row[..samples.len()]);
                    });
                })?;
            }
        }
        Ok(())
    }
}
