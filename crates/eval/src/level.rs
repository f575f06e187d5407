//! Levels: the SIMD instruction sets that kernels are compiled for. Each kernel is compiled once
//! per level, and the level is chosen at run time. The code is the same and rounds the same way in
//! all of them, so the bits are the same; only the width of the vectors differs.

#![allow(unsafe_code, reason = "calling a function of an instruction set that was detected")]

use brood_brdf::{Branchless, Loop, Machine};

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
pub struct Level(Kind);

/// Instruction set of a [`Level`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Kind {
    /// Instruction set of every machine of the architecture: SSE2 on x86-64, NEON on AArch64.
    Baseline,
    #[cfg(target_arch = "x86_64")]
    Avx2,
    #[cfg(target_arch = "x86_64")]
    Avx512,
}

impl Level {
    /// Returns the levels that this machine supports, the widest last.
    #[must_use]
    pub fn available() -> Vec<Self> {
        let mut levels = vec![Self(Kind::Baseline)];
        #[cfg(target_arch = "x86_64")]
        {
            if is_x86_feature_detected!("avx2") {
                levels.push(Self(Kind::Avx2));
            }
            let wide = is_x86_feature_detected!("avx512f") && is_x86_feature_detected!("avx512dq");
            if wide && is_x86_feature_detected!("avx512vl") && is_x86_feature_detected!("avx512bw")
            {
                levels.push(Self(Kind::Avx512));
            }
        }
        levels
    }

    /// Returns the widest level that this machine supports.
    #[must_use]
    pub fn best() -> Self {
        Self::available().pop().unwrap_or(Self(Kind::Baseline))
    }

    /// Returns the name used in reports.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self.0 {
            Kind::Baseline if cfg!(target_arch = "aarch64") => "neon",
            Kind::Baseline if cfg!(target_arch = "x86_64") => "sse2",
            Kind::Baseline => "baseline",
            #[cfg(target_arch = "x86_64")]
            Kind::Avx2 => "avx2",
            #[cfg(target_arch = "x86_64")]
            Kind::Avx512 => "avx-512",
        }
    }

    pub(crate) fn kind(self) -> Kind {
        self.0
    }

    /// Runs a kernel with the instructions of this level.
    pub fn run<W: SimdKernel>(self, kernel: W) -> W::Output {
        match self.0 {
            Kind::Baseline => kernel.run(),
            // SAFETY: only `available` makes levels, and only after it detected the features.
            #[cfg(target_arch = "x86_64")]
            Kind::Avx2 => unsafe { avx2(kernel) },
            // SAFETY: as above.
            #[cfg(target_arch = "x86_64")]
            Kind::Avx512 => unsafe { avx512(kernel) },
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
