//! Which adapter is taken, and what is reported about it.

use std::time::Duration;

use crate::guard::{Guard, Rung};
use crate::shape::Shape;

/// What a caller may decide.
#[derive(Debug, Clone, PartialEq)]
pub struct GpuOptions {
    /// Only adapters whose name contains this text, letter case aside.
    pub adapter: Option<String>,
    /// Whether an adapter that is a program on the CPU will do.
    pub allow_software: bool,
    /// How contraction of products and sums is kept away.
    pub contraction: Contraction,
    /// How the interpreter is laid out; `None` for the layout that is measured to be the fastest on hardware, and the
    /// default one on a software adapter.
    pub shape: Option<Shape>,
    /// When a program that is evaluated alone gets a pipeline of its own.
    pub own_pipelines: OwnPipelinePolicy,
    /// Most bytes of inputs that stay on the device for the next batch over the same sample set.
    pub resident_bytes: u64,
    /// How long one submission may take before the device counts as lost; four times as long where the driver may have
    /// to compile the shader first.
    pub timeout: Duration,
    /// What one submission should take; work is cut to it as the device's pace is learnt. The default leaves room for
    /// programs that are slower than others, so that none holds the device for 100 ms.
    pub submission: Duration,
    /// Most bytes of one buffer, below what the device allows.
    pub buffer_bytes: u64,
}

/// How products and sums are kept from being contracted or reassociated by the driver's compiler.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Contraction {
    /// Plain code where the start-up probe finds it exact, else the fastest exact guard, else plain code.
    #[default]
    Probe,
    /// One guard, exact or not.
    Only(Guard),
}

/// When a program that is evaluated alone gets a pipeline of its own.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum OwnPipelinePolicy {
    /// As soon as interpreting it has taken as long as compiling it is going to take.
    #[default]
    WhenItPays,
    /// At its first evaluation; for tests and measurements.
    Always,
    /// Never.
    Never,
}

impl Default for GpuOptions {
    fn default() -> Self {
        Self {
            adapter: None,
            allow_software: true,
            contraction: Contraction::Probe,
            shape: None,
            own_pipelines: OwnPipelinePolicy::WhenItPays,
            resident_bytes: 256 << 20,
            timeout: Duration::from_secs(20),
            submission: Duration::from_millis(50),
            buffer_bytes: 64 << 20,
        }
    }
}

/// What runs, and what the start-up probe found about it.
#[derive(Debug, Clone, PartialEq)]
pub struct AdapterReport {
    /// As the driver names it.
    pub name: String,
    /// Vulkan, Metal or DirectX 12.
    pub backend: String,
    /// Driver and version.
    pub driver: String,
    /// Whether the adapter is a program on the CPU; such a one is never chosen for speed.
    pub is_software: bool,
    /// Whether every bit of the probe was that of the canonical evaluator, subnormal results aside.
    pub exact: bool,
    /// Whether subnormal results came out as zero.
    pub flushes_subnormals: bool,
    /// What the probe did and found, for people.
    pub detail: String,
    /// The guards against contraction that were probed, from below.
    pub rungs: Vec<Rung>,
    /// The guard in use.
    pub guard: Guard,
    /// The layout in use.
    pub shape: Shape,
    /// The layouts and guards that were timed, with the seconds of one batch on the device, the fastest first.
    pub timed: Vec<(Shape, Guard, f64)>,
    /// Whether the adapter gives timestamps.
    pub has_timestamps: bool,
}

/// The adapters that the options allow, the best first, with the instance that they belong to.
pub(crate) fn find(options: &GpuOptions) -> (wgpu::Instance, Vec<wgpu::Adapter>) {
    let backends = wgpu::Backends::PRIMARY;
    let instance = wgpu::Instance::new(wgpu::InstanceDescriptor {
        backends,
        ..wgpu::InstanceDescriptor::new_without_display_handle()
    });
    let wanted = options.adapter.as_ref().map(|name| name.to_lowercase());
    let mut adapters = pollster::block_on(instance.enumerate_adapters(backends));
    adapters.retain(|adapter| {
        let info = adapter.get_info();
        let named = wanted.as_ref().is_none_or(|n| info.name.to_lowercase().contains(n));
        named && (options.allow_software || !is_software(&info)) && can_compute(adapter)
    });
    adapters.sort_by_key(|adapter| rank(adapter.get_info().device_type));
    (instance, adapters)
}

/// What there is to say before the probe.
pub(crate) fn describe(info: &wgpu::AdapterInfo) -> AdapterReport {
    AdapterReport {
        name: info.name.clone(),
        backend: info.backend.to_string(),
        driver: format!("{} {}", info.driver, info.driver_info).trim().to_owned(),
        is_software: is_software(info),
        exact: false,
        flushes_subnormals: false,
        detail: String::new(),
        rungs: Vec::new(),
        guard: Guard::Plain,
        shape: Shape::default(),
        timed: Vec::new(),
        has_timestamps: false,
    }
}

fn is_software(info: &wgpu::AdapterInfo) -> bool {
    info.device_type == wgpu::DeviceType::Cpu
}

fn can_compute(adapter: &wgpu::Adapter) -> bool {
    let flags = adapter.get_downlevel_capabilities().flags;
    flags.contains(wgpu::DownlevelFlags::COMPUTE_SHADERS)
}

fn rank(kind: wgpu::DeviceType) -> u8 {
    match kind {
        wgpu::DeviceType::DiscreteGpu => 0,
        wgpu::DeviceType::IntegratedGpu => 1,
        wgpu::DeviceType::VirtualGpu => 2,
        wgpu::DeviceType::Other => 3,
        wgpu::DeviceType::Cpu => 4,
    }
}
