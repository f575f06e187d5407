//! Angles of the first quadrant from their sine or cosine, branch-free.
//!
//! The rational approximation is that of fdlibm (Sun Microsystems 1993, `e_asin.c`): asin x = x + x
//! R(x^2) up to 1/2; beyond that, pi/2 minus twice the angle with sine sqrt((1 - x) / 2).

use std::f64::consts::FRAC_PI_2;

use super::polynomial::polynomial;

/// Coefficients of R.
const NUMERATOR: [f64; 6] = [
    1.666_666_666_666_666_6e-1,
    -3.255_658_186_224_009e-1,
    2.012_125_321_348_629_3e-1,
    -4.005_553_450_067_941e-2,
    7.915_349_942_898_145e-4,
    3.479_331_075_960_212e-5,
];
const DENOMINATOR: [f64; 5] = [
    1.0,
    -2.403_394_911_734_414,
    2.020_945_760_233_505_7,
    -6.882_839_716_054_533e-1,
    7.703_815_055_590_194e-2,
];

/// Returns an angle of at most pi/6, and true if `x` is above 1/2. The angle has sine `x`, or sine
/// sqrt((1 - x) / 2) where `x` is above 1/2.
#[inline(always)]
fn small_angle(x: f64) -> (f64, bool) {
    let is_far = x > 0.5;
    let half = 0.5 * (1.0 - x);
    let z = if is_far { half } else { x * x };
    let s = if is_far { half.sqrt() } else { x };
    let ratio = z * polynomial(z, NUMERATOR) / polynomial(z, DENOMINATOR);
    (s + s * ratio, is_far)
}

/// Angle with cosine `x`.
#[inline(always)]
pub(super) fn acos(x: f64) -> f64 {
    let (small, is_far) = small_angle(x);
    if is_far { 2.0 * small } else { FRAC_PI_2 - small }
}

/// Angle with this sine and cosine. Reads only the smaller of the two: the inverse of the larger
/// loses digits where it is close to 1.
#[inline(always)]
pub(super) fn angle(sin: f64, cos: f64) -> f64 {
    let is_low = sin < cos;
    let (small, is_far) = small_angle(if is_low { sin } else { cos });
    let of_sine = if is_far { FRAC_PI_2 - 2.0 * small } else { small };
    if is_low { of_sine } else { FRAC_PI_2 - of_sine }
}
