//! Kernels: the loop of one instruction over a block of samples.
//!
//! There is a kernel for each operation, and one for each fused pair of sums, differences and
//! products, whose intermediate value stays in vector registers. All exist with and without each
//! clamp, because most clamps provably never act. Each operation is still rounded separately: a
//! fused pair is one pass over the block, not a fused multiply-add.

#![allow(
    unsafe_code,
    reason = "instructions address rows of one table by index, one of them mutably"
)]

use brood_brdf::{Level, LevelKind};
use brood_genome::{Arithmetic, Functions};
use brood_program::Operation;

use crate::lanes::{LANES, Quarter};

/// Pointer to the row of an operand in a block.
#[derive(Debug, Clone, Copy)]
pub(crate) struct View {
    first: *const Quarter,
    /// Distance from one quarter to the next: 1, or 0 if one quarter stands for all.
    step: usize,
}

impl View {
    /// Returns a view of a row.
    pub(super) fn row(quarters: &[Quarter]) -> Self {
        Self { first: quarters.as_ptr(), step: 1 }
    }

    /// Returns a view of a row that is also written to, at other times.
    pub(super) fn at(first: *const Quarter) -> Self {
        Self { first, step: 1 }
    }

    /// Returns a view of one quarter that stands for all.
    pub(super) fn constant(quarter: &Quarter) -> Self {
        Self { first: quarter, step: 0 }
    }

    /// Returns one quarter of the row.
    ///
    /// # Safety
    /// The row has such a quarter, it is alive, and nothing writes to it during `'a`.
    #[inline(always)]
    pub(crate) unsafe fn quarter<'a>(self, index: usize) -> &'a [f32; LANES] {
        // SAFETY: promised by the caller.
        unsafe { &(*self.first.add(self.step.wrapping_mul(index))).0 }
    }
}

/// Number of a kernel in the table of loops.
///
/// 0 to 47: a fused pair, 16 * first + 4 * second + clamps, see [`fused`]; 48 to 53: sum,
/// difference and product, each without and then with clamp; 54 to 79: the functions, each with and
/// then without clamps.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Kernel(u8);

/// Clamps of an instruction that is not fused.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Clamping {
    /// A clamp can act.
    Needed,
    /// No clamp can act.
    Idle,
}

/// Second operation of a fused pair: t is the result of the first, c the other operand.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Second {
    Add,
    /// t - c.
    Sub,
    /// c - t.
    SubFrom,
    Mul,
}

impl Kernel {
    /// Returns the kernel of one operation.
    pub(super) fn single(operation: Operation, clamping: Clamping) -> Self {
        let idle = u8::from(clamping == Clamping::Idle);
        match operation.binary() {
            Some(binary) => Self(48 + 2 * binary as u8 + (1 - idle)),
            None => Self(54 + 2 * (operation.number() - Operation::Sin.number()) + idle),
        }
    }

    /// Returns the kernel of a pair of operations; `clamps` is true for each whose clamp can act.
    /// `None` if the first is a function.
    pub(super) fn fused(operation: Operation, second: Second, clamps: [bool; 2]) -> Option<Self> {
        let clamps = u8::from(clamps[0]) + 2 * u8::from(clamps[1]);
        Some(Self(16 * operation.binary()? as u8 + 4 * second as u8 + clamps))
    }
}

/// Loop of a kernel over a block, compiled for one instruction set. The first argument is the row
/// to write, the second the operands.
///
/// # Safety
/// The operands are rows of at least as many quarters as the destination, or constants; the
/// destination overlaps none of them; the machine has the instructions that the loop was compiled
/// for.
pub(super) type Pass = unsafe fn(&mut [Quarter], &[View; 3]);

/// Declares the table of loops of one instruction set. Each loop is a separate function: its `&mut`
/// argument lets the compiler assume that nothing overlaps the destination, and the loops stay
/// small.
macro_rules! passes {
    ($name:ident, $f:ident $(, $feature:literal)?) => {
        $(#[target_feature(enable = $feature)])?
        #[inline(never)]
        unsafe fn $f<const KERNEL: u8>(out: &mut [Quarter], operands: &[View; 3]) {
            // SAFETY: promised by the caller.
            unsafe { pass::<KERNEL>(out, operands) }
        }
        passes!(table $name, $f;
            0 1 2 3 4 5 6 7 8 9 10 11 12 13 14 15 16 17 18 19 20 21 22 23 24 25 26 27 28 29 30 31 32 33 34 35
            36 37 38 39 40 41 42 43 44 45 46 47 48 49 50 51 52 53 54 55 56 57 58 59 60 61 62 63 64 65 66 67
            68 69 70 71 72 73 74 75 76 77 78 79);
    };
    (table $name:ident, $f:ident; $($n:literal)*) => {
        static $name: [Pass; 80] = [$($f::<$n>),*];
    };
}

passes!(BASELINE, baseline);
#[cfg(target_arch = "x86_64")]
passes!(AVX2, avx2, "avx2");
#[cfg(target_arch = "x86_64")]
passes!(AVX512, avx512, "avx512f,avx512dq,avx512vl,avx512bw");

impl Kernel {
    /// Returns the loop for an instruction set.
    pub(super) fn pass(self, level: Level) -> Pass {
        let passes = match level.kind() {
            LevelKind::Baseline => &BASELINE,
            #[cfg(target_arch = "x86_64")]
            LevelKind::Avx2 => &AVX2,
            #[cfg(target_arch = "x86_64")]
            LevelKind::Avx512 => &AVX512,
        };
        passes[usize::from(self.0)]
    }
}

/// # Safety
/// As [`Pass`].
#[inline(always)]
unsafe fn pass<const KERNEL: u8>(out: &mut [Quarter], operands: &[View; 3]) {
    let f = match KERNEL {
        0..54 => Functions::KNOWN,
        // The compiler broadcasts constants that it cannot see once, before the loop; known ones in
        // each iteration.
        _ => std::hint::black_box(Functions::KNOWN),
    };
    // SAFETY: promised by the caller.
    unsafe {
        match KERNEL {
            0..48 => each_triple(out, operands, fused::<KERNEL>),
            48 => each_pair(out, operands, |a, b| a + b),
            49 => each_pair(out, operands, |a, b| a.add(b)),
            50 => each_pair(out, operands, |a, b| a - b),
            51 => each_pair(out, operands, |a, b| a.add(-b)),
            52 => each_pair(out, operands, |a, b| a * b),
            53 => each_pair(out, operands, |a, b| a.mul(b)),
            54 => each(out, operands, |a| f.sin::<true>(a)),
            55 => each(out, operands, |a| f.sin::<false>(a)),
            56 => each(out, operands, |a| f.cos::<true>(a)),
            57 => each(out, operands, |a| f.cos::<false>(a)),
            58 => each(out, operands, |a| f.ex2::<true>(a)),
            59 => each(out, operands, |a| f.ex2::<false>(a)),
            60 => each(out, operands, |a| f.ex2::<true>(-a)),
            61 => each(out, operands, |a| f.ex2::<false>(-a)),
            62 | 63 => each(out, operands, |a| f.lg2(a)),
            64 | 65 => each(out, operands, |a| f.rcp(a)),
            66 | 67 => each(out, operands, |a| f.rsq(a)),
            68 | 69 => each(out, operands, |a| f.spl(a)),
            70 | 71 => each(out, operands, |a| f.spl(-a)),
            72 | 73 => each(out, operands, |a| a.saturate()),
            74 | 75 => each(out, operands, |a| (-a).saturate()),
            76 | 77 => each(out, operands, |a| a.step()),
            _ => each(out, operands, |a| (-a).step()),
        }
    }
}

/// Computes a pair of operations on one lane: bit 0 clamps the first, bit 1 the second, bits 2 and
/// 3 are the [`Second`], the rest is the first.
#[inline(always)]
fn fused<const CODE: u8>(a: f32, b: f32, c: f32) -> f32 {
    let clamps = (CODE & 1 != 0, CODE & 2 != 0);
    let t = match (CODE >> 4, clamps.0) {
        (0, false) => a + b,
        (0, true) => a.add(b),
        (1, false) => a - b,
        (1, true) => a.add(-b),
        (_, false) => a * b,
        (_, true) => a.mul(b),
    };
    match (CODE >> 2 & 3, clamps.1) {
        (0, false) => t + c,
        (0, true) => t.add(c),
        (1, false) => t - c,
        (1, true) => t.add(-c),
        (2, false) => c - t,
        (2, true) => c.add(-t),
        (_, false) => t * c,
        (_, true) => t.mul(c),
    }
}

// The number of quarters is not a compile-time constant: unrolled, the loops would not fit the
// instruction cache.

/// # Safety
/// As [`Pass`].
#[inline(always)]
unsafe fn each(out: &mut [Quarter], operands: &[View; 3], f: impl Fn(f32) -> f32) {
    for (index, out) in out.iter_mut().enumerate() {
        // SAFETY: promised by the caller.
        let a = unsafe { operands[0].quarter(index) };
        for (out, a) in out.0.iter_mut().zip(a) {
            *out = f(*a);
        }
    }
}

/// # Safety
/// As [`Pass`].
#[inline(always)]
unsafe fn each_pair(out: &mut [Quarter], operands: &[View; 3], f: impl Fn(f32, f32) -> f32) {
    let [a, b, _] = *operands;
    for (index, out) in out.iter_mut().enumerate() {
        // SAFETY: promised by the caller.
        let (a, b) = unsafe { (a.quarter(index), b.quarter(index)) };
        for ((out, a), b) in out.0.iter_mut().zip(a).zip(b) {
            *out = f(*a, *b);
        }
    }
}

/// # Safety
/// As [`Pass`].
#[inline(always)]
unsafe fn each_triple(out: &mut [Quarter], operands: &[View; 3], f: impl Fn(f32, f32, f32) -> f32) {
    let [a, b, c] = *operands;
    for (index, out) in out.iter_mut().enumerate() {
        // SAFETY: promised by the caller.
        let (a, b, c) = unsafe { (a.quarter(index), b.quarter(index), c.quarter(index)) };
        for (((out, a), b), c) in out.0.iter_mut().zip(a).zip(b).zip(c) {
            *out = f(*a, *b, *c);
        }
    }
}
