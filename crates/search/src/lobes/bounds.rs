//! Points where hardly a sample is, close to the mirror direction and at grazing angles, and the bounds that fits are held by there.
//!
//! Without them a fit that agrees with every sample may reach 1e35 beyond 80 degrees.

use brood_brdf::DirectionPair;
use rayon::prelude::*;

use super::Shape;
use super::batch::{Point, points};
use super::known::{Known, Place};
use crate::target::grazing_pairs;
use crate::{Samples, narrow_pairs};

/// Points, each bounded from above and from below.
const COUNT: usize = 1024;
/// Points that a fit is looked at in when it is done.
const POOL: usize = 4096;
/// Points that nothing may stand out in from everything that was measured, when all is done.
const CEILED: usize = 1 << 16;
/// To so many close to the mirror direction there is one towards the horizon, wherever the mirror direction is.
const TO_ONE: usize = 4;
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
    pub(super) fn of_fits(known: &Known, seed: u64) -> Self {
        Self::new(known, narrow_pairs(COUNT, seed))
    }

    /// Of the points that fits are looked at in afterwards.
    pub(super) fn of_pool(known: &Known, seed: u64) -> Self {
        Self::new(known, close_pairs(POOL, seed.wrapping_add(1 << 32)))
    }

    /// Of many more, where nothing passes the brightest sample.
    pub(super) fn of_ceiling(largest: f64, seed: u64) -> Self {
        let pairs = close_pairs(CEILED, seed.wrapping_add(2 << 32));
        let values = vec![[Some([largest; 3]), None]; pairs.len()];
        Self { values, pairs, floor: FLOOR.max(BRIGHT / largest.max(1e-6)) }
    }

    fn new(known: &Known, pairs: Vec<DirectionPair>) -> Self {
        let of = |pair: &DirectionPair| known.bounds(&Place::of(pair));
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

/// So many pairs close to the mirror direction, and some towards the horizon.
fn close_pairs(count: usize, seed: u64) -> Vec<DirectionPair> {
    let mut pairs = narrow_pairs(count, seed);
    pairs.extend(grazing_pairs(count / TO_ONE, seed));
    pairs
}

#[cfg(test)]
#[path = "bounds_tests.rs"]
mod tests;
