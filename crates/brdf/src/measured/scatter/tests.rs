//! Interpolation of samples of models, tested on held-out samples.

use std::f64::consts::TAU;

use proptest::prelude::*;

use super::*;
use crate::Model;

fn direction(z: f64, phi: f64) -> DVec3 {
    let sine = (1.0 - z * z).sqrt();
    DVec3::new(sine * phi.cos(), sine * phi.sin(), z)
}

/// Fractional parts of an additive sequence, which fill a cube evenly.
fn even(k: usize) -> [f64; 4] {
    [0.856_674_9, 0.733_891_9, 0.628_707, 0.538_598].map(|step| ((k + 1) as f64 * step).fract())
}

/// Pairs: every second one anywhere, the others near the highlight.
fn pairs(from: usize, count: usize) -> Vec<DirectionPair> {
    let pair = |k: usize| {
        let [a, b, c, d] = even(k);
        let wi = direction(a.sqrt(), b * TAU);
        let wo = if k.is_multiple_of(2) {
            direction(c.sqrt(), d * TAU)
        } else {
            let normal = direction((0.6 * c * c).cos(), d * TAU);
            2.0 * wi.dot(normal) * normal - wi
        };
        (wo.z > 0.02 && wi.z > 0.02).then(|| DirectionPair::new(wi, wo).unwrap())
    };
    (from..).filter_map(pair).take(count).collect()
}

fn samples(model: &str, pairs: &[DirectionPair]) -> MeasuredSamples {
    let mut lines = model.lines();
    let kind = lines.next().unwrap().parse().unwrap();
    let model = lines.fold(Model::new(kind), |model, line| {
        let (name, values) = line.split_once(' ').unwrap();
        model.with_text(name, values).unwrap()
    });
    let brdf = model.brdf();
    MeasuredSamples::new(pairs.iter().map(|pair| (*pair, brdf.f(pair))).collect()).unwrap()
}

/// Relative errors at held-out samples, in ascending order.
fn errors(model: &str, count: usize) -> Vec<f64> {
    let (known, asked) = (samples(model, &pairs(0, count)), samples(model, &pairs(1 << 20, 2000)));
    let scattered = Scattered::new(&known);
    let error = |(pair, rgb): &(DirectionPair, DVec3)| {
        ((scattered.f(pair) - *rgb) / *rgb).abs().max_element()
    };
    let mut errors: Vec<f64> = asked.rows().iter().map(error).collect();
    errors.sort_by(f64::total_cmp);
    errors
}

#[test]
fn held_out_values_are_interpolated() {
    for (model, middle, most) in [
        ("lambert", 1e-9, 1e-9),
        ("oren-nayar", 1e-3, 2e-2),
        ("conductor\nroughness 0.2", 1e-3, 2e-2),
        ("rough-plastic\nroughness 0.1", 1e-3, 0.1),
    ] {
        let errors = errors(model, 4096);
        let (median, high) = (errors[errors.len() / 2], errors[errors.len() * 99 / 100]);
        println!("{model}: {median:.1e} {high:.1e} {:.1e}", errors[errors.len() - 1]);
        assert!(median < middle && high < most, "{model}: {median:.1e} {high:.1e}");
    }
}

/// True if `f` equals `rgb` to a relative error of 1e-6.
fn is_close(f: DVec3, rgb: DVec3) -> bool {
    ((f - rgb) / rgb).abs().max_element() < 1e-6
}

#[test]
fn samples_are_reproduced_as_are_their_rotations_and_mirror_images() {
    let known = samples("conductor\nroughness 0.1", &pairs(0, 1000));
    let scattered = Scattered::new(&known);
    for (pair, rgb) in known.rows() {
        let found = scattered.f(pair);
        assert!(is_close(found, *rgb), "{pair:?} {rgb} {found}");
        let change = |w: DVec3| DVec3::new(-w.y, -w.x, w.z);
        let mirrored = DirectionPair::new(change(pair.wi()), change(pair.wo())).unwrap();
        assert!(is_close(scattered.f(&mirrored), *rgb));
    }
}

#[test]
fn swapped_pairs_follow_the_measured_ones_where_they_were_not_measured() {
    let lower: Vec<DirectionPair> =
        pairs(0, 8000).into_iter().filter(|pair| pair.cos_i() > pair.cos_o() + 0.5).collect();
    let known = samples("conductor\nroughness 0.3", &lower);
    let scattered = Scattered::new(&known);
    for (pair, rgb) in known.rows() {
        assert!(is_close(scattered.f(&pair.swapped()), *rgb), "{pair:?}");
    }
    // A material that is not reciprocal keeps its ratio of three.
    let both: Vec<_> = pairs(0, 2000)
        .into_iter()
        .map(|pair| (pair, DVec3::splat(if pair.cos_i() > pair.cos_o() { 3.0 } else { 1.0 })))
        .collect();
    let scattered = Scattered::new(&MeasuredSamples::new(both).unwrap());
    let at = |x: f64| DVec3::new(x, 0.1, 0.8).normalize();
    let pair = DirectionPair::new(at(0.1), at(-1.5)).unwrap();
    assert!(scattered.f(&pair).x > 2.5 && scattered.f(&pair.swapped()).x < 1.5);
}

#[test]
fn single_sample_is_constant_and_negative_values_become_zero() {
    let pair = DirectionPair::new(DVec3::Z, direction(0.5, 0.0)).unwrap();
    let one = MeasuredSamples::new(vec![(pair, DVec3::new(0.5, -0.1, 0.0))]).unwrap();
    let scattered = Scattered::new(&one);
    let other = DirectionPair::new(direction(0.2, 1.0), direction(0.9, 2.0)).unwrap();
    for pair in [pair, other] {
        let f = scattered.f(&pair);
        assert!((f.x - 0.5).abs() < 1e-12 && f.max_element() < 0.6 && f.y.max(f.z) < 1e-15, "{f}");
    }
    let black = Scattered::new(&MeasuredSamples::new(vec![(pair, DVec3::ZERO); 9]).unwrap());
    assert_eq!(black.f(&other), DVec3::ZERO);
    // Samples at the same coordinates are averaged.
    let mirrored = DirectionPair::new(DVec3::Z, direction(0.5, 2.0)).unwrap();
    let two = vec![(pair, DVec3::ONE), (mirrored, DVec3::splat(3.0))];
    let mean = Scattered::new(&MeasuredSamples::new(two).unwrap()).f(&pair);
    assert!((mean - DVec3::splat(2.0)).length() < 1e-9, "{mean}");
}

fn any_direction() -> impl Strategy<Value = DVec3> {
    let cosine = prop_oneof![0.0..1.0, Just(1.0), Just(1e-9), Just(0.5)];
    (cosine, prop_oneof![-4.0..4.0, Just(0.0)]).prop_map(|(z, phi)| direction(z, phi))
}

proptest! {
    #[test]
        fn values_are_finite_and_not_negative_for_any_samples(
        rows in prop::collection::vec(
            (any_direction(), any_direction(), prop::array::uniform3(
                prop_oneof![Just(0.0), -1.0..1.0, Just(1e-300), Just(1e300), Just(1e-3)])),
            1..60,
        ),
        (wi, wo) in (any_direction(), any_direction()),
    ) {
        let rows = rows.into_iter().map(|(wi, wo, rgb)| {
            (DirectionPair::new(wi, wo).unwrap(), DVec3::from_array(rgb))
        });
        let Ok(samples) = MeasuredSamples::new(rows.collect()) else { return Ok(()) };
        let f = Scattered::new(&samples).f(&DirectionPair::new(wi, wo).unwrap());
        prop_assert!(f.is_finite() && f.min_element() >= 0.0, "{f}");
    }
}
