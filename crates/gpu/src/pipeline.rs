//! Bind group layouts and compute pipelines, the same for all shaders.

use crate::GpuError;
use crate::device::Device;
use crate::guard::Guard;
use crate::marked;
use crate::plan::TileBudget;
use crate::shader::{ENTRY_POINT, Kernel};

/// A pipeline with its measured throughput.
#[derive(Debug, Clone)]
pub(crate) struct Compiled {
    pub pipeline: wgpu::ComputePipeline,
    /// False before the first use, to which drivers may defer compilation.
    pub has_run: bool,
    pub tile_budget: TileBudget,
}

/// Returns the layout of the buffers of a kernel, in the order of their bindings: tile, words,
/// inputs, outputs, and targets for fitness.
pub(crate) fn bind_group_layout(api: &wgpu::Device, kernel: Kernel) -> wgpu::BindGroupLayout {
    use wgpu::BufferBindingType::{Storage, Uniform};
    let read = Storage { read_only: true };
    let mut types = vec![Uniform, read, read, Storage { read_only: false }];
    if kernel == Kernel::Fitness {
        types.push(read);
    }
    let entries: Vec<wgpu::BindGroupLayoutEntry> = types
        .into_iter()
        .zip(0..)
        .map(|(ty, binding)| wgpu::BindGroupLayoutEntry {
            binding,
            visibility: wgpu::ShaderStages::COMPUTE,
            ty: wgpu::BindingType::Buffer { ty, has_dynamic_offset: false, min_binding_size: None },
            count: None,
        })
        .collect();
    let descriptor = wgpu::BindGroupLayoutDescriptor { label: None, entries: &entries };
    api.create_bind_group_layout(&descriptor)
}

/// Compiles a shader, unless the driver defers that to the first use.
pub(crate) fn build_pipeline(
    device: &Device,
    layout: &wgpu::BindGroupLayout,
    text: &str,
    guard: Guard,
) -> Result<wgpu::ComputePipeline, GpuError> {
    let api = &device.api;
    device.scoped(|| {
        let module = match guard {
            Guard::Plain | Guard::Barrier => {
                api.create_shader_module(wgpu::ShaderModuleDescriptor {
                    label: Some("interpreter"),
                    source: wgpu::ShaderSource::Wgsl(text.into()),
                })
            }
            Guard::NoContraction => marked::module(device, text)?,
        };
        let layout = api.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: None,
            bind_group_layouts: &[Some(layout)],
            immediate_size: 0,
        });
        Ok(api.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label: Some("interpreter"),
            layout: Some(&layout),
            module: &module,
            entry_point: Some(ENTRY_POINT),
            compilation_options: wgpu::PipelineCompilationOptions {
                // Registers, like everything else, are written before they are read.
                zero_initialize_workgroup_memory: false,
                ..wgpu::PipelineCompilationOptions::default()
            },
            cache: None,
        }))
    })?
}
