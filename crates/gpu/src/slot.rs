//! Reusable buffer, reallocated only when it is too small.

use crate::device::Device;

/// A reusable buffer.
#[derive(Debug)]
pub(crate) struct Slot {
    label: &'static str,
    usage: wgpu::BufferUsages,
    buffer: Option<wgpu::Buffer>,
}

impl Slot {
    pub(crate) fn new(label: &'static str, usage: wgpu::BufferUsages) -> Self {
        Self { label, usage, buffer: None }
    }

    /// Returns the buffer with at least that many bytes.
    pub(crate) fn fit(&mut self, device: &Device, bytes: u64) -> &wgpu::Buffer {
        if self.buffer.as_ref().is_none_or(|buffer| buffer.size() < bytes) {
            let roomy = bytes.next_power_of_two().min(device.buffer_bytes.max(bytes));
            self.buffer = Some(device.buffer(self.label, roomy, self.usage));
        }
        self.get()
    }

    /// Returns the buffer as it was last fitted.
    pub(crate) fn get(&self) -> &wgpu::Buffer {
        self.buffer.as_ref().expect("a pass is prepared before it runs")
    }
}
