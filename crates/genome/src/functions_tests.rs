//! Error of the canonical functions against `libm` in f64, in a dense sweep over all exponents.

use super::*;
use crate::Arithmetic;

/// Every `step`-th positive and negative f32 up to `limit`.
fn sweep(limit: f32, step: u32) -> impl Iterator<Item = f32> {
    (0..=limit.to_bits())
        .step_by(usize::try_from(step).unwrap())
        .flat_map(|bits| [f32::from_bits(bits), -f32::from_bits(bits)])
}

/// Error of `got` in units in the last place of `exact`.
fn ulps(got: f32, exact: f64) -> f64 {
    let exponent = exact.abs().log2().floor().max(-126.0);
    (f64::from(got) - exact).abs() / (exponent - 23.0).exp2()
}

fn check_angle_function(got: f32, exact: f64, x: f32) {
    assert!(got.abs() <= 1.000_000_2, "{x}: {got}");
    if exact.abs() >= 1.0 / 1024.0 {
        assert!(ulps(got, exact) <= 2.0, "{x}: {got} {exact} {} ulp", ulps(got, exact));
    } else {
        assert!((f64::from(got) - exact).abs() <= 1.2e-7, "{x}: {got} {exact}");
    }
}

#[test]
fn sine_and_cosine_are_within_bounds() {
    let near_zeros = (-651..=651).flat_map(|k| {
        let x = k as f32 * std::f32::consts::FRAC_PI_2;
        (-40i32..=40).map(move |d| f32::from_bits((x.to_bits() as i32 + d) as u32))
    });
    for x in sweep(1100.0, 377).chain(near_zeros.filter(|x| x.is_finite())) {
        check_angle_function(x.sine(), Arithmetic::sine(f64::from(x)), x);
        check_angle_function(x.cosine(), Arithmetic::cosine(f64::from(x)), x);
        assert_eq!((-x).sine(), -x.sine(), "odd at {x}");
        assert_eq!((-x).cosine(), x.cosine(), "even at {x}");
    }
}

#[test]
fn power_of_two_is_within_two_ulp() {
    for x in sweep(30.0, 211) {
        let exact = Arithmetic::ex2(f64::from(x));
        assert!(ulps(x.ex2(), exact) <= 2.0, "{x}: {} {exact}", x.ex2());
    }
    for k in -24i8..=16 {
        assert_eq!(f64::from(f32::from(k).ex2()), f64::from(k).exp2().min(f64::from(RANGE)));
    }
}

#[test]
fn smooth_functions_are_within_bounds() {
    for x in sweep(RANGE, 1013) {
        let exact = f64::from(x);
        assert!((f64::from(x.lg2()) - exact.lg2()).abs() <= 2.5e-6, "lg2 {x}: {}", x.lg2());
        assert!(ulps(x.rsq(), exact.rsq()) <= 4.0, "rsq {x}: {} {}", x.rsq(), exact.rsq());
        if x.abs() > 1e-30 {
            assert!(ulps(x.rcp(), exact.rcp()) <= 4.0, "rcp {x}: {} {}", x.rcp(), exact.rcp());
        }
        let (got, exact) = (f64::from(x.spl()), exact.spl());
        assert!((got - exact).abs() <= 1e-6 + exact * 1.2e-7, "spl {x}: {got} {exact}");
    }
}

#[test]
fn logarithm_is_within_bounds() {
    let positive = (f32::MIN_POSITIVE.to_bits()..=f32::MAX.to_bits()).step_by(977);
    for t in positive.map(f32::from_bits) {
        let exact = libm::log2(f64::from(t));
        let error = (f64::from(Functions::KNOWN.log2(t)) - exact).abs();
        assert!(error <= 2e-7 * exact.abs().max(1.0), "{t}: {error:e} {exact}");
    }
}

#[test]
fn clamps_change_nothing_within_the_domain_without_them() {
    let functions = Functions::KNOWN;
    for x in sweep(1024.0, 733) {
        assert_eq!(functions.sin::<false>(x).to_bits(), x.sine().to_bits(), "{x}");
        assert_eq!(functions.cos::<false>(x).to_bits(), x.cosine().to_bits(), "{x}");
        if (-24.0..15.9).contains(&x) {
            assert_eq!(functions.ex2::<false>(x).to_bits(), x.ex2().to_bits(), "{x}");
        }
    }
}
