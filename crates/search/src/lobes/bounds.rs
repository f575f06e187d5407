//! Bounds on fits in regions with few samples: close to the mirror direction and at grazing angles.
//! They are one-sided samples at random pairs of directions there, with values from
//! [`BoundEstimator`].
//!
//! Without them, a fit that agrees with every sample may reach 1e35 beyond 80 degrees.

use brood_brdf::DirectionPair;
use brood_genome::lobes::Shape;
use brood_target::{Samples, grazing_pairs, narrow_pairs};
use rayon::prelude::*;

use super::block::{Point, points};
use super::known::{BoundEstimator, Place};

/// Number of points at which every fit is bounded, from above and below.
const COUNT: usize = 1024;
/// Number of points at which a refined fit is checked.
const POOL: usize = 4096;
/// Number of points at which the fits of the front are bounded by the largest sample.
const CEILING: usize = 1 << 16;
/// There is one grazing point for this many points close to the mirror direction.
const CLOSE_PER_GRAZING: usize = 4;
/// Weight of a squared excess in the check of refined fits.
const IMPORTANCE_ABOVE: f64 = 2.0;
/// Bound of this check, as a multiple of the bound during the fit.
const CHECK_MARGIN: f64 = 1.4;
/// Weight of a squared excess during the fit, relative to the squared difference of a sample.
const IMPORTANCE: f64 = 0.2;
/// Least factor of f at a bound. With cos_i itself, which tends to 0 towards the horizon, ln(1 + f
/// cos_i) would hardly show an excess there.
const FLOOR: f64 = 0.17;
/// Least product of that factor and the largest sample at ceiling points: ln(1 + f cos_i) shows by
/// which ratio the ceiling is exceeded only if f cos_i is far above 1.
const BRIGHT: f64 = 10.0;

/// Pairs of directions in regions with few samples, with their bounds.
pub(super) struct Bounds {
    pairs: Vec<DirectionPair>,
    /// Upper and lower bound of each pair.
    values: Vec<[Option<[f64; 3]>; 2]>,
    /// Least factor of f at each pair; cos_i if that is larger.
    floor: f64,
}

impl Bounds {
    /// Upper and lower bounds during every fit.
    pub(super) fn of_fits(known: &BoundEstimator, seed: u64) -> Self {
        Self::new(known, narrow_pairs(COUNT, seed))
    }

    /// Bounds at the points where refined fits are checked: other points than those of
    /// [`Bounds::of_fits`].
    pub(super) fn of_pool(known: &BoundEstimator, seed: u64) -> Self {
        Self::new(known, close_pairs(POOL, seed.wrapping_add(1 << 32)))
    }

    /// No bounds.
    pub(super) fn none() -> Self {
        Self { pairs: Vec::new(), values: Vec::new(), floor: FLOOR }
    }

    /// Ceiling: many more points, bounded by the largest sample.
    pub(super) fn of_ceiling(largest: f64, seed: u64) -> Self {
        let pairs = close_pairs(CEILING, seed.wrapping_add(2 << 32));
        let values = vec![[Some([largest; 3]), None]; pairs.len()];
        Self { values, pairs, floor: FLOOR.max(BRIGHT / largest.max(1e-6)) }
    }

    fn new(known: &BoundEstimator, pairs: Vec<DirectionPair>) -> Self {
        let of = |pair: &DirectionPair| known.bounds(&Place::of(pair));
        Self { values: pairs.par_iter().map(of).collect(), pairs, floor: FLOOR }
    }

    /// The points with the inputs of a shape, bounded from both sides.
    pub(super) fn points(&self, shape: &Shape) -> Vec<Point> {
        self.with(shape, IMPORTANCE, |[above, below]| [above, below])
    }

    /// The points with the inputs of a shape, bounded from above by [`CHECK_MARGIN`] times the
    /// bound.
    pub(super) fn above(&self, shape: &Shape) -> Vec<Point> {
        self.with(shape, IMPORTANCE_ABOVE, |[above, _]| {
            [above.map(|bound| bound.map(|f| CHECK_MARGIN * f)), None]
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
                target: bound.map(|f| libm::log1p(f * weight) as f32),
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

/// Returns `count` pairs close to the mirror direction, and some grazing ones.
fn close_pairs(count: usize, seed: u64) -> Vec<DirectionPair> {
    let mut pairs = narrow_pairs(count, seed);
    pairs.extend(grazing_pairs(count / CLOSE_PER_GRAZING, seed));
    pairs
}

#[cfg(test)]
#[path = "bounds_tests.rs"]
mod tests;
