//! Bounds where hardly a sample is: close to the mirror direction and at grazing angles.
//!
//! Without them a fit that agrees with every sample may reach 1e35 beyond 80 degrees. Materials fall off from the mirror
//! direction, so a point is bounded from below by samples farther from it, and from above by samples nearer to it, at about the same
//! angle of incidence. A bound is held better than the value of the nearest sample: reflectance changes so much there that any value
//! would be wrong.

use brood_brdf::{DirectionPair, Input};
use glam::DVec2;

use super::Shape;
use super::batch::{Point, points};
use crate::{Samples, narrow_pairs};

/// Points, each bounded from above and from below.
const COUNT: usize = 1024;
/// What a squared excess counts of the squared difference of a sample.
const IMPORTANCE: f64 = 0.2;
/// cos_i counts as at least this.
const FLOOR: f64 = 0.17;
/// What a bound is of the largest sample, from above and from below.
const MARGINS: (f64, f64) = (1.3, 0.7);
/// Samples whose ln tan theta_h is by this much less than a point's belong to those it is bounded by from above.
const NEARER: f64 = 0.5;
/// ln tan 3 degrees: as far from the mirror direction every material falls off from it.
const CLOSE: f64 = -2.949;
/// theta_d of samples that bound a point is within this of its own, from above and from below.
const ALIKE: (f64, f64) = (10.0 / 180.0 * std::f64::consts::PI, 2.0 / 180.0 * std::f64::consts::PI);

/// The bounded points.
#[expect(clippy::cast_possible_truncation, reason = "the fit is of f32, as the machine is")]
pub(super) fn guard(samples: &Samples, shape: &Shape, seed: u64) -> Vec<Point> {
    let pairs = narrow_pairs(COUNT, seed);
    let places: Vec<Place> = samples.pairs().iter().map(Place::of).collect();
    let bounds: Vec<[Option<[f64; 3]>; 2]> =
        pairs.iter().map(|pair| bounds(&places, samples.values(), &Place::of(pair))).collect();
    let values = vec![[0.0; 3]; pairs.len()];
    let unbounded = points(&Samples::new(pairs, values), shape);
    let bounded = |(point, bounds): (Point, &[Option<[f64; 3]>; 2])| {
        let weight = f64::from(point.weight).max(FLOOR);
        let of = |side: f32, bound: [f64; 3]| Point {
            wanted: bound.map(|f| libm::log1p(f * weight) as f32),
            weight: weight as f32,
            importance: IMPORTANCE.sqrt() as f32,
            side,
            ..point.clone()
        };
        let [above, below] = *bounds;
        [above.map(|bound| of(1.0, bound)), below.map(|bound| of(-1.0, bound))]
    };
    unbounded.into_iter().zip(&bounds).flat_map(bounded).flatten().collect()
}

/// What a bound looks at of a pair.
#[derive(Clone, Copy)]
struct Place {
    /// 1/2 ln(tan^2 theta_h + 1e-7).
    half: f64,
    /// In radians.
    theta_d: f64,
}

impl Place {
    fn of(pair: &DirectionPair) -> Self {
        let of = |input: Input| input.evaluate(pair, DVec2::ZERO);
        let cosine = of(Input::HalfDotLight).clamp(0.0, 1.0);
        Self { half: of(Input::LogTanHalf), theta_d: libm::acos(cosine) }
    }
}

/// At most and at least this, where samples say so.
fn bounds(places: &[Place], values: &[[f64; 3]], point: &Place) -> [Option<[f64; 3]>; 2] {
    let largest = |margin: f64, counts: &dyn Fn(&Place) -> bool| {
        let among = places.iter().zip(values).filter(|(place, _)| counts(place));
        among
            .map(|(_, value)| value.map(|f| margin * f))
            .reduce(|a, b| [0, 1, 2].map(|c| a[c].max(b[c])))
    };
    let apart = |place: &Place| (place.theta_d - point.theta_d).abs();
    let near = |place: &Place| apart(place) < ALIKE.0 && place.half >= point.half - NEARER;
    let is_close = point.half < CLOSE;
    // Where no sample is as near to the mirror direction, the local ones say nothing of how high the peak is.
    let is_known = is_close && places.iter().any(|place| near(place) && place.half <= point.half);
    let above = largest(MARGINS.0, &|place| {
        if is_known { near(place) } else { place.half >= point.half - NEARER }
    });
    let below = largest(MARGINS.1, &|place| {
        is_close && apart(place) < ALIKE.1 && place.half >= point.half && place.half < CLOSE
    });
    [above, below]
}
