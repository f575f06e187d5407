//! Bounds where hardly a sample is: close to the mirror direction and at grazing angles.
//!
//! Without them a fit that agrees with every sample may reach 1e35 beyond 80 degrees. Materials fall off from the mirror
//! direction, so a point is bounded from below by samples farther from it, and from above by samples nearer to it, at about the same
//! angle of incidence, or by how fast they grow where none is nearer. A bound is held better than the value of the nearest sample: reflectance changes so much there that any value
//! would be wrong.

use std::ops::RangeInclusive;

use brood_brdf::{DirectionPair, Input};
use glam::DVec2;
use rayon::prelude::*;

use super::Shape;
use super::batch::{Point, points};
use crate::{Samples, narrow_pairs};

/// Points, each bounded from above and from below.
const COUNT: usize = 1024;
/// Points that a fit is looked at in when it is done.
const POOL: usize = 4096;
/// Points that nothing may stand out in from everything that was measured, when all is done.
const CEILED: usize = 1 << 16;
/// What a squared excess counts where fits are looked at when they are done.
const IMPORTANCE_ABOVE: f64 = 2.0;
/// What a bound there is of the one that fits are held by.
const WIDER: f64 = 1.4;
/// What a squared excess counts of the squared difference of a sample.
const IMPORTANCE: f64 = 0.2;
/// cos_i counts as at least this.
const FLOOR: f64 = 0.17;
/// And as at least so many times 1 over the brightest sample where nothing passes that: ln(1 + f cos_i) tells how many times it is passed
/// where this is far above 1 alone.
const BRIGHT: f64 = 10.0;
/// What a bound is of the largest sample, from above and from below.
const MARGINS: (f64, f64) = (1.3, 0.7);
/// Samples whose ln tan theta_h is by this much less than a point's belong to those it is bounded by from above.
const NEARER: f64 = 0.5;
/// Growth towards the mirror direction is that between the brightest samples of the nearest two such ranges of ln tan theta_h.
const WINDOW: f64 = 1.0;
/// What a bound is of what samples would have grown to, and how many times as fast they may grow: none of twenty materials of MERL
/// passes such a bound where it does not pass the one by the largest sample.
const GROWN: f64 = 1.5;
const GROWTH: f64 = 1.5;
/// ln tan 3 degrees: as far from the mirror direction every material falls off from it.
const CLOSE: f64 = -2.949;
/// theta_d of samples that bound a point is within this of its own, from above and from below.
const ALIKE: (f64, f64) = (10.0 / 180.0 * std::f64::consts::PI, 2.0 / 180.0 * std::f64::consts::PI);

/// Pairs of directions where samples are few, and what samples say of them.
pub(super) struct Bounds {
    pairs: Vec<DirectionPair>,
    /// From above and from below.
    values: Vec<[Option<[f64; 3]>; 2]>,
    /// What cos_i counts as at least.
    floor: f64,
}

impl Bounds {
    /// Of the points that every fit is held by, from both sides.
    pub(super) fn of_fits(samples: &Samples, seed: u64) -> Self {
        Self::new(samples, narrow_pairs(COUNT, seed))
    }

    /// Of the points that fits are looked at in afterwards.
    pub(super) fn of_pool(samples: &Samples, seed: u64) -> Self {
        Self::new(samples, narrow_pairs(POOL, seed.wrapping_add(1 << 32)))
    }

    /// Of many more, where nothing passes the brightest sample.
    pub(super) fn of_ceiling(largest: f64, seed: u64) -> Self {
        let pairs = narrow_pairs(CEILED, seed.wrapping_add(2 << 32));
        let values = vec![[Some([largest; 3]), None]; pairs.len()];
        Self { values, pairs, floor: FLOOR.max(BRIGHT / largest.max(1e-6)) }
    }

    fn new(samples: &Samples, pairs: Vec<DirectionPair>) -> Self {
        // Where f is known not to be below a value it may be that, and says nothing of how highlights grow.
        let (pairs_below, below): (Vec<_>, Vec<_>) = samples.least().iter().copied().unzip();
        let grows = below.is_empty();
        let places: Vec<Place> =
            samples.pairs().par_iter().chain(&pairs_below).map(Place::of).collect();
        let values = [samples.values(), &below].concat();
        let of = |pair: &DirectionPair| bounds(&places, &values, grows, &Place::of(pair));
        Self { values: pairs.par_iter().map(of).collect(), pairs, floor: FLOOR }
    }

    /// The points as a shape reads them, bounded from both sides.
    pub(super) fn points(&self, shape: &Shape) -> Vec<Point> {
        self.with(shape, IMPORTANCE, |[above, below]| [above, below])
    }

    /// The points as a shape reads them, bounded from above.
    pub(super) fn above(&self, shape: &Shape) -> Vec<Point> {
        self.with(shape, IMPORTANCE_ABOVE, |[above, _]| {
            [above.map(|bound| bound.map(|f| WIDER * f)), None]
        })
    }

    #[expect(clippy::cast_possible_truncation, reason = "the fit is of f32, as the machine is")]
    fn with(
        &self,
        shape: &Shape,
        importance: f64,
        sides: impl Fn([Option<[f64; 3]>; 2]) -> [Option<[f64; 3]>; 2],
    ) -> Vec<Point> {
        let values = vec![[0.0; 3]; self.pairs.len()];
        let unbounded = points(&Samples::new(self.pairs.clone(), values), shape);
        let bounded = |(point, bounds): (Point, &[Option<[f64; 3]>; 2])| {
            let weight = f64::from(point.weight).max(self.floor);
            let of = |side: f32, bound: [f64; 3]| Point {
                wanted: bound.map(|f| libm::log1p(f * weight) as f32),
                weight: weight as f32,
                importance: importance.sqrt() as f32,
                share: 0.0,
                side,
                ..point.clone()
            };
            let [above, below] = sides(*bounds);
            [above.map(|bound| of(1.0, bound)), below.map(|bound| of(-1.0, bound))]
        };
        unbounded.into_iter().zip(&self.values).flat_map(bounded).flatten().collect()
    }
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

/// What samples at about the same theta_d would have grown to at a point nearer to the mirror direction than they are, if they went on
/// growing as they do where they are nearest to it. Highlights grow the slower, in ln f over ln theta_h, the nearer they are.
fn grown(places: &[Place], values: &[[f64; 3]], point: &Place) -> Option<[f64; 3]> {
    let beside = |place: &Place| (place.theta_d - point.theta_d).abs() < ALIKE.0;
    let beside: Vec<(&Place, &[f64; 3])> =
        places.iter().zip(values).filter(|(place, _)| beside(place)).collect();
    // Materials get brighter towards the horizon: a sample that is farther from it than the point alone says too little.
    let lower = beside.iter().filter(|(place, _)| place.theta_d >= point.theta_d);
    let nearest = lower.map(|(place, _)| place.half).fold(f64::INFINITY, f64::min);
    let brightest = |range: RangeInclusive<f64>, c: usize| {
        let among = beside.iter().filter(|(place, _)| range.contains(&place.half));
        among.map(|(place, f)| (place.half, f[c])).max_by(|a, b| a.1.total_cmp(&b.1))
    };
    let mut grown = [0.0; 3];
    for (c, grown) in grown.iter_mut().enumerate() {
        let (near, most) = brightest(f64::NEG_INFINITY..=nearest + WINDOW, c)?;
        let (far, least) = brightest(nearest + WINDOW..=nearest + 2.0 * WINDOW, c)?;
        let growth = libm::log(most / least).max(0.0) / (far - near).max(WINDOW / 2.0);
        *grown = most * libm::exp(GROWTH * growth * (near - point.half).max(0.0));
    }
    grown.iter().all(|f| f.is_finite() && *f > 0.0).then_some(grown)
}

/// At most and at least this, where samples say so; of how they grow only where that is known.
fn bounds(
    places: &[Place],
    values: &[[f64; 3]],
    grows: bool,
    point: &Place,
) -> [Option<[f64; 3]>; 2] {
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
    let grown = if grows && is_close && !is_known { grown(places, values, point) } else { None };
    let above = match (above, grown) {
        (Some(above), Some(grown)) => Some([0, 1, 2].map(|c| above[c].min(GROWN * grown[c]))),
        (above, _) => above,
    };
    let below = largest(MARGINS.1, &|place| {
        is_close && apart(place) < ALIKE.1 && place.half >= point.half && place.half < CLOSE
    });
    [above, below]
}

#[cfg(test)]
#[path = "bounds_tests.rs"]
mod tests;
