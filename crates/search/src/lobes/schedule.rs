//! Schedule of a fit of lobes: a deterministic sequence of generations, each of which makes new
//! starts or perturbs kept fits. The caller decides how many there are.

use std::mem::take;

use brood_genome::lobes::Shape;
use brood_genome::{BirthKey, Operator, Stream};
use brood_target::Samples;
use rayon::prelude::*;

use super::Lobes;
use super::albedo::TOLERATED_ALBEDO;
use super::batch::Batch;
use super::block::{Point, lower_bounds, points_with_expected};
use super::bounds::Bounds;
use super::guard::Pool;
use super::known::BoundEstimator;
use super::normal_equations::{e_log, error};
use super::seed::start;
use super::terms::Terms;
use crate::levenberg_marquardt::Solution;
use crate::method::is_held_back;
use crate::{Probe, Progress};

/// Number of starts in a generation of starts.
const STARTS: usize = 16;
/// Number of these that are refined further, and number of those that are refined on all training
/// samples.
const BETTER: usize = 4;
const BEST: usize = 2;
/// Steps of all starts, of the better ones, and of the best ones.
const STEPS: [usize; 3] = [15, 40, 40];
/// Number of fits that are kept and perturbed.
const KEPT: usize = 8;
/// Every fourth generation makes new starts.
const RESTART_INTERVAL: usize = 4;
/// Number of perturbed fits in a generation, and number of steps of each.
const PERTURBED: usize = 8;
const PERTURBED_STEPS: usize = 30;
/// Ridge cost of weights, relative to the error of the best fit of the first generation. Negligible
/// except where no sample determines a weight.
const RIDGE: f64 = 2e-3;

/// A fit of lobes to samples.
pub struct Fit {
    pub(super) seed: u64,
    pub(super) shapes: Vec<Problem>,
    pub(super) generation: u32,
    pub(super) evaluations: u64,
    /// Ridge cost, as [`Batch::cost`]; 0 in the first generation.
    pub(super) cost: f64,
    /// The best fits so far, of any shape, the best first.
    pub(super) kept: Vec<Kept>,
    /// Largest value of any sample or lower bound.
    pub(super) largest: f64,
    /// True if `all` and `whole` of each problem have the albedo penalty, because a fit of the
    /// first generation exceeded the tolerated albedo.
    pub(super) has_albedo_penalty: bool,
}

/// The fitting problem of one shape.
pub(super) struct Problem {
    pub(super) shape: Shape,
    /// All samples, training and validation.
    pub(super) points: Vec<Point>,
    /// Every fourth training sample, expected value and bound, for the first steps of starts.
    pub(super) part: Batch,
    /// Training samples, expected values and bounds.
    pub(super) all: Batch,
    /// Validation samples.
    pub(super) held: Batch,
    /// Training and validation samples, expected values and bounds.
    pub(super) whole: Batch,
    /// Points at which refined fits are checked.
    pub(super) pool: Pool,
}

/// A fit that is kept between generations.
#[derive(Debug, Clone)]
pub(super) struct Kept {
    /// Index in [`Fit::shapes`].
    pub(super) problem: usize,
    /// Solution; its error is the objective on [`Problem::all`].
    pub(super) fit: Solution<Lobes>,
    /// Mean weighted squared difference on the validation samples.
    pub(super) held: f64,
}

impl Problem {
    pub(super) fn new(samples: &Samples, shape: Shape, bounds: &[Bounds; 2], terms: Terms) -> Self {
        let (mut points, mut expected) = points_with_expected(samples, &shape);
        if !terms.dark {
            points.iter_mut().chain(&mut expected).for_each(|point| point.share = 0.0);
        }
        let of = |keep: bool| {
            let indices = (0..points.len()).filter(move |at| is_held_back(*at) != keep);
            indices.map(|at| &points[at]).collect::<Vec<_>>()
        };
        let (fitted, held) = (of(true), Batch::new(of(false).into_iter()));
        let (mut guard, pool) = (bounds[0].points(&shape), Pool::new(&bounds[1], &shape, terms));
        guard.extend(lower_bounds(samples, &shape));
        let part: Vec<&Point> = fitted
            .iter()
            .copied()
            .chain(&expected)
            .step_by(4)
            .chain(guard.iter().step_by(4))
            .collect();
        let part = Batch::new(part.into_iter()).with_ridge(&shape, &points);
        let all: Vec<&Point> = fitted.iter().copied().chain(&expected).chain(&guard).collect();
        let all = Batch::new(all.into_iter()).with_ridge(&shape, &points);
        let whole: Vec<&Point> = points.iter().chain(&expected).chain(&guard).collect();
        let whole = Batch::new(whole.into_iter()).with_ridge(&shape, &points);
        Self { shape, points, part, all, held, whole, pool }
    }
}

impl Fit {
    /// Creates a fit at generation 0. Its results depend only on the samples, the shapes, the terms
    /// and the seed.
    #[must_use]
    pub fn new(samples: &Samples, shapes: Vec<Shape>, terms: Terms, seed: u64) -> Self {
        let bounds = if terms.bounds {
            let known = BoundEstimator::new(samples);
            [Bounds::of_fits(&known, seed), Bounds::of_pool(&known, seed)]
        } else {
            [Bounds::none(), Bounds::none()]
        };
        let of = |shape| Problem::new(samples, shape, &bounds, terms);
        let shapes: Vec<Problem> = shapes.into_par_iter().map(of).collect();
        let below = samples.lower_bounds().iter().flat_map(|bound| bound.f);
        let expected = samples.expected().iter().flat_map(|(_, f)| *f);
        let largest = below.chain(expected).fold(samples.largest(), f64::max);
        let (kept, has_albedo_penalty) = (Vec::new(), false);
        Self {
            seed,
            shapes,
            generation: 0,
            evaluations: 0,
            cost: 0.0,
            kept,
            largest,
            has_albedo_penalty,
        }
    }

    /// Runs one generation.
    pub fn step(&mut self) -> Progress {
        let generation = self.generation as usize;
        let count = self.shapes.len();
        // The first generations start each shape once, later restarts take turns.
        let again = generation / RESTART_INTERVAL;
        if generation < count {
            self.start(generation);
        } else if generation.is_multiple_of(RESTART_INTERVAL) {
            self.start(again % count);
        } else {
            self.perturb();
        }
        self.generation += 1;
        if self.generation == 1 {
            self.add_penalties();
        }
        self.progress()
    }

    /// Best fit so far.
    #[must_use]
    pub fn best(&self) -> Option<&Lobes> {
        self.kept.first().map(|kept| &kept.fit.point)
    }

    pub(super) fn progress(&self) -> Progress {
        let of = |batch: fn(&Problem) -> &Batch| {
            let best = self.kept.first();
            let e_log = |kept: &Kept| e_log(&kept.fit.point, batch(&self.shapes[kept.problem]));
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
            let error = e_log(&kept.fit.point, &self.shapes[kept.problem].all);
            (error, (kept.problem, kept.fit.point.free.clone()))
        };
        Probe::of(self.kept.iter().map(of), 0)
    }

    fn stream(&self, slot: usize) -> Stream {
        let slot = u32::try_from(slot).expect("there are few slots");
        Stream::new(BirthKey { seed: self.seed, slot, attempt: self.generation }, Operator::Lobes)
    }

    /// Turns on the ridge cost, and the albedo penalty if a fit exceeds the tolerated albedo.
    /// Refits and re-ranks the kept fits.
    fn add_penalties(&mut self) {
        let Some(best) = self.kept.first() else { return };
        self.set_cost(RIDGE * best.fit.error);
        for kept in &mut self.kept {
            let Problem { all, pool, .. } = &self.shapes[kept.problem];
            kept.fit = kept.fit.clone().on(all);
            kept.fit.refine(all, STEPS[2]);
            self.has_albedo_penalty |= pool.exceeds_albedo(&kept.fit.point, TOLERATED_ALBEDO);
            kept.fit = pool.enforce(kept.fit.clone(), all);
            kept.held = error(&kept.fit.point, &self.shapes[kept.problem].held);
            self.evaluations += take(&mut kept.fit.evaluations);
        }
        if self.has_albedo_penalty {
            self.add_albedo_penalty();
            for kept in &mut self.kept {
                kept.fit = kept.fit.clone().on(&self.shapes[kept.problem].all);
            }
        }
        self.sort();
    }

    pub(super) fn add_albedo_penalty(&mut self) {
        self.has_albedo_penalty = true;
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

    /// Generation of starts of one shape.
    fn start(&mut self, problem: usize) {
        let Problem { shape, points, part, all, pool, .. } = &self.shapes[problem];
        let mut fits: Vec<Solution<Lobes>> = (0..STARTS)
            .into_par_iter()
            .map(|slot| {
                let lobes = start(shape, points, &mut self.stream(slot));
                let mut fit = Solution::of(lobes, part);
                fit.refine(part, STEPS[0]);
                fit
            })
            .collect();
        fits.sort_by(|a, b| a.error.total_cmp(&b.error));
        self.evaluations += fits.iter_mut().map(|fit| take(&mut fit.evaluations)).sum::<u64>();
        fits.truncate(BETTER);
        fits.par_iter_mut().for_each(|fit| fit.refine(part, STEPS[1]));
        fits.sort_by(|a, b| a.error.total_cmp(&b.error));
        self.evaluations += fits.iter_mut().map(|fit| take(&mut fit.evaluations)).sum::<u64>();
        fits.truncate(BEST);
        let found: Vec<Solution<Lobes>> = fits
            .into_par_iter()
            .map(|fit| {
                let mut fit = fit.on(all);
                fit.refine(all, STEPS[2]);
                pool.enforce(fit, all)
            })
            .collect();
        self.keep(problem, found);
    }

    /// Generation of perturbations: parents are kept fits, better ones more often.
    fn perturb(&mut self) {
        let chosen: Vec<(usize, usize)> = (0..PERTURBED)
            .map(|slot| {
                let mut stream = self.stream(slot);
                let first =
                    stream.below(self.kept.len() as u32).min(stream.below(self.kept.len() as u32));
                (slot, first as usize)
            })
            .collect();
        let found: Vec<(usize, Solution<Lobes>)> = chosen
            .into_par_iter()
            .map(|(slot, parent)| {
                let mut stream = self.stream(1000 + slot);
                let kept = &self.kept[parent];
                let Problem { all, pool, .. } = &self.shapes[kept.problem];
                let lobes = perturbed(&kept.fit.point, &mut stream);
                let mut fit = Solution::of(lobes, all);
                fit.refine(all, PERTURBED_STEPS);
                (kept.problem, pool.enforce(fit, all))
            })
            .collect();
        for (problem, fit) in found {
            self.keep(problem, vec![fit]);
        }
    }

    /// Adds the found fits of a shape, and keeps the best [`KEPT`] fits.
    fn keep(&mut self, problem: usize, found: Vec<Solution<Lobes>>) {
        for mut fit in found {
            self.evaluations += take(&mut fit.evaluations);
            let held = error(&fit.point, &self.shapes[problem].held);
            self.kept.push(Kept { problem, fit, held });
        }
        self.sort();
        self.kept.truncate(KEPT);
    }

    /// Sorts the kept fits, the best first.
    fn sort(&mut self) {
        self.kept.sort_by(|a, b| (a.held + a.fit.error).total_cmp(&(b.held + b.fit.error)));
    }
}

/// Copy with one to eight parameters perturbed.
fn perturbed(lobes: &Lobes, stream: &mut Stream) -> Lobes {
    let mut next = lobes.clone();
    let free: Vec<usize> = (0..lobes.parameters.len()).filter(|at| lobes.free[*at]).collect();
    for _ in 0..=stream.below(8) {
        let at = free[stream.below(free.len() as u32) as usize];
        let parameter = &mut next.parameters[at];
        *parameter += f64::from(stream.bell()) * (0.3 + 0.5 * parameter.abs());
    }
    next
}

#[cfg(test)]
#[path = "schedule_tests.rs"]
mod tests;
