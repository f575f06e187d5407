//! Branchless functions against `libm`: over all exponents, near special values, and in the ranges
//! that models use.

use super::{Branchless, Elementary, Libm};

/// Distance of `got` from `wanted` in units in the last place of `wanted`.
fn ulps(got: f64, wanted: f64) -> f64 {
    if got.to_bits() == wanted.to_bits() || (got.is_nan() && wanted.is_nan()) {
        return 0.0;
    }
    let bits = |x: f64| x.to_bits().cast_signed();
    (bits(got) - bits(wanted)).unsigned_abs() as f64
}

/// Positive floats of every exponent, `per_exponent` of each, with pseudo-random mantissas.
fn positive(per_exponent: u64) -> impl Iterator<Item = f64> {
    let count = 2046 * per_exponent;
    (0..count).map(move |k| {
        let mantissa = k.wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 12;
        f64::from_bits(((k / per_exponent) << 52) | mantissa)
    })
}

/// `count` + 1 evenly spaced values from `low` to `high` inclusive.
fn evenly(low: f64, high: f64, count: u32) -> impl Iterator<Item = f64> {
    (0..=count).map(move |k| low + (high - low) * f64::from(k) / f64::from(count))
}

fn worst(
    name: &str,
    arguments: impl Iterator<Item = f64>,
    got: fn(f64) -> f64,
    wanted: fn(f64) -> f64,
) -> f64 {
    let found = arguments.map(|x| (ulps(got(x), wanted(x)), x));
    let (ulps, at) =
        found.fold((0.0, 0.0), |worst, next| if next.0 > worst.0 { next } else { worst });
    println!("{name}: {ulps} ulp at {at:e}");
    ulps
}

#[test]
fn exponential_is_within_two_ulp_from_overflow_to_underflow() {
    let all = || {
        let signs = positive(50).filter(|x| *x < 1000.0).flat_map(|x| [x, -x]);
        signs.chain(evenly(-750.0, 711.0, 1_000_000)).chain(evenly(-1.0, 1.0, 100_000))
    };
    assert!(worst("exp", all(), Branchless::exp, Libm::exp) <= 2.0);
    for x in [0.0, -0.0, f64::INFINITY, f64::NEG_INFINITY, f64::NAN, 1e308, -1e308] {
        assert_eq!(ulps(Branchless::exp(x), Libm::exp(x)), 0.0, "{x}");
    }
}

#[test]
fn logarithm_is_within_two_ulp_of_every_positive_number() {
    let all = || positive(500).chain(evenly(0.5, 2.0, 1_000_000));
    assert!(worst("ln", all(), Branchless::ln, Libm::ln) <= 2.0);
    for x in [0.0, -0.0, 1.0, f64::INFINITY, f64::NAN, -1.0, f64::NEG_INFINITY, 5e-324] {
        assert_eq!(ulps(Branchless::ln(x), Libm::ln(x)), 0.0, "{x}");
    }
}

#[test]
fn power_error_is_bounded_by_its_exponent() {
    let mut least_slack = f64::INFINITY;
    for y in [0.01, 0.5, 0.7, 1.0, 2.0, 30.0, 1000.0, 99_999.0, -0.3, -4.0] {
        for x in positive(3).chain(evenly(1e-3, 1.0, 20_000)).chain(evenly(0.9999, 1.0, 20_000)) {
            let (got, wanted) = (Branchless::pow(x, y), Libm::pow(x, y));
            let exponent = (y * Libm::ln(x)).abs();
            if !wanted.is_normal() {
                let tiny = 2.0 * f64::MIN_POSITIVE;
                let same = got == wanted || (got < tiny && wanted < tiny) || exponent > 709.0;
                assert!(same, "{x}^{y}: {got} {wanted}");
                continue;
            }
            let bound = 3.0 + 3.0 * exponent;
            let found = ulps(got, wanted);
            assert!(found <= bound || exponent > 708.0, "{x}^{y}: {got} {wanted}, {found} ulp");
            least_slack = least_slack.min(bound / found);
        }
    }
    println!("pow: bound over error at least {least_slack}");
    assert!(least_slack < 4.0, "the bound is more than four times what is measured");
    for (x, y) in
        [(0.0, 2.0), (0.0, 0.0), (0.5, 0.0), (1.0, 1e5), (f64::INFINITY, 2.0), (0.0, -1.0)]
    {
        assert_eq!(Branchless::pow(x, y), Libm::pow(x, y), "{x}^{y}");
    }
}

#[test]
fn angles_are_within_four_ulp() {
    let cosines = || {
        let near_one = positive(20).filter(|x| *x < 0.5).map(|x| 1.0 - x);
        evenly(0.0, 1.0, 1_000_000).chain(near_one).chain(positive(20).filter(|x| *x <= 1.0))
    };
    assert!(worst("acos", cosines(), Branchless::acos, Libm::acos) <= 2.0);
    let of_sine = |sin: f64| (sin, (1.0 - sin * sin).sqrt());
    let of_cosine = |cos: f64| ((1.0 - cos * cos).sqrt(), cos);
    // The pair is unit only to rounding, and the two functions read different components of it.
    let relative = |(sin, cos)| {
        let (got, wanted) = (Branchless::angle(sin, cos), Libm::angle(sin, cos));
        (got - wanted).abs() / wanted.max(f64::MIN_POSITIVE)
    };
    let pairs = cosines().map(of_sine).chain(cosines().map(of_cosine));
    let off = pairs.map(relative).fold(0.0, f64::max);
    println!("angle: {off:e}");
    assert!(off <= 8e-16);
}

#[test]
fn error_function_is_within_6e_16() {
    let all = evenly(0.0, 6.0, 1_000_000).chain(positive(20).filter(|x| *x <= 6.0));
    let off = all.map(|x| (Branchless::erf(x) - Libm::erf(x)).abs()).fold(0.0, f64::max);
    println!("erf: {off:e}");
    assert!(off <= 6e-16);
}
