//! One pass: a group of programs over a slab of samples (see plan.rs), and the uniform block of
//! each of its dispatches.

use std::ops::Range;

use crate::encode::Encoded;
use crate::plan::Grid;
use crate::shader::Kernel;

/// The uniform block of one dispatch: `Tile` of bindings.wgsl, which explains the fields.
#[derive(Debug, Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub(crate) struct TileUniform {
    pub zero: u32,
    pub first_program: u32,
    pub first_block: u32,
    pub end_block: u32,
    pub stride: u32,
    pub samples: u32,
    pub sums: u32,
    pub logarithmic: u32,
    pub first_sum: u32,
    pub padding: [u32; 3],
}

/// Programs, buffers and range of one pass. Its outputs are read back once, after its last
/// dispatch.
pub(crate) struct Pass<'a> {
    pub kernel: Kernel,
    pub programs: &'a [Encoded],
    /// Words that the shader reads: encoded programs or, for an own pipeline, the row of each
    /// input.
    pub words: &'a [u32],
    /// Rows of inputs.
    pub inputs: &'a wgpu::Buffer,
    /// Rows of values to reach and weights; only for fitness.
    pub targets: Option<&'a wgpu::Buffer>,
    /// Samples of the slab.
    pub grid: Grid,
    /// Blocks to evaluate; the range begins with a whole workgroup.
    pub blocks: Range<u32>,
    /// Number of samples of the slab.
    pub samples: u32,
    /// Number of sums per program; only for fitness.
    pub sums: u32,
    /// True if logarithms are compared; only for fitness.
    pub logarithmic: bool,
    /// Number of bytes of the outputs of all programs.
    pub output_bytes: u64,
}
