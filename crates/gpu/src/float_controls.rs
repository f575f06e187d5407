//! Drivers that keep subnormal numbers on request. The graphics API does not list them.

/// Name of NVIDIA's own Vulkan driver. It denies the property, but obeys the request: with driver
/// 580.159 every bit is then right. The probe checks that wherever it is used.
const OBEYS: &str = "NVIDIA";

/// True if shaders on this adapter may request that subnormal f32 are kept.
pub(crate) fn keeps_subnormals(adapter: &wgpu::Adapter) -> bool {
    let info = adapter.get_info();
    info.backend == wgpu::Backend::Vulkan && (info.driver == OBEYS || has_property(adapter))
}

/// True if a Vulkan driver states that it keeps subnormal f32 on request.
#[cfg(not(target_vendor = "apple"))]
#[expect(unsafe_code, reason = "a question to the Vulkan driver")]
fn has_property(adapter: &wgpu::Adapter) -> bool {
    use ash::vk;

    // SAFETY: the handles are not destroyed and not used beyond this function.
    let Some(hal) = (unsafe { adapter.as_hal::<wgpu::hal::api::Vulkan>() }) else {
        return false;
    };
    // The property belongs to Vulkan 1.2, the way to ask for it to 1.1.
    let version = hal.physical_device_capabilities().properties().api_version;
    if version.min(hal.shared_instance().instance_api_version()) < vk::API_VERSION_1_2 {
        return false;
    }
    let mut controls = vk::PhysicalDeviceFloatControlsProperties::default();
    let mut properties = vk::PhysicalDeviceProperties2::default().push_next(&mut controls);
    let instance = hal.shared_instance().raw_instance();
    // SAFETY: the physical device belongs to this instance, both are at least of version 1.2, and
    // the chain of structures lives until after the call.
    unsafe {
        instance.get_physical_device_properties2(hal.raw_physical_device(), &mut properties);
    }
    controls.shader_denorm_preserve_float32 == vk::TRUE
}

/// False: this system has no Vulkan drivers.
#[cfg(target_vendor = "apple")]
fn has_property(_adapter: &wgpu::Adapter) -> bool {
    false
}
