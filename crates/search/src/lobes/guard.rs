//! Bounds where hardly a sample is: close to the mirror direction and at grazing angles.
//!
//! Without them a fit that agrees with every sample may reach 1e35 beyond 80 degrees. Materials fall off from the mirror
//! direction, so a point is bounded from below by samples farther from it, and from above by samples nearer to it, at about the same
//! angle of incidence. A bound is held better than the value of the nearest sample: reflectance changes so much there that any value
//! would be wrong.

use std::sync::Arc;

use brood_brdf::{DirectionPair, Input};
use glam::DVec2;
use rayon::prelude::*;

use super::albedo::{Albedos, TOLERATED as TOLERATED_ALBEDO};
use super::batch::{Batch, Point, points};
use super::damped::Damped;
use super::normal::excesses;
use super::{Lobes, Shape};
use crate::{Samples, narrow_pairs};

/// Points, each bounded from above and from below.
const COUNT: usize = 1024;
/// Points that a fit is looked at in when it is done; those are held that it stands out in, so many at once and so often.
const POOL: usize = 4096;
const WORST: usize = 256;
const ROUNDS: usize = 5;
const STEPS: usize = 8;
/// Points that nothing may stand out in from everything that was measured, when all is done.
const CEILED: usize = 1 << 16;
/// What a squared excess counts there.
const IMPORTANCE_ABOVE: f64 = 2.0;
/// What a bound there is of the one that fits are held by.
const WIDER: f64 = 1.4;
/// Squared excesses, summed over channels, that are let be: a fifth more in one channel.
const TOLERATED: f32 = 2.0 * 0.033;
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

/// Pairs of directions where samples are few, and what samples say of them.
pub(super) struct Bounds {
    pairs: Vec<DirectionPair>,
    /// From above and from below.
    values: Vec<[Option<[f64; 3]>; 2]>,
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

    fn new(samples: &Samples, pairs: Vec<DirectionPair>) -> Self {
        let places: Vec<Place> = samples.pairs().par_iter().map(Place::of).collect();
        let of = |pair: &DirectionPair| bounds(&places, samples.values(), &Place::of(pair));
        Self { values: pairs.par_iter().map(of).collect(), pairs }
    }

    /// The points as a shape reads them, bounded from both sides.
    pub(super) fn points(&self, shape: &Shape) -> Vec<Point> {
        self.with(shape, IMPORTANCE, |[above, below]| [above, below])
    }

    /// The points as a shape reads them, bounded from above.
    fn above(&self, shape: &Shape) -> Vec<Point> {
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
            let weight = f64::from(point.weight).max(FLOOR);
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

/// Where a fit that is done is looked at for spikes, and for reflecting more than there is.
pub(super) struct Pool {
    points: Vec<Point>,
    batch: Batch,
    albedos: Arc<Albedos>,
    /// From here on nothing passes the brightest sample by far.
    ceiled: usize,
}

impl Pool {
    pub(super) fn new(bounds: &Bounds, shape: &Shape) -> Self {
        let points = bounds.above(shape);
        let count = points.len();
        Self::of(points, count, Arc::new(Albedos::new(shape)))
    }

    fn of(points: Vec<Point>, ceiled: usize, albedos: Arc<Albedos>) -> Self {
        Self { batch: Batch::new(points.iter()), points, albedos, ceiled }
    }

    /// The same with many more points, where nothing passes the brightest sample by far.
    pub(super) fn ceiled(&self, shape: &Shape, largest: f64, seed: u64) -> Self {
        let pairs = narrow_pairs(CEILED, seed.wrapping_add(2 << 32));
        let values = vec![[Some([largest; 3]), None]; pairs.len()];
        let mut points = self.points.clone();
        points.extend(Bounds { pairs, values }.above(shape));
        Self::of(points, self.points.len(), self.albedos.clone())
    }

    /// What light there is.
    pub(super) fn albedos(&self) -> &Arc<Albedos> {
        &self.albedos
    }

    /// Whether it passes the brightest sample by far in none of the many points.
    pub(super) fn is_below(&self, lobes: &Lobes) -> bool {
        let excesses = excesses(lobes, &self.batch);
        excesses[self.ceiled..self.points.len()].iter().all(|excess| *excess <= TOLERATED)
    }

    /// The fit, gone on with on `batch` and those of the points that it stands out in, and below what light there is, as long as it
    /// is over either.
    pub(super) fn hold(&self, mut fit: Damped, batch: &Batch) -> Damped {
        let mut held = vec![false; self.points.len()];
        let mut is_under = false;
        for _ in 0..ROUNDS {
            let excesses = excesses(&fit.lobes, &self.batch);
            let mut over: Vec<(usize, f32)> = (0..self.points.len())
                .map(|at| (at, excesses[at]))
                .filter(|(at, excess)| *excess > TOLERATED && !held[*at])
                .collect();
            let is_over = self.albedos.largest(&fit.lobes) > TOLERATED_ALBEDO;
            if over.is_empty() && !is_over {
                break;
            }
            is_under |= is_over;
            over.sort_by(|a, b| b.1.total_cmp(&a.1).then(a.0.cmp(&b.0)));
            for (at, _) in over.iter().take(WORST) {
                held[*at] = true;
            }
            let points = self.points.iter().zip(&held).filter(|(_, held)| **held);
            let bounded = batch.with(points.map(|(point, _)| point));
            let bounded = if is_under { bounded.under(&self.albedos) } else { bounded };
            fit = fit.on(&bounded);
            fit.refine(&bounded, STEPS);
        }
        fit.on(batch)
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
