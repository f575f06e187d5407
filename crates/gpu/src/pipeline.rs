//! Layout and pipelines of the interpreter, as the API wants them described. What they compute is in the shader.

use crate::shader::{ENTRY_POINT, Variant, source};

/// The four buffers of interpreter.wgsl, in the order of their bindings.
pub(crate) fn bind_group_layout(api: &wgpu::Device) -> wgpu::BindGroupLayout {
    use wgpu::BufferBindingType::{Storage, Uniform};
    let types = [
        Uniform,
        Storage { read_only: true },
        Storage { read_only: true },
        Storage { read_only: false },
    ];
    let mut binding = 0;
    let entries = types.map(|ty| {
        binding += 1;
        wgpu::BindGroupLayoutEntry {
            binding: binding - 1,
            visibility: wgpu::ShaderStages::COMPUTE,
            ty: wgpu::BindingType::Buffer { ty, has_dynamic_offset: false, min_binding_size: None },
            count: None,
        }
    });
    api.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
        label: None,
        entries: &entries,
    })
}

/// Compiles one variant of the shader, as far as the driver does so before its first use.
pub(crate) fn build_pipeline(
    api: &wgpu::Device,
    layout: &wgpu::BindGroupLayout,
    variant: Variant,
) -> wgpu::ComputePipeline {
    let module = api.create_shader_module(wgpu::ShaderModuleDescriptor {
        label: Some("interpreter"),
        source: wgpu::ShaderSource::Wgsl(source(variant).into()),
    });
    let layout = api.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
        label: None,
        bind_group_layouts: &[Some(layout)],
        immediate_size: 0,
    });
    api.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
        label: Some("interpreter"),
        layout: Some(&layout),
        module: &module,
        entry_point: Some(ENTRY_POINT),
        compilation_options: wgpu::PipelineCompilationOptions::default(),
        cache: None,
    })
}
