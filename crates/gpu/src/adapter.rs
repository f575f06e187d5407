//! Choice of an adapter, and the report about it.

use std::time::Duration;

use crate::guard::{Guard, GuardReport};
use crate::interpreter_layout::InterpreterLayout;

/// Options of a [`crate::GpuEvaluator`].
#[derive(Debug, Clone, PartialEq)]
pub struct GpuOptions {
    /// If set, only adapters whose name contains this text are used, ignoring case.
    pub adapter: Option<String>,
    /// True if a software adapter, which runs on the CPU, is acceptable.
    pub allow_software: bool,
    /// Guard against contraction of products and sums.
    pub contraction: Contraction,
    /// Layout of the interpreter. `None` measures the fastest one on hardware and uses the default
    /// one on a software adapter.
    pub shape: Option<InterpreterLayout>,
    /// Policy of compiling a pipeline for a single program.
    pub own_pipelines: OwnPipelinePolicy,
    /// Largest number of bytes of inputs that stay on the device for the next batch over the same
    /// sample set.
    pub resident_bytes: u64,
    /// Time after which a submission makes the device count as lost; four times this for the first
    /// use of a pipeline, where the driver may have to compile the shader.
    pub timeout: Duration,
    /// Target time of one submission; work is divided according to the measured throughput of the
    /// device. The default leaves room for programs that are slower than others, so that none
    /// occupies the device for 100 ms.
    pub submission: Duration,
    /// Largest number of bytes of one buffer, if below the limit of the device.
    pub buffer_bytes: u64,
}

/// Means against contraction and reassociation of products and sums by the compiler of the driver.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Contraction {
    /// Plain code if the start-up probe finds it exact, else the fastest exact guard, else plain
    /// code.
    #[default]
    Probe,
    /// This guard, exact or not.
    Only(Guard),
}

/// Policy of compiling a pipeline for a single program that is evaluated alone.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum OwnPipelinePolicy {
    /// Once interpreting the program has taken as long as compiling it is expected to take.
    #[default]
    WhenItPays,
    /// At the first evaluation; for tests and measurements.
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

/// The adapter in use and the result of the start-up probe.
#[derive(Debug, Clone, PartialEq)]
pub struct AdapterReport {
    /// Name given by the driver.
    pub name: String,
    /// Graphics API: Vulkan, Metal or DirectX 12.
    pub backend: String,
    /// Driver and its version.
    pub driver: String,
    /// True if the adapter runs on the CPU; such an adapter is never chosen for speed.
    pub is_software: bool,
    /// True if every bit of the probe was that of the canonical evaluator.
    pub exact: bool,
    /// True if subnormal results are flushed to zero. Such an adapter is not exact: a program may
    /// make a normal number of a subnormal one, with differing bits on either side.
    pub flushes_subnormals: bool,
    /// Summary of the probe for people.
    pub detail: String,
    /// Guards that were probed, the plainest first.
    pub guards: Vec<GuardReport>,
    /// Guard in use.
    pub guard: Guard,
    /// Layout in use.
    pub shape: InterpreterLayout,
    /// Layouts and guards that were timed, with seconds per batch on the device, fastest first.
    pub timed: Vec<(InterpreterLayout, Guard, f64)>,
    /// True if the adapter supports timestamps.
    pub has_timestamps: bool,
}

/// Returns the adapters that the options allow, best first, with the instance that they belong to.
pub(crate) fn find(options: &GpuOptions) -> (wgpu::Instance, Vec<wgpu::Adapter>) {
    let backends = wgpu::Backends::PRIMARY;
    let instance = wgpu::Instance::new(wgpu::InstanceDescriptor {
        backends,
        ..wgpu::InstanceDescriptor::new_without_display_handle()
    });
    let name_part = options.adapter.as_ref().map(|name| name.to_lowercase());
    let mut adapters = pollster::block_on(instance.enumerate_adapters(backends));
    adapters.retain(|adapter| {
        let info = adapter.get_info();
        let named = name_part.as_ref().is_none_or(|n| info.name.to_lowercase().contains(n));
        named && (options.allow_software || !is_software(&info)) && can_compute(adapter)
    });
    adapters.sort_by_key(|adapter| rank(adapter.get_info().device_type));
    (instance, adapters)
}

/// Returns the report before the probe.
pub(crate) fn describe(info: &wgpu::AdapterInfo) -> AdapterReport {
    AdapterReport {
        name: info.name.clone(),
        backend: info.backend.to_string(),
        driver: format!("{} {}", info.driver, info.driver_info).trim().to_owned(),
        is_software: is_software(info),
        exact: false,
        flushes_subnormals: false,
        detail: String::new(),
        guards: Vec::new(),
        guard: Guard::Plain,
        shape: InterpreterLayout::default(),
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

/// Returns the place of a kind of adapter in the order of preference.
fn rank(kind: wgpu::DeviceType) -> u8 {
    match kind {
        wgpu::DeviceType::DiscreteGpu => 0,
        wgpu::DeviceType::IntegratedGpu => 1,
        wgpu::DeviceType::VirtualGpu => 2,
        wgpu::DeviceType::Other => 3,
        wgpu::DeviceType::Cpu => 4,
    }
}
