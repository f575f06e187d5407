//! Arithmetic of the machine, in canonical f32 and in the f64 reference.
//!
//! Canonical f32 defines every bit that is stored or compared: each operation rounds once, in the
//! order written, and the result is clamped to the range of the half registers of the paper's
//! hardware. The f64 reference has the same operations and clamps; it serves only to measure
//! errors.

use crate::functions::{self, Functions};
use crate::range::{ANGLE_RANGE, EPSILON, EX2_RANGE, RANGE};

/// A function of one value.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Function {
    /// [`Arithmetic::sine`].
    Sin,
    /// [`Arithmetic::cosine`].
    Cos,
    /// [`Arithmetic::ex2`].
    Ex2,
    /// [`Arithmetic::lg2`].
    Lg2,
    /// [`Arithmetic::rcp`].
    Rcp,
    /// [`Arithmetic::rsq`].
    Rsq,
    /// [`Arithmetic::spl`].
    Spl,
    /// [`Arithmetic::saturate`].
    Saturate,
    /// [`Arithmetic::step`].
    Step,
}

/// Scalar operations that the opcodes consist of.
///
/// # Domain
/// Arguments are finite and within `[-RANGE, RANGE]`; so are results. No argument in that domain
/// gives NaN or infinity.
pub trait Arithmetic: Copy + Default + PartialEq + std::fmt::Debug {
    /// Converts an f32 exactly.
    fn from_f32(value: f32) -> Self;
    /// Clamped sum.
    #[must_use]
    fn add(self, other: Self) -> Self;
    /// Clamped product.
    #[must_use]
    fn mul(self, other: Self) -> Self;
    /// Negation.
    #[must_use]
    fn neg(self) -> Self;
    /// Sine, with the argument clamped to +-1024. Not named `sin`, so that the inherent method is
    /// not called by mistake.
    #[must_use]
    fn sine(self) -> Self;
    /// Cosine, with the argument clamped to +-1024.
    #[must_use]
    fn cosine(self) -> Self;
    /// 2^x, with the argument clamped to [-24, 16] and the result to the range.
    #[must_use]
    fn ex2(self) -> Self;
    /// log2(x^2 + 2^-24).
    #[must_use]
    fn lg2(self) -> Self;
    /// x / (x^2 + 2^-24), clamped.
    #[must_use]
    fn rcp(self) -> Self;
    /// 1 / sqrt(x^2 + 2^-24).
    #[must_use]
    fn rsq(self) -> Self;
    /// log2(1 + 2^x), from `ex2` of -|x|, clamped.
    #[must_use]
    fn spl(self) -> Self;
    /// x clamped to [0, 1]; used by painted materials.
    #[must_use]
    fn saturate(self) -> Self;
    /// 1 where x >= 0, else 0; used by painted materials.
    #[must_use]
    fn step(self) -> Self;
    /// Applies a function.
    #[inline(always)]
    #[must_use]
    fn function(self, function: Function) -> Self {
        match function {
            Function::Sin => self.sine(),
            Function::Cos => self.cosine(),
            Function::Ex2 => self.ex2(),
            Function::Lg2 => self.lg2(),
            Function::Rcp => self.rcp(),
            Function::Rsq => self.rsq(),
            Function::Spl => self.spl(),
            Function::Saturate => self.saturate(),
            Function::Step => self.step(),
        }
    }
    /// Square without clamp. The BRDF is the square of the result registers.
    #[must_use]
    fn square(self) -> Self;
    /// Product plus sum without clamp, for the output stage, whose factors are bounded and
    /// non-negative.
    #[must_use]
    fn output_mul_add(self, factor: Self, addend: Self) -> Self;
}

/// Methods that call the canonical function of the same name.
macro_rules! known {
    ($($name:ident)+) => {$(
        #[inline(always)]
        fn $name(self) -> Self {
            Functions::KNOWN.$name(self)
        }
    )+};
}

impl Arithmetic for f32 {
    #[inline(always)]
    fn from_f32(value: f32) -> Self {
        value
    }

    #[inline(always)]
    fn add(self, other: Self) -> Self {
        functions::clamp(self + other)
    }

    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        functions::clamp(self * other)
    }

    #[inline(always)]
    fn neg(self) -> Self {
        -self
    }

    #[inline(always)]
    fn sine(self) -> Self {
        Functions::KNOWN.sin::<true>(self)
    }

    #[inline(always)]
    fn cosine(self) -> Self {
        Functions::KNOWN.cos::<true>(self)
    }

    #[inline(always)]
    fn ex2(self) -> Self {
        Functions::KNOWN.ex2::<true>(self)
    }

    known!(lg2 rcp rsq spl);

    #[inline(always)]
    fn saturate(self) -> Self {
        // Comparisons as in `functions::clamp`, so that -0 becomes 0 on every machine.
        let x = if self > 0.0 { self } else { 0.0 };
        if x < 1.0 { x } else { 1.0 }
    }

    #[inline(always)]
    fn step(self) -> Self {
        if self >= 0.0 { 1.0 } else { 0.0 }
    }

    #[inline(always)]
    fn square(self) -> Self {
        self * self
    }

    #[inline(always)]
    fn output_mul_add(self, factor: Self, addend: Self) -> Self {
        self * factor + addend
    }
}

impl Arithmetic for f64 {
    fn from_f32(value: f32) -> Self {
        f64::from(value)
    }

    fn add(self, other: Self) -> Self {
        clamp(self + other)
    }

    fn mul(self, other: Self) -> Self {
        clamp(self * other)
    }

    fn neg(self) -> Self {
        -self
    }

    fn sine(self) -> Self {
        libm::sin(angle(self))
    }

    fn cosine(self) -> Self {
        libm::cos(angle(self))
    }

    fn ex2(self) -> Self {
        clamp(libm::exp2(self.clamp(f64::from(EX2_RANGE.0), f64::from(EX2_RANGE.1))))
    }

    fn lg2(self) -> Self {
        libm::log2(self * self + f64::from(EPSILON))
    }

    fn rcp(self) -> Self {
        clamp(self / (self * self + f64::from(EPSILON)))
    }

    fn rsq(self) -> Self {
        1.0 / (self * self + f64::from(EPSILON)).sqrt()
    }

    fn spl(self) -> Self {
        clamp(self.max(0.0) + libm::log2(1.0 + (-self.abs()).ex2()))
    }

    fn saturate(self) -> Self {
        if self > 0.0 { self.min(1.0) } else { 0.0 }
    }

    fn step(self) -> Self {
        if self >= 0.0 { 1.0 } else { 0.0 }
    }

    fn square(self) -> Self {
        self * self
    }

    fn output_mul_add(self, factor: Self, addend: Self) -> Self {
        self * factor + addend
    }
}

fn clamp(x: f64) -> f64 {
    x.clamp(-f64::from(RANGE), f64::from(RANGE))
}

fn angle(x: f64) -> f64 {
    x.clamp(-f64::from(ANGLE_RANGE), f64::from(ANGLE_RANGE))
}
