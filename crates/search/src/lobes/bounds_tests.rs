//! Tests of bounds on materials whose highlights are known everywhere.

use brood_brdf::{Brdf, Claims, Input};
use brood_target::draw_pairs;
use glam::{DVec2, DVec3};

use super::*;

/// A highlight of that width (tan theta_h) over a constant, brighter towards the horizon by
/// Schlick's Fresnel term.
struct Highlight {
    width: f64,
    peak: f64,
}

impl Brdf for Highlight {
    fn f(&self, pair: &DirectionPair) -> DVec3 {
        let of = |input: Input| input.evaluate(pair, DVec2::ZERO);
        let tail = 1.0 + libm::exp(2.0 * of(Input::LogTanHalf)) / (self.width * self.width);
        let rise = 0.04 + 0.96 * libm::pow(1.0 - of(Input::HalfDotLight).clamp(0.0, 1.0), 5.0);
        DVec3::splat(0.1) + DVec3::new(1.0, 0.9, 0.8) * self.peak * rise / (tail * tail)
    }

    fn claims(&self) -> Claims {
        Claims { reciprocal: true, conserving: false }
    }
}

fn bounded(material: &Highlight) -> (Samples, Bounds) {
    let samples = Samples::of(material, draw_pairs(4096, 1));
    let bounds = Bounds::new(&BoundEstimator::new(&samples), narrow_pairs(2000, 5));
    (Samples::of(material, bounds.pairs.clone()), bounds)
}

#[test]
fn sampled_highlights_are_within_bounds() {
    for width in [0.01, 0.03, 0.1, 0.5] {
        let (expected, bounds) = bounded(&Highlight { width, peak: 100.0 });
        let (mut above, mut below) = (0, 0);
        for (expected, [most, least]) in expected.values().iter().zip(&bounds.values) {
            above += usize::from(most.is_some_and(|most| expected[0] > CHECK_MARGIN * most[0]));
            below += usize::from(least.is_some_and(|least| expected[0] < least[0]));
        }
        assert!(above <= 30 && below <= 30, "{width}: {above} above and {below} below of 2000");
    }
}

/// At most angles of incidence, no sample is close enough to show these highlights.
#[test]
fn growth_does_not_cut_highlights_narrower_than_the_samples() {
    for width in [0.0005, 0.001, 0.002, 0.004] {
        let material = Highlight { width, peak: 1000.0 };
        let known = || BoundEstimator::new(&Samples::of(&material, draw_pairs(4096, 1)));
        let [over, over_without_growth] =
            [known(), known().without_growth()].map(|known| over(&material, &known));
        assert_eq!(over, over_without_growth, "{width}");
    }
}

/// Number of points, of 2000, at which the material exceeds its upper bound.
fn over(material: &Highlight, known: &BoundEstimator) -> usize {
    let bounds = Bounds::new(known, narrow_pairs(2000, 5));
    let passes = |(pair, [most, _]): &(&DirectionPair, &[Option<[f64; 3]>; 2])| {
        most.is_some_and(|most| material.f(pair).x > CHECK_MARGIN * most[0])
    };
    bounds.pairs.iter().zip(&bounds.values).filter(passes).count()
}

#[test]
fn growth_tightens_bounds_between_samples() {
    let (expected, bounds) = bounded(&Highlight { width: 0.1, peak: 1000.0 });
    let all = expected.pairs().iter().zip(expected.values()).zip(&bounds.values);
    let is_between = |pair: &DirectionPair| {
        let place = Place::of(pair);
        place.theta_d < 0.8 && place.half < -6.5
    };
    let between = all.filter(|((pair, _), _)| is_between(pair));
    let over: Vec<f64> = between
        .map(|((_, expected), [most, _])| most.map_or(f64::INFINITY, |most| most[0]) / expected[0])
        .collect();
    // At least seven in eight bounds are within 5 times the value. The bound by the largest sample,
    // at the horizon, would be 25 times the value everywhere.
    let loose = over.iter().filter(|over| **over > 5.0).count();
    assert!(over.len() > 100 && 8 * loose < over.len(), "{loose} of {}", over.len());
}

#[test]
fn ceiling_tolerance_does_not_depend_on_the_brightest_sample() {
    for largest in [1e-3, 1.0, 100.0] {
        let bounds = Bounds::of_ceiling(largest, 1);
        let shape = Shape::new(4, 5, true);
        let points = bounds.above(&shape);
        for point in points.iter().step_by(1000) {
            // The criterion of `Pool::is_below`: tolerates a factor of 1.6, rejects a factor of 2.
            let excess = |times: f64| {
                let found = libm::log1p(times * largest * f64::from(point.weight));
                let excess = (found - f64::from(point.target[0])).max(0.0);
                f64::from(point.importance) * f64::from(point.importance) * excess * excess
            };
            let tolerated = f64::from(super::super::guard::TOLERATED);
            assert!(excess(1.6) < tolerated && excess(2.0) > tolerated, "{largest}");
        }
    }
}
