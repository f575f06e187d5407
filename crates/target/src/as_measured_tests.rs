//! Tests of the least error on f as measured.

use brood_brdf::{MeasuredSamples, Model, ModelKind};
use glam::{DQuat, DVec3};

use super::*;
use crate::{MeasuredTarget, draw_pairs, metric};

#[test]
fn floor_is_zero_only_for_reciprocal_materials() {
    let floor = |kind| MeasuredTarget::of(&*Model::new(kind).brdf()).unwrap().floor().unwrap();
    assert!(floor(ModelKind::Conductor) < 1e-12);
    assert!(floor(ModelKind::Phong) > 1e-3);
}

/// The samples that are fitted are reciprocal, so their error is 0, below the floor. On f as
/// measured, in both orders, the same material is at least as far away as the floor.
#[test]
fn floor_is_below_the_error_of_reciprocal_materials_on_the_same_samples() {
    let phong = Model::new(ModelKind::Phong);
    let target = MeasuredTarget::of(&*phong.brdf()).unwrap();
    let AsMeasured { samples, floor, repeated } = target.measured.as_ref().unwrap();
    assert_eq!((samples.len(), *repeated), (2 * target.held.len(), samples.len()));
    let error = |found: &dyn Fn(usize) -> [f64; 3]| {
        let found = (0..samples.len()).map(found).collect();
        let found = Samples::new(samples.pairs().to_vec(), found);
        metric::e_log(&samples.weighted(), &found.weighted())
    };
    let exact = error(&|at| phong.brdf().f(&samples.pairs()[at]).to_array());
    assert!(exact < 1e-12, "{exact}");
    let mean = error(&|at| target.held.values()[at / 2]);
    let darker = error(&|at| target.held.values()[at / 2].map(|f| 0.9 * f));
    assert!(*floor <= mean && mean < 3.0 * floor, "{mean} {floor}");
    assert!(darker > *floor, "{darker} {floor}");
}

/// Pairs as a goniometer gives them: half of them in both orders, some of these turned about the
/// normal, with the angles of a file of six digits.
#[test]
fn given_pairs_in_both_orders_have_the_floor_of_their_values() {
    let phong = Model::new(ModelKind::Phong).brdf();
    let round = |w: DVec3| (w * 1e6).round() / 1e6;
    let given = draw_pairs(200, 3).into_iter().enumerate().flat_map(|(at, pair)| {
        let turn = DQuat::from_rotation_z(0.01 * at as f64);
        let other = DirectionPair::new(turn * pair.wo(), turn * pair.wi()).unwrap();
        if at < 100 { vec![pair, other] } else { vec![pair] }
    });
    let rows = given.map(|pair| {
        let rounded =
            DirectionPair::new(round(pair.wi()).normalize(), round(pair.wo()).normalize());
        (rounded.unwrap(), phong.f(&pair))
    });
    let samples = MeasuredSamples::new(rows.collect()).unwrap();
    let AsMeasured { samples, repeated, floor } =
        MeasuredTarget::of_samples(&samples).unwrap().measured.unwrap();
    // Rounding separates few pairs.
    assert!(samples.len() == 300 && (190..=200).contains(&repeated), "{repeated}");
    let groups = (0..100).map(|k| vec![2 * k, 2 * k + 1]);
    let known = super::floor(&samples, groups);
    assert!(floor > 1e-3 && (floor / known - 1.0).abs() < 0.05, "{floor} {known}");
}

#[test]
fn given_pairs_in_one_order_have_no_floor() {
    let brdf = Model::new(ModelKind::Phong).brdf();
    assert!(AsMeasured::given(&Samples::of(&*brdf, draw_pairs(1000, 3))).is_none());
}

#[test]
fn exchange_and_turn_keep_the_place() {
    for (at, pair) in draw_pairs(200, 5).iter().enumerate() {
        let turn = DQuat::from_rotation_z(0.1 * at as f64);
        let turned = DirectionPair::new(turn * pair.wi(), turn * pair.wo()).unwrap();
        let near = |a: [i64; 3], b: [i64; 3]| a.iter().zip(b).all(|(a, b)| (a - b).abs() <= 1);
        assert!(near(place(pair), place(&turned)), "{pair:?}");
        assert_eq!(place(pair), place(&pair.swapped()), "{pair:?}");
    }
    let normal = DirectionPair::new(DVec3::Z, DVec3::new(0.6, 0.0, 0.8)).unwrap();
    let beside = DirectionPair::new(DVec3::new(0.0, 0.6, 0.8), DVec3::Z).unwrap();
    assert_eq!(place(&normal), place(&beside));
}

#[test]
fn least_squares_is_the_minimum_of_a_fine_scan() {
    let sets: [&[(f64, f64)]; 6] = [
        &[(0.5, 0.3), (0.5, 0.9)],
        &[(0.0, 0.3), (2.0, 0.9)],
        &[(900.0, 0.02), (0.1, 1.0)],
        &[(1e4, 1.0), (1e-3, 0.01)],
        &[(3.0, 0.5), (5.0, 0.5)],
        &[(3.0, 0.5), (5.0, 0.5), (4.5, 0.9), (3.0, 0.1)],
    ];
    for measured in sets {
        let error = |f: f64| -> f64 {
            let of = |(g, cos): &(f64, f64)| (g * cos).ln_1p() - (f * cos).ln_1p();
            measured.iter().map(of).map(|difference| difference * difference).sum()
        };
        let all = || measured.iter().map(|(f, _)| *f);
        let (low, high) = (all().fold(f64::INFINITY, f64::min), all().fold(0.0, f64::max));
        let at = |step: u32| {
            (low.ln_1p() + (high.ln_1p() - low.ln_1p()) * f64::from(step) / 1e4).exp_m1()
        };
        let scanned = (0..=10_000).map(at).map(error).fold(f64::INFINITY, f64::min);
        let found = least_squares(measured);
        assert!((found - scanned).abs() < 1e-6, "{measured:?} {found} {scanned}");
    }
}
