//! Levels: the SIMD instruction sets that kernels are compiled for. Each kernel is compiled once
//! per level, and the level is chosen at run time. The code is the same and rounds the same way in
//! all of them, so the bits are the same; only the width of the vectors differs.

#![allow(unsafe_code, reason = "calling a function of an instruction set that was detected")]

use crate::block::{Loop, Machine};
use crate::elementary::Branchless;

/// A computation that is compiled once for each instruction set; see [`Level::run`].
pub trait SimdKernel {
    /// Result of the computation.
    type Output;
    /// Runs the computation. Implementations must be `#[inline(always)]`, so that they are compiled
    /// with the instructions of the level.
    fn run(self) -> Self::Output;
}

/// A SIMD instruction set that this machine supports.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Level(LevelKind);

/// Instruction set of a [`Level`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LevelKind {
    /// Instruction set of every machine of the architecture: SSE2 on x86-64, NEON on AArch64.
    Baseline,
    /// AVX2.
    #[cfg(target_arch = "x86_64")]
    Avx2,
    /// AVX-512 F, DQ, VL and BW.
    #[cfg(target_arch = "x86_64")]
    Avx512,
}

impl Level {
    /// Returns the levels that this machine supports, the widest last.
    #[must_use]
    pub fn available() -> Vec<Self> {
        let mut levels = vec![Self(LevelKind::Baseline)];
        #[cfg(target_arch = "x86_64")]
        {
            if is_x86_feature_detected!("avx2") {
                levels.push(Self(LevelKind::Avx2));
            }
            let wide = is_x86_feature_detected!("avx512f") && is_x86_feature_detected!("avx512dq");
            if wide && is_x86_feature_detected!("avx512vl") && is_x86_feature_detected!("avx512bw")
            {
                levels.push(Self(LevelKind::Avx512));
            }
        }
        levels
    }

    /// Returns the widest level that this machine supports.
    #[must_use]
    pub fn best() -> Self {
        Self::available().pop().unwrap_or(Self(LevelKind::Baseline))
    }

    /// Returns the name used in reports.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self.0 {
            LevelKind::Baseline if cfg!(target_arch = "aarch64") => "neon",
            LevelKind::Baseline if cfg!(target_arch = "x86_64") => "sse2",
            LevelKind::Baseline => "baseline",
            #[cfg(target_arch = "x86_64")]
            LevelKind::Avx2 => "avx2",
            #[cfg(target_arch = "x86_64")]
            LevelKind::Avx512 => "avx-512",
        }
    }

    /// Returns the instruction set.
    #[must_use]
    pub fn kind(self) -> LevelKind {
        self.0
    }

    /// Runs a kernel with the instructions of this level.
    pub fn run<W: SimdKernel>(self, kernel: W) -> W::Output {
        match self.0 {
            LevelKind::Baseline => kernel.run(),
            // SAFETY: only `available` makes levels, and only after it detected the features.
            #[cfg(target_arch = "x86_64")]
            LevelKind::Avx2 => unsafe { avx2(kernel) },
            // SAFETY: as above.
            #[cfg(target_arch = "x86_64")]
            LevelKind::Avx512 => unsafe { avx512(kernel) },
        }
    }
}

/// Runs the loops of models with elementary functions that every level vectorises.
impl Machine for Level {
    #[inline]
    fn run<L: Loop>(self, work: L) -> L::Values {
        Self::run(self, Looped(work))
    }
}

/// Kernel that runs a [`Loop`] of a reflectance model.
struct Looped<L>(L);

impl<L: Loop> SimdKernel for Looped<L> {
    type Output = L::Values;

    #[inline(always)]
    fn run(self) -> L::Values {
        self.0.run::<Branchless>()
    }
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2")]
fn avx2<W: SimdKernel>(kernel: W) -> W::Output {
    kernel.run()
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx512f,avx512dq,avx512vl,avx512bw")]
fn avx512<W: SimdKernel>(kernel: W) -> W::Output {
    kernel.run()
}
