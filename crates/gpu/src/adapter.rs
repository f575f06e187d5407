//! Which adapter is taken, and what is reported about it.

use std::time::Duration;

/// What a caller may decide.
#[derive(Debug, Clone, PartialEq)]
pub struct GpuOptions {
    /// Only adapters whose name contains this text, letter case aside.
    pub adapter: Option<String>,
    /// Whether an adapter that is a program on the CPU will do.
    pub allow_software: bool,
    /// How contraction of products and sums is kept away.
    pub contraction: Contraction,
    /// How long one submission may take before the device counts as lost; four times as long where the driver may have
    /// to compile the shader first.
    pub timeout: Duration,
    /// What one submission should take at most; work is cut to it as the device's pace is learnt.
    pub submission: Duration,
    /// Most bytes of one buffer, below what the device allows.
    pub buffer_bytes: u64,
}

/// How products and sums are kept from being contracted or reassociated by the driver's compiler.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Contraction {
    /// Plain code where the start-up probe finds it exact, else with barriers.
    #[default]
    Probe,
    /// Plain code, exact or not.
    Plain,
    /// Every intermediate result passes an exclusive or with a zero that the compiler does not know.
    Barrier,
}

impl Default for GpuOptions {
    fn default() -> Self {
        Self {
            adapter: None,
            allow_software: true,
            contraction: Contraction::Probe,
            timeout: Duration::from_secs(20),
            submission: Duration::from_millis(50),
            buffer_bytes: 64 << 20,
        }
    }
}

/// What runs, and what the start-up probe found about it.
#[derive(Debug, Clone, PartialEq, Eq)]
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
