//! Enforcement of bounds and of albedo <= 1 on finished fits.

use brood_genome::lobes::Shape;
use std::sync::Arc;

use super::Lobes;
use super::albedo::{Albedos, TOLERATED_ALBEDO};
use super::batch::Batch;
use super::block::Point;
use super::bounds::Bounds;
use super::normal_equations::excesses;
use super::terms::Terms;
use crate::levenberg_marquardt::Solution;

/// Adds up to `WORST` violating points per round, for up to `ROUNDS` rounds of `STEPS` steps.
const WORST: usize = 256;
const ROUNDS: usize = 5;
const STEPS: usize = 8;
/// Number of steps per round with the ceiling points. They add many bounds, and after fewer steps
/// the error on the samples would be larger than before.
const LAST_STEPS: usize = 16;
/// Tolerated squared excess, summed over channels: 20 % in one channel.
pub(super) const TOLERATED: f32 = 2.0 * 0.033;

/// Points and directions at which a refined fit is checked for spikes and for albedos above 1.
pub(super) struct Pool {
    /// Points with upper bounds only.
    points: Vec<Point>,
    /// The same points in blocks.
    batch: Batch,
    albedos: Arc<Albedos>,
    /// First index of the ceiling points, which are bounded by the largest sample.
    ceiling_start: usize,
    /// Number of steps per round.
    steps: usize,
    terms: Terms,
}

impl Pool {
    pub(super) fn new(bounds: &Bounds, shape: &Shape, terms: Terms) -> Self {
        let points = bounds.above(shape);
        Self {
            batch: Batch::new(points.iter()),
            albedos: Arc::new(Albedos::new(shape)),
            ceiling_start: points.len(),
            steps: STEPS,
            points,
            terms,
        }
    }

    /// Copy with the ceiling points added, unless there are no bounds.
    pub(super) fn with_ceiling(&self, shape: &Shape, largest: f64, seed: u64) -> Self {
        let ceiling = Bounds::of_ceiling(largest, seed);
        let ceiling = if self.terms.bounds { ceiling } else { Bounds::none() };
        let mut points = self.points.clone();
        points.extend(ceiling.above(shape));
        Self {
            batch: Batch::new(points.iter()),
            albedos: self.albedos.clone(),
            ceiling_start: self.points.len(),
            steps: LAST_STEPS,
            points,
            terms: self.terms,
        }
    }

    /// True if an albedo of the fit exceeds `most`, and albedos are limited.
    pub(super) fn exceeds_albedo(&self, lobes: &Lobes, most: f64) -> bool {
        self.terms.albedo && self.albedos.largest(lobes) > most
    }

    /// Quadrature of the albedos.
    pub(super) fn albedos(&self) -> &Arc<Albedos> {
        &self.albedos
    }

    /// True if the fit stays below the ceiling at all ceiling points.
    pub(super) fn is_below(&self, lobes: &Lobes) -> bool {
        let excesses = excesses(lobes, &self.batch);
        excesses[self.ceiling_start..self.points.len()].iter().all(|excess| *excess <= TOLERATED)
    }

    /// Refines the fit on `batch` plus the bounds that it violates, with the albedo penalty where
    /// it exceeds the tolerated albedo, until all bounds and the albedo hold, for up to `ROUNDS`
    /// rounds.
    pub(super) fn enforce(&self, mut fit: Solution<Lobes>, batch: &Batch) -> Solution<Lobes> {
        let mut held = vec![false; self.points.len()];
        let mut has_albedo_penalty = false;
        for _ in 0..ROUNDS {
            let excesses = excesses(&fit.point, &self.batch);
            let mut over: Vec<(usize, f32)> = (0..self.points.len())
                .map(|at| (at, excesses[at]))
                .filter(|(at, excess)| *excess > TOLERATED && !held[*at])
                .collect();
            let is_over = self.exceeds_albedo(&fit.point, TOLERATED_ALBEDO);
            if over.is_empty() && !is_over {
                break;
            }
            has_albedo_penalty |= is_over;
            over.sort_by(|a, b| b.1.total_cmp(&a.1).then(a.0.cmp(&b.0)));
            for (at, _) in over.iter().take(WORST) {
                held[*at] = true;
            }
            let points = self.points.iter().zip(&held).filter(|(_, held)| **held);
            let bounded = batch.with(points.map(|(point, _)| point));
            let bounded = if has_albedo_penalty {
                bounded.with_albedo_penalty(&self.albedos)
            } else {
                bounded
            };
            fit = fit.on(&bounded);
            fit.refine(&bounded, self.steps);
        }
        fit.on(batch)
    }
}
