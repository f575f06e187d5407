//! The canonical f32 functions: polynomials, bit operations and Newton steps, never a library's or a device's own.
//!
//! Every product and sum rounds separately, in the order written, so that any backend that neither contracts nor
//! reassociates gets the same bits. The GPU crate's `functions.wgsl` is the twin of this file. Everything is branchless,
//! so that loops over it vectorise.

use crate::arithmetic::{ANGLE_RANGE, EPSILON, EX2_RANGE, RANGE};

/// 1.5 * 2^23: adding and subtracting it rounds to the nearest integer, ties to even, for |x| < 2^22.
const ROUNDING: f32 = 12_582_912.0;
const TWO_OVER_PI: f32 = std::f32::consts::FRAC_2_PI;
/// pi/2 in parts of 13, 13, 13 and 24 bits: the product of the first three with |k| < 2^11 is exact.
const HALF_PI: [f32; 4] = [
    f32::from_bits(0x3fc9_0800),
    f32::from_bits(0x397b_5000),
    f32::from_bits(0x3288_8000),
    f32::from_bits(0x2c34_611a),
];
const SIN: [f32; 3] = [-0.166_666_55, 0.008_332_179, -0.000_195_172_7];
const COS: [f32; 3] = [0.041_666_646, -0.001_388_737_5, 2.443_912e-5];
#[expect(clippy::approx_constant, reason = "fitted: not the constant, though close to it")]
const EX2: [f32; 6] =
    [0.693_147_2, 0.240_226_5, 0.055_503_28, 0.009_618_006, 0.001_340_024_9, 0.000_154_758_75];
#[expect(clippy::approx_constant, reason = "fitted: not the constant, though close to it")]
const LG2: [f32; 10] = [
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
];
/// Bits of sqrt(1/2): mantissas are taken from there to sqrt(2).
const SQRT_HALF_BITS: u32 = 0x3f35_04f3;

/// Clamp to the machine's range. Arguments are never NaN.
#[inline(always)]
pub fn clamp(x: f32) -> f32 {
    clamp_to(x, -RANGE, RANGE)
}

/// Written as comparisons because they are one instruction each, where `f32::max` also looks for NaN.
#[inline(always)]
fn clamp_to(x: f32, low: f32, high: f32) -> f32 {
    let x = if x > low { x } else { low };
    if x < high { x } else { high }
}

#[inline(always)]
fn round(x: f32) -> f32 {
    (x + ROUNDING) - ROUNDING
}

/// Sine and cosine polynomials of the reduced argument, and the quadrant.
#[inline(always)]
fn reduce(x: f32) -> (f32, f32, i32) {
    let x = clamp_to(x, -ANGLE_RANGE, ANGLE_RANGE);
    let k = round(x * TWO_OVER_PI);
    let r = (((x - k * HALF_PI[0]) - k * HALF_PI[1]) - k * HALF_PI[2]) - k * HALF_PI[3];
    let z = r * r;
    let s = r + (r * z) * (SIN[0] + z * (SIN[1] + z * SIN[2]));
    let c = (1.0 - 0.5 * z) + (z * z) * (COS[0] + z * (COS[1] + z * COS[2]));
    (s, c, whole(k))
}

/// The integer that a rounded value of modest size is.
#[inline(always)]
fn whole(k: f32) -> i32 {
    // The rounding constant leaves the integer in the low bits of the mantissa, which vectorises at every level.
    (k + ROUNDING).to_bits().wrapping_sub(ROUNDING.to_bits()) as i32
}

/// The bits of `even` or of `odd`, by masks: written as a branch, the polynomials move into it and nothing vectorises.
#[inline(always)]
fn select(k: i32, even: f32, odd: f32) -> u32 {
    let mask = (k as u32 & 1).wrapping_neg();
    (even.to_bits() & !mask) | (odd.to_bits() & mask)
}

/// sin(x), the argument clamped to +-1024.
///
/// # Error
/// At most 2 ulp where the result is at least 2^-10 in magnitude, else 1.2e-7 absolute, against `libm` in f64
/// (`sine_and_cosine_are_within_bounds`).
#[inline(always)]
pub fn sin(x: f32) -> f32 {
    let (s, c, k) = reduce(x);
    f32::from_bits(select(k, s, c) ^ ((k as u32 & 2) << 30))
}

/// cos(x), the argument clamped to +-1024. Error as for [`sin`].
#[inline(always)]
pub fn cos(x: f32) -> f32 {
    let (s, c, k) = reduce(x);
    f32::from_bits(select(k, c, s) ^ ((k.wrapping_add(1) as u32 & 2) << 30))
}

/// 2^x, the argument clamped to [-24, 16], the result to the range.
///
/// # Error
/// At most 2 ulp against `libm` in f64 (`power_of_two_is_within_two_ulp`); exact at whole numbers.
#[inline(always)]
pub fn ex2(x: f32) -> f32 {
    let x = clamp_to(x, EX2_RANGE.0, EX2_RANGE.1);
    let k = round(x);
    let f = x - k;
    let p = EX2[3] + f * (EX2[4] + f * EX2[5]);
    let p = 1.0 + f * (EX2[0] + f * (EX2[1] + f * (EX2[2] + f * p)));
    let scale = f32::from_bits((whole(k).wrapping_add(127) as u32) << 23);
    // 2^16 is beyond the range of the machine, as every result it is clamped.
    clamp(p * scale)
}

/// log2 of a positive normal number.
#[inline(always)]
fn log2(t: f32) -> f32 {
    let offset = t.to_bits().wrapping_sub(SQRT_HALF_BITS) & 0xff80_0000;
    let exponent = ((offset as i32) >> 23) as f32;
    let f = f32::from_bits(t.to_bits().wrapping_sub(offset)) - 1.0;
    let p = LG2[7] + f * (LG2[8] + f * LG2[9]);
    let p = LG2[3] + f * (LG2[4] + f * (LG2[5] + f * (LG2[6] + f * p)));
    let p = f * (LG2[0] + f * (LG2[1] + f * (LG2[2] + f * p)));
    exponent + p
}

/// log2(x^2 + 2^-24).
///
/// # Error
/// At most 2.5e-6 absolute (`smooth_functions_are_within_bounds`).
#[inline(always)]
pub fn lg2(x: f32) -> f32 {
    log2(x * x + EPSILON)
}

/// 1 / sqrt(t) of a positive normal number, by a first guess from the bits and four Newton steps.
#[inline(always)]
fn inverse_sqrt(t: f32) -> f32 {
    let half = 0.5 * t;
    let mut y = f32::from_bits(0x5f37_5a86_u32.wrapping_sub(t.to_bits() >> 1));
    for _ in 0..4 {
        y *= 1.5 - (half * y) * y;
    }
    y
}

/// 1 / sqrt(x^2 + 2^-24).
///
/// # Error
/// At most 4 ulp (`smooth_functions_are_within_bounds`).
#[inline(always)]
pub fn rsq(x: f32) -> f32 {
    inverse_sqrt(x * x + EPSILON)
}

/// x / (x^2 + 2^-24), clamped.
///
/// # Error
/// At most 4 ulp (`smooth_functions_are_within_bounds`).
#[inline(always)]
pub fn rcp(x: f32) -> f32 {
    let t = x * x + EPSILON;
    let mut y = f32::from_bits(0x7ef3_11c7_u32.wrapping_sub(t.to_bits()));
    for _ in 0..4 {
        y *= 2.0 - t * y;
    }
    clamp(x * y)
}

/// log2(1 + 2^x) as max(x, 0) + log2(1 + 2^-|x|).
///
/// # Error
/// At most 1e-6 plus one rounding of the result (`smooth_functions_are_within_bounds`).
#[inline(always)]
pub fn spl(x: f32) -> f32 {
    // The sign bit as a mask keeps x where it is positive.
    let mask = !((x.to_bits() as i32 >> 31) as u32);
    clamp(f32::from_bits(x.to_bits() & mask) + log2(1.0 + ex2(-x.abs())))
}

#[cfg(test)]
#[path = "functions_tests.rs"]
mod tests;
