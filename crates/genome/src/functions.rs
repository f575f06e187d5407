//! Canonical f32 functions, computed by polynomials, bit operations and Newton steps; never by a
//! library's or a device's own functions.
//!
//! Every product and sum is rounded separately, in the order written, so any backend that neither
//! contracts nor reassociates computes the same bits. `functions.wgsl` of the GPU crate and that of
//! the export crate are the twins of this file; their constants are generated from
//! [`Functions::constants`] and [`Functions::BIT_CONSTANTS`]. All code is branch-free, so that
//! loops over it vectorise.

use crate::range::{ANGLE_RANGE, EPSILON, EX2_RANGE, RANGE};

/// Constants of the functions, as values that a caller may hide from the compiler.
///
/// The compiler rebuilds known constants in every iteration of a vector loop, with one broadcast
/// for each use. Constants that it does not know are broadcast once before the loop and read from
/// memory as operands. Known constants make such loops 1.5 times as long in instructions. The
/// scalar operations of `f32` use [`Functions::KNOWN`].
///
/// Functions with a parameter `CLAMPS` clamp their argument if it is true; callers that have proved
/// the range of the argument pass false.
#[derive(Debug, Clone, Copy)]
pub struct Functions {
    angle_range: f32,
    ex2_range: (f32, f32),
    range: f32,
    epsilon: f32,
    rounding: f32,
    two_over_pi: f32,
    half_pi: [f32; 3],
    sin: [f32; 3],
    cos: [f32; 3],
    ex2: [f32; 6],
    lg2: [f32; 10],
    half: f32,
    one: f32,
    three_halves: f32,
    two: f32,
}

/// Bits of sqrt(1/2): mantissas are reduced to [sqrt(1/2), sqrt(2)).
const SQRT_HALF_BITS: u32 = 0x3f35_04f3;
/// Minuend of the initial guess of 1 / sqrt(t), from which half of the bits of t are subtracted.
const RSQ_SEED: u32 = 0x5f37_5a86;
/// Minuend of the initial guess of 1 / t, from which the bits of t are subtracted.
const RCP_SEED: u32 = 0x7ef3_11c7;

/// Clamps to the machine's range. Arguments are never NaN.
#[inline(always)]
pub fn clamp(x: f32) -> f32 {
    clamp_to(x, -RANGE, RANGE)
}

/// Clamps by comparisons, which are one instruction each; `f32::max` also checks for NaN.
#[inline(always)]
fn clamp_to(x: f32, low: f32, high: f32) -> f32 {
    let x = if x > low { x } else { low };
    if x < high { x } else { high }
}

/// Returns the bits of `even` or of `odd` by the parity of `k`, with masks. As a branch, the
/// polynomials would move into it and nothing would vectorise.
#[inline(always)]
fn select(k: u32, even: f32, odd: f32) -> u32 {
    let mask = (k & 1).wrapping_neg();
    (even.to_bits() & !mask) | (odd.to_bits() & mask)
}

#[expect(clippy::approx_constant, reason = "fitted: not the constants, though close to them")]
impl Functions {
    /// Values of the constants.
    pub const KNOWN: Self = Self {
        angle_range: ANGLE_RANGE,
        ex2_range: EX2_RANGE,
        range: RANGE,
        epsilon: EPSILON,
        // 1.5 * 2^23: adding and subtracting it rounds to the nearest integer, ties to even, for
        // |x| < 2^22.
        rounding: 12_582_912.0,
        two_over_pi: std::f32::consts::FRAC_2_PI,
        // pi/2 in parts of 13, 13 and 24 bits: the product of the first two with |k| < 2^11 is
        // exact.
        half_pi: [
            f32::from_bits(0x3fc9_0800),
            f32::from_bits(0x397b_5000),
            f32::from_bits(0x3288_85a3),
        ],
        sin: [-0.166_666_55, 0.008_332_179, -0.000_195_172_7],
        cos: [0.041_666_646, -0.001_388_737_5, 2.443_912e-5],
        ex2: [
            0.693_147_2,
            0.240_226_5,
            0.055_503_28,
            0.009_618_006,
            0.001_340_024_9,
            0.000_154_758_75,
        ],
        lg2: [
            1.442_695,
            -0.721_347_33,
            0.480_897_9,
            -0.360_696_43,
            0.288_585_28,
            -0.239_636_57,
            0.204_296_17,
            -0.190_612_9,
            0.187_825_9,
            -0.112_973_355,
        ],
        half: 0.5,
        one: 1.0,
        three_halves: 1.5,
        two: 2.0,
    };

    /// Largest magnitude of arguments of sine and cosine.
    pub const ANGLE_RANGE: f32 = ANGLE_RANGE;
    /// Range of arguments of the power of two.
    pub const EX2_RANGE: (f32, f32) = EX2_RANGE;
    /// 2^-24, added so that logarithm and reciprocals are finite everywhere.
    pub const EPSILON: f32 = EPSILON;

    /// Names and values of the constants that are bit patterns, for twins in shading languages.
    pub const BIT_CONSTANTS: [(&'static str, u32); 3] =
        [("SQRT_HALF_BITS", SQRT_HALF_BITS), ("RSQ_SEED", RSQ_SEED), ("RCP_SEED", RCP_SEED)];

    /// Returns names and values of the constants that are numbers, for twins in shading languages.
    #[must_use]
    pub fn constants() -> Vec<(String, f32)> {
        let known = Self::KNOWN;
        let numbers = [
            ("RANGE", known.range),
            ("ANGLE_RANGE", known.angle_range),
            ("EX2_LOW", known.ex2_range.0),
            ("EX2_HIGH", known.ex2_range.1),
            ("EPSILON", known.epsilon),
            ("ROUNDING", known.rounding),
            ("TWO_OVER_PI", known.two_over_pi),
        ];
        let rows: [(&str, &[f32]); 5] = [
            ("HALF_PI", &known.half_pi),
            ("SIN", &known.sin),
            ("COS", &known.cos),
            ("EX2", &known.ex2),
            ("LG2", &known.lg2),
        ];
        let numbers = numbers.map(|(name, value)| (name.to_owned(), value)).into_iter();
        let in_rows = rows.into_iter().flat_map(|(name, row)| {
            row.iter().enumerate().map(move |(index, value)| (format!("{name}_{index}"), *value))
        });
        numbers.chain(in_rows).collect()
    }

    /// Returns x rounded to an integer, and bits whose lowest nine are those of that integer.
    #[inline(always)]
    fn round(&self, x: f32) -> (f32, u32) {
        // The rounding constant leaves the integer in the low bits of the mantissa; the lowest nine
        // bits of the constant are 0.
        let shifted = x + self.rounding;
        (shifted - self.rounding, shifted.to_bits())
    }

    /// Returns the sine and cosine polynomials of the reduced argument, and bits whose lowest two
    /// are the quadrant.
    #[inline(always)]
    fn reduce<const CLAMPS: bool>(&self, x: f32) -> (f32, f32, u32) {
        let x = if CLAMPS { clamp_to(x, -self.angle_range, self.angle_range) } else { x };
        let (k, bits) = self.round(x * self.two_over_pi);
        let half_pi = &self.half_pi;
        let r = ((x - k * half_pi[0]) - k * half_pi[1]) - k * half_pi[2];
        let z = r * r;
        let s = r + (r * z) * (self.sin[0] + z * (self.sin[1] + z * self.sin[2]));
        let c = (self.one - self.half * z)
            + (z * z) * (self.cos[0] + z * (self.cos[1] + z * self.cos[2]));
        (s, c, bits)
    }

    /// sin(x); without `CLAMPS` only for |x| <= 1024.
    ///
    /// # Error
    /// At most 2 ulp where the result is at least 2^-10 in magnitude, else 1.2e-7 absolute, against
    /// `libm` in f64 (`sine_and_cosine_are_within_bounds`).
    #[inline(always)]
    pub fn sin<const CLAMPS: bool>(&self, x: f32) -> f32 {
        let (s, c, k) = self.reduce::<CLAMPS>(x);
        f32::from_bits(select(k, s, c) ^ ((k & 2) << 30))
    }

    /// cos(x). Domain and error as for [`Functions::sin`].
    #[inline(always)]
    pub fn cos<const CLAMPS: bool>(&self, x: f32) -> f32 {
        let (s, c, k) = self.reduce::<CLAMPS>(x);
        f32::from_bits(select(k, c, s) ^ ((k.wrapping_add(1) & 2) << 30))
    }

    /// 2^x, with the argument clamped to [-24, 16] and the result to the range; without `CLAMPS`
    /// only for -24 <= x < 15.9.
    ///
    /// # Error
    /// At most 2 ulp against `libm` in f64 (`power_of_two_is_within_two_ulp`); exact for integers.
    #[inline(always)]
    pub fn ex2<const CLAMPS: bool>(&self, x: f32) -> f32 {
        let x = if CLAMPS { clamp_to(x, self.ex2_range.0, self.ex2_range.1) } else { x };
        let (k, bits) = self.round(x);
        let f = x - k;
        let [c0, c1, c2, c3, c4, c5] = self.ex2;
        let p = c3 + f * (c4 + f * c5);
        let p = self.one + f * (c0 + f * (c1 + f * (c2 + f * p)));
        let result = p * f32::from_bits((bits << 23).wrapping_add(127 << 23));
        // 2^16 is beyond the range of the machine and must be clamped.
        if CLAMPS { clamp_to(result, -self.range, self.range) } else { result }
    }

    /// log2 of a positive normal number.
    ///
    /// # Error
    /// At most 2e-7 relative to max(1, |log2 t|) (`logarithm_is_within_bounds`).
    #[inline(always)]
    pub fn log2(&self, t: f32) -> f32 {
        // t = 2^exponent (1 + f) with 1 + f in [sqrt(1/2), sqrt(2)).
        let offset = t.to_bits().wrapping_sub(SQRT_HALF_BITS) & 0xff80_0000;
        let exponent = ((offset as i32) >> 23) as f32;
        let f = f32::from_bits(t.to_bits().wrapping_sub(offset)) - self.one;
        let c = &self.lg2;
        let p = c[7] + f * (c[8] + f * c[9]);
        let p = c[3] + f * (c[4] + f * (c[5] + f * (c[6] + f * p)));
        let p = f * (c[0] + f * (c[1] + f * (c[2] + f * p)));
        exponent + p
    }

    /// log2(x^2 + 2^-24).
    ///
    /// # Error
    /// At most 2.5e-6 absolute (`smooth_functions_are_within_bounds`).
    #[inline(always)]
    pub fn lg2(&self, x: f32) -> f32 {
        self.log2(x * x + self.epsilon)
    }

    /// 1 / sqrt(t) of a positive normal number, from an initial guess by its bits and four Newton
    /// steps.
    #[inline(always)]
    fn inverse_sqrt(&self, t: f32) -> f32 {
        let half = self.half * t;
        let mut y = f32::from_bits(RSQ_SEED.wrapping_sub(t.to_bits() >> 1));
        for _ in 0..4 {
            y *= self.three_halves - (half * y) * y;
        }
        y
    }

    /// 1 / sqrt(x^2 + 2^-24).
    ///
    /// # Error
    /// At most 4 ulp (`smooth_functions_are_within_bounds`).
    #[inline(always)]
    pub fn rsq(&self, x: f32) -> f32 {
        self.inverse_sqrt(x * x + self.epsilon)
    }

    /// x / (x^2 + 2^-24), clamped.
    ///
    /// # Error
    /// At most 4 ulp (`smooth_functions_are_within_bounds`).
    #[inline(always)]
    pub fn rcp(&self, x: f32) -> f32 {
        let t = x * x + self.epsilon;
        let mut y = f32::from_bits(RCP_SEED.wrapping_sub(t.to_bits()));
        for _ in 0..4 {
            y *= self.two - t * y;
        }
        clamp_to(x * y, -self.range, self.range)
    }

    /// log2(1 + 2^x) as max(x, 0) + log2(1 + 2^-|x|).
    ///
    /// # Error
    /// At most 1e-6 plus one rounding of the result (`smooth_functions_are_within_bounds`).
    #[inline(always)]
    pub fn spl(&self, x: f32) -> f32 {
        // The mask is 0 where the sign bit of x is set, so it keeps max(x, 0).
        let mask = !((x.to_bits() as i32 >> 31) as u32);
        let softened = self.log2(self.one + self.ex2::<true>(-x.abs()));
        clamp_to(f32::from_bits(x.to_bits() & mask) + softened, -self.range, self.range)
    }
}

#[cfg(test)]
#[path = "functions_tests.rs"]
mod tests;
