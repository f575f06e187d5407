//! Sizes of blocks. Loops over the samples of a set process it in blocks of 256 samples, each of 4
//! quarters of 64 lanes; a lane holds one sample.

use std::ops::AddAssign;

use bytemuck::{Pod, Zeroable};

/// Number of lanes in a quarter, which is processed by one iteration of the outer loops.
pub(crate) const LANES: usize = 64;
/// Number of quarters in a block.
pub(crate) const QUARTERS: usize = 4;
/// Number of samples in a block: long enough that decoding costs little, short enough that
/// registers stay in the L1 cache.
pub(crate) const BLOCK: usize = LANES * QUARTERS;

/// Values of one quarter, aligned to a cache line: vectors that straddle two lines cost twice.
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
#[repr(C, align(64))]
pub(crate) struct Quarter(pub(crate) [f32; LANES]);

/// Adds sum k + N / 2 to sum k, then k + N / 4, and so on; N is a power of two.
#[inline(always)]
pub(crate) fn pairwise_sum<T: Copy + AddAssign, const N: usize>(mut sums: [T; N]) -> T {
    let mut half = N / 2;
    while half > 0 {
        for at in 0..half {
            let other = sums[at + half];
            sums[at] += other;
        }
        half /= 2;
    }
    sums[0]
}
