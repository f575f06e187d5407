//! Fits that are done held below the bounds where they stand out, and below what light there is.

use std::sync::Arc;

use super::albedo::{Albedos, TOLERATED as TOLERATED_ALBEDO};
use super::batch::{Batch, Point};
use super::bounds::Bounds;
use super::damped::Damped;
use super::normal::excesses;
use super::{Lobes, Shape};

/// Of the points that a fit stands out in when it is done so many are held at once, and so often.
const WORST: usize = 256;
const ROUNDS: usize = 5;
const STEPS: usize = 8;
/// When all is done, as many points are held by then that fewer steps leave the samples behind.
const LAST_STEPS: usize = 16;
/// Squared excesses, summed over channels, that are let be: a fifth more in one channel.
pub(super) const TOLERATED: f32 = 2.0 * 0.033;

/// Where a fit that is done is looked at for spikes, and for reflecting more than there is.
pub(super) struct Pool {
    points: Vec<Point>,
    batch: Batch,
    albedos: Arc<Albedos>,
    /// From here on nothing passes the brightest sample by far.
    ceiled: usize,
    /// Each time points are held.
    steps: usize,
}

impl Pool {
    pub(super) fn new(bounds: &Bounds, shape: &Shape) -> Self {
        let points = bounds.above(shape);
        let count = points.len();
        Self::of(points, count, STEPS, Arc::new(Albedos::new(shape)))
    }

    fn of(points: Vec<Point>, ceiled: usize, steps: usize, albedos: Arc<Albedos>) -> Self {
        Self { batch: Batch::new(points.iter()), points, albedos, ceiled, steps }
    }

    /// The same with many more points, where nothing passes the brightest sample by far.
    pub(super) fn ceiled(&self, shape: &Shape, largest: f64, seed: u64) -> Self {
        let mut points = self.points.clone();
        points.extend(Bounds::of_ceiling(largest, seed).above(shape));
        Self::of(points, self.points.len(), LAST_STEPS, self.albedos.clone())
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
            fit.refine(&bounded, self.steps);
        }
        fit.on(batch)
    }
}
