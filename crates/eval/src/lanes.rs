//! Sizes of the blocks of samples that loops run over, and the lanes of one iteration.

use bytemuck::{Pod, Zeroable};

/// Number of lanes per iteration of a loop.
pub(crate) const LANES: usize = 64;
/// Number of quarters in a block.
pub(crate) const QUARTERS: usize = 4;
/// Number of samples in a block: long enough that decoding costs little, short enough that
/// registers stay in the L1 cache.
pub(crate) const BLOCK: usize = LANES * QUARTERS;

/// The lanes of one iteration, aligned to a cache line: vectors that straddle two lines cost twice.
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
#[repr(C, align(64))]
pub(crate) struct Quarter(pub(crate) [f32; LANES]);
