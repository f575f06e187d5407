//! Exponential, logarithm and power, branch-free.
//!
//! Range reductions and coefficients are those of fdlibm (Sun Microsystems 1993, `e_exp.c` and
//! `e_log.c`). Its branches are selections here, and integers are read from the bits of sums.

use std::f64::consts::LOG2_E;

use super::polynomial::polynomial;

/// 1.5 * 2^52: adding and subtracting it rounds to the nearest integer. The low bits of the sum are
/// that integer.
pub(super) const ROUNDING: f64 = 6_755_399_441_055_744.0;
/// ln 2 as the sum of two parts; products of the first with integers below 2^20 are exact.
const LN_2: [f64; 2] = [6.931_471_803_691_238e-1, 1.908_214_929_270_587_7e-10];
const EXPONENT_BIAS: f64 = 1023.0;
const MANTISSA_BITS: u32 = 52;
const MANTISSA: u64 = (1 << MANTISSA_BITS) - 1;
/// Bits of 2^52. An integer below 2^52 in the low bits is added to the value, because the unit in
/// the last place of floats in [2^52, 2^53) is 1.
const UNITS: u64 = 0x4330_0000_0000_0000;
/// Upper half of the bits of sqrt(1/2), the least mantissa after the range reduction of [`ln`].
const SQRT_HALF: u64 = 0x3fe6_a09e_0000_0000;
/// Bits of 1 minus [`SQRT_HALF`].
const ONE_ABOVE_SQRT_HALF: u64 = 0x3ff0_0000_0000_0000 - SQRT_HALF;

/// Coefficients of fdlibm's rational function of e^r.
const EXP: [f64; 5] = [
    1.666_666_666_666_660_2e-1,
    -2.777_777_777_701_559_3e-3,
    6.613_756_321_437_934e-5,
    -1.653_390_220_546_525_2e-6,
    4.138_136_797_057_238_5e-8,
];
/// Coefficients of fdlibm's polynomial of ln, split into odd and even powers of s^2.
const LN_EVEN: [f64; 4] = [
    6.666_666_666_666_735e-1,
    2.857_142_874_366_239e-1,
    1.818_357_216_161_805e-1,
    1.479_819_860_511_658_6e-1,
];
const LN_ODD: [f64; 3] =
    [3.999_999_999_940_942e-1, 2.222_219_843_214_978_4e-1, 1.531_383_769_920_937_3e-1];

#[inline(always)]
pub(super) fn exp(x: f64) -> f64 {
    // Results are 0 and infinity beyond these bounds. Comparisons keep NaN.
    let x = if x < -746.0 { -746.0 } else { x };
    let x = if x > 710.0 { 710.0 } else { x };
    // x = k ln 2 + r with an integer k and r in [-ln 2 / 2, ln 2 / 2]; `power` is e^r.
    let k = (x * LOG2_E + ROUNDING) - ROUNDING;
    let high = x - k * LN_2[0];
    let low = k * LN_2[1];
    let r = high - low;
    let r2 = r * r;
    let c = r - r2 * polynomial(r2, EXP);
    let power = 1.0 + ((r * c / (2.0 - c) - low) + high);
    // 2^k may exceed f64, so it is applied in two steps. The first is exact, so that subnormal
    // results are rounded only once.
    let half = (0.5 * k + ROUNDING) - ROUNDING;
    power * two_to_the(half) * two_to_the(k - half)
}

/// 2^k for an integer k in [-1022, 1023].
#[inline(always)]
fn two_to_the(k: f64) -> f64 {
    f64::from_bits((k + (ROUNDING + EXPONENT_BIAS)).to_bits() << MANTISSA_BITS)
}

#[inline(always)]
pub(super) fn ln(x: f64) -> f64 {
    // Scales subnormals by 2^54.
    let is_tiny = x < f64::MIN_POSITIVE;
    let scaled = if is_tiny { x * 18_014_398_509_481_984.0 } else { x };
    // scaled = 2^exponent (1 + f) with 1 + f in [sqrt(1/2), sqrt(2)).
    let bits = scaled.to_bits().wrapping_add(ONE_ABOVE_SQRT_HALF);
    let exponent = f64::from_bits((bits >> MANTISSA_BITS) | UNITS)
        - (f64::from_bits(UNITS) + EXPONENT_BIAS)
        - if is_tiny { 54.0 } else { 0.0 };
    let f = f64::from_bits((bits & MANTISSA).wrapping_add(SQRT_HALF)) - 1.0;
    let s = f / (2.0 + f);
    let z = s * s;
    let w = z * z;
    let r = z * polynomial(w, LN_EVEN) + w * polynomial(w, LN_ODD);
    let square = 0.5 * f * f;
    let value = s * (square + r) + exponent * LN_2[1] - square + f + exponent * LN_2[0];
    // The result for 0, infinity, NaN and negative numbers.
    let beyond = if x > 0.0 { f64::INFINITY } else { f64::NAN };
    let beyond = if x == 0.0 { f64::NEG_INFINITY } else { beyond };
    if (x > 0.0) & (x < f64::INFINITY) { value } else { beyond }
}

/// x^y for x >= 0; 1 if y is 0, where `exponent` may be NaN.
#[inline(always)]
pub(super) fn pow(x: f64, y: f64) -> f64 {
    let exponent = y * ln(x);
    exp(if y == 0.0 { 0.0 } else { exponent })
}
