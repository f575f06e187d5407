//! Targets of sums of errors, and their rows on the device.

/// Targets of reflectances, all of the length of the set.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Targets<'a> {
    /// Identity of the set of the target, by which rows are cached on the device.
    pub set: u64,
    /// Values to reach of red, green and blue.
    pub values: [&'a [f32]; 3],
    /// Weights of reflectances.
    pub weights: [&'a [f32]; 3],
    /// True if log2(1 + weighted reflectance) is compared.
    pub logarithmic: bool,
}

/// Rows of the targets that were used last.
#[derive(Debug)]
pub(crate) struct ResidentTargets {
    pub set: u64,
    pub first_sample: usize,
    pub buffer: wgpu::Buffer,
}
