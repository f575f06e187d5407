//! One pass: a group of programs over a slab of samples, and its uniform blocks.

use std::ops::Range;

use crate::encode::Encoded;
use crate::plan::Grid;
use crate::shader::Kernel;

/// The uniform block of one dispatch: `Tile` of bindings.wgsl.
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

/// Programs, buffers and range of one pass, which ends with one reading back.
pub(crate) struct Pass<'a> {
    pub kernel: Kernel,
    pub programs: &'a [Encoded],
    pub words: &'a [u32],
    pub inputs: &'a wgpu::Buffer,
    /// Only for fitness.
    pub targets: Option<&'a wgpu::Buffer>,
    pub grid: Grid,
    /// Blocks to evaluate, from the beginning of a workgroup on.
    pub blocks: Range<u32>,
    pub samples: u32,
    pub sums: u32,
    pub logarithmic: bool,
    pub output_bytes: u64,
}
