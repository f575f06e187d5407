//! The order in which starts are tried, refined and perturbed: a deterministic sequence of generations, of which a budget
//! decides how many there are.

use std::mem::take;

use brood_genome::{BirthKey, Operator, Stream};
use rayon::prelude::*;

use super::albedo::TOLERATED;
use super::batch::{Batch, Point, least, points};
use super::bounds::Bounds;
use super::damped::Damped;
use super::guard::Pool;
use super::known::Known;
use super::normal::{e_log, error};
use super::seed::start;
use super::{Lobes, Shape};
use crate::{Probe, Progress, Samples};

/// Starts of a generation of starts.
const STARTS: usize = 16;
/// Of which this many are refined, and then this many on all samples.
const BETTER: usize = 4;
const BEST: usize = 2;
/// Steps of each of these.
const STEPS: [usize; 3] = [15, 40, 40];
/// Fits that are kept and perturbed.
const KEPT: usize = 8;
/// One in so many generations starts again.
const AGAIN: usize = 4;
/// Perturbed fits of a generation, and their steps.
const PERTURBED: usize = 8;
const PERTURBED_STEPS: usize = 30;
/// What squares of weights cost, in mean squared differences of the best fit of the first generation: next to nothing, but where no
/// sample says anything.
const RIDGE: f64 = 2e-3;
/// Every so many samples one is left out of the fit, to choose by.
const HELD: usize = 7;

/// A fit of lobes to samples.
pub struct Fit {
    pub(super) seed: u64,
    pub(super) shapes: Vec<Problem>,
    pub(super) generation: u32,
    pub(super) evaluations: u64,
    /// What weights cost, in mean squared differences.
    pub(super) cost: f64,
    pub(super) kept: Vec<Kept>,
    /// Of all samples, and of what f is known not to be below.
    pub(super) largest: f64,
    /// Whether reflecting more than there is costs something from the first step on all samples on: it did before.
    pub(super) is_under: bool,
}

/// The samples as one shape reads them.
pub(super) struct Problem {
    pub(super) shape: Shape,
    points: Vec<Point>,
    part: Batch,
    pub(super) all: Batch,
    pub(super) held: Batch,
    pub(super) whole: Batch,
    pub(super) pool: Pool,
}

#[derive(Debug, Clone)]
pub(super) struct Kept {
    pub(super) problem: usize,
    pub(super) damped: Damped,
    pub(super) held: f64,
}

impl Problem {
    fn new(samples: &Samples, shape: Shape, bounds: &[Bounds; 2]) -> Self {
        let points = points(samples, &shape);
        let is_held = |at: &usize| at % HELD == HELD - 1;
        let of = |keep: bool| {
            let indices = (0..points.len()).filter(move |at| is_held(at) != keep);
            indices.map(|at| &points[at]).collect::<Vec<_>>()
        };
        let (fitted, held) = (of(true), Batch::new(of(false).into_iter()));
        let (mut guard, pool) = (bounds[0].points(&shape), Pool::new(&bounds[1], &shape));
        guard.extend(least(samples, &shape));
        let part: Vec<&Point> =
            fitted.iter().copied().step_by(4).chain(guard.iter().step_by(4)).collect();
        let part = Batch::new(part.into_iter()).with_ridge(&shape, &points);
        let all: Vec<&Point> = fitted.iter().copied().chain(&guard).collect();
        let all = Batch::new(all.into_iter()).with_ridge(&shape, &points);
        let whole: Vec<&Point> = points.iter().chain(&guard).collect();
        let whole = Batch::new(whole.into_iter()).with_ridge(&shape, &points);
        Self { shape, points, part, all, held, whole, pool }
    }
}

impl Fit {
    /// Begins one. Everything that comes of it depends on the samples, the shapes and the seed alone.
    #[must_use]
    pub fn new(samples: &Samples, shapes: Vec<Shape>, seed: u64) -> Self {
        let known = Known::new(samples);
        let bounds = [Bounds::of_fits(&known, seed), Bounds::of_pool(&known, seed)];
        let shapes: Vec<Problem> =
            shapes.into_par_iter().map(|shape| Problem::new(samples, shape, &bounds)).collect();
        let below = samples.least().iter().flat_map(|(_, least)| least).copied();
        let largest = below.fold(samples.largest(), f64::max);
        let (kept, is_under) = (Vec::new(), false);
        Self { seed, shapes, generation: 0, evaluations: 0, cost: 0.0, kept, largest, is_under }
    }

    /// One generation.
    pub fn step(&mut self) -> Progress {
        let generation = self.generation as usize;
        let count = self.shapes.len();
        // Each shape is started once, later one again now and then.
        let again = generation / AGAIN;
        if generation < count {
            self.start(generation);
        } else if generation.is_multiple_of(AGAIN) {
            self.start(again % count);
        } else {
            self.perturb();
        }
        self.generation += 1;
        if self.generation == 1 {
            self.weigh();
        }
        self.progress()
    }

    /// The best so far.
    #[must_use]
    pub fn best(&self) -> Option<&Lobes> {
        self.kept.first().map(|kept| &kept.damped.lobes)
    }

    pub(super) fn progress(&self) -> Progress {
        let of = |batch: fn(&Problem) -> &Batch| {
            let best = self.kept.first();
            let e_log = |kept: &Kept| e_log(&kept.damped.lobes, batch(&self.shapes[kept.problem]));
            best.map_or(f64::INFINITY, e_log)
        };
        Progress {
            generation: self.generation,
            evaluations: self.evaluations,
            fitted: of(|problem| &problem.all),
            held: of(|problem| &problem.held),
        }
    }

    pub(super) fn probe(&self) -> Probe {
        let of = |kept: &Kept| {
            let error = e_log(&kept.damped.lobes, &self.shapes[kept.problem].all);
            (error, (kept.problem, kept.damped.lobes.free.clone()))
        };
        Probe::of(self.kept.iter().map(of), 0)
    }

    fn stream(&self, slot: usize) -> Stream {
        let slot = u32::try_from(slot).expect("there are few slots");
        Stream::new(BirthKey { seed: self.seed, slot, attempt: self.generation }, Operator::Lobes)
    }

    /// From now on weights cost something, and what is reflected beyond all light where there was some. What has been found is
    /// weighed anew.
    fn weigh(&mut self) {
        let Some(best) = self.kept.first() else { return };
        self.set_cost(RIDGE * best.damped.error);
        for kept in &mut self.kept {
            let Problem { all, pool, .. } = &self.shapes[kept.problem];
            kept.damped = kept.damped.clone().on(all);
            kept.damped.refine(all, STEPS[2]);
            self.is_under |= pool.albedos().largest(&kept.damped.lobes) > TOLERATED;
            kept.damped = pool.hold(kept.damped.clone(), all);
            kept.held = error(&kept.damped.lobes, &self.shapes[kept.problem].held);
            self.evaluations += take(&mut kept.damped.tries);
        }
        if self.is_under {
            self.set_under();
            for kept in &mut self.kept {
                kept.damped = kept.damped.clone().on(&self.shapes[kept.problem].all);
            }
        }
        self.sort();
    }

    pub(super) fn set_under(&mut self) {
        self.is_under = true;
        for problem in &mut self.shapes {
            for batch in [&mut problem.all, &mut problem.whole] {
                batch.albedos = Some(problem.pool.albedos().clone());
            }
        }
    }

    pub(super) fn set_cost(&mut self, cost: f64) {
        self.cost = cost;
        for problem in &mut self.shapes {
            for batch in [&mut problem.part, &mut problem.all, &mut problem.whole] {
                batch.cost = cost;
            }
        }
    }

    fn start(&mut self, problem: usize) {
        let Problem { shape, points, part, all, pool, .. } = &self.shapes[problem];
        let mut fits: Vec<Damped> = (0..STARTS)
            .into_par_iter()
            .map(|slot| {
                let lobes = start(shape, points, &mut self.stream(slot));
                let mut fit = Damped::new(lobes, part);
                fit.refine(part, STEPS[0]);
                fit
            })
            .collect();
        fits.sort_by(|a, b| a.error.total_cmp(&b.error));
        self.evaluations += fits.iter_mut().map(|fit| take(&mut fit.tries)).sum::<u64>();
        fits.truncate(BETTER);
        fits.par_iter_mut().for_each(|fit| fit.refine(part, STEPS[1]));
        fits.sort_by(|a, b| a.error.total_cmp(&b.error));
        self.evaluations += fits.iter_mut().map(|fit| take(&mut fit.tries)).sum::<u64>();
        fits.truncate(BEST);
        let found: Vec<Damped> = fits
            .into_par_iter()
            .map(|fit| {
                let mut fit = fit.on(all);
                fit.refine(all, STEPS[2]);
                pool.hold(fit, all)
            })
            .collect();
        self.keep(problem, found);
    }

    fn perturb(&mut self) {
        let chosen: Vec<(usize, usize)> = (0..PERTURBED)
            .map(|slot| {
                let mut stream = self.stream(slot);
                let first =
                    stream.below(self.kept.len() as u32).min(stream.below(self.kept.len() as u32));
                (slot, first as usize)
            })
            .collect();
        let found: Vec<(usize, Damped)> = chosen
            .into_par_iter()
            .map(|(slot, parent)| {
                let mut stream = self.stream(1000 + slot);
                let kept = &self.kept[parent];
                let Problem { all, pool, .. } = &self.shapes[kept.problem];
                let lobes = perturbed(&kept.damped.lobes, &mut stream);
                let mut fit = Damped::new(lobes, all);
                fit.refine(all, PERTURBED_STEPS);
                (kept.problem, pool.hold(fit, all))
            })
            .collect();
        for (problem, fit) in found {
            self.keep(problem, vec![fit]);
        }
    }

    fn keep(&mut self, problem: usize, found: Vec<Damped>) {
        for mut damped in found {
            self.evaluations += take(&mut damped.tries);
            let held = error(&damped.lobes, &self.shapes[problem].held);
            self.kept.push(Kept { problem, damped, held });
        }
        self.sort();
        self.kept.truncate(KEPT);
    }

    /// The best first.
    fn sort(&mut self) {
        self.kept.sort_by(|a, b| (a.held + a.damped.error).total_cmp(&(b.held + b.damped.error)));
    }
}

/// One to eight numbers pushed.
fn perturbed(lobes: &Lobes, stream: &mut Stream) -> Lobes {
    let mut next = lobes.clone();
    let free: Vec<usize> = (0..lobes.numbers.len()).filter(|at| lobes.free[*at]).collect();
    for _ in 0..=stream.below(8) {
        let at = free[stream.below(free.len() as u32) as usize];
        let number = &mut next.numbers[at];
        *number += f64::from(stream.bell()) * (0.3 + 0.5 * number.abs());
    }
    next
}

#[cfg(test)]
#[path = "schedule_tests.rs"]
mod tests;
