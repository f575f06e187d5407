//! The order in which forms are started, varied and refined: a deterministic sequence of generations.

use std::sync::Arc;

use brood_brdf::{Brdf, Model, ModelKind, TableDetail};
use brood_eval::energy_limit;
use brood_genome::{BirthKey, Genome, Operator, Stream};
use brood_program::Program;
use rayon::prelude::*;

use super::Form;
use super::albedo::{Albedos, Precision};
use super::batch::{Batch, some_of};
use super::climb::{Climb, Plan};
use super::evolve::{Start, evolve};
use super::recover::drawn;
use super::residual::{Bench, Space};
use super::vary::{changed, pushed, second, told};
use crate::{Progress, Samples};

/// Every so many samples one is left out of the fit, to choose by.
const HELD: usize = 7;
/// Samples of the first steps.
const FEW: usize = 384;
/// Samples of all others at most: models have few numbers.
const MANY: usize = 2048;
/// Starts of each kind in the first generation.
const STARTS: u32 = 6;
/// Of which so many are refined on all samples.
const BETTER: usize = 2;
const STEPS: usize = 40;
const LAST_STEPS: usize = 15;
/// Where a fit is held below all light.
const HELD_STEPS: usize = 20;
/// At that level, and at lower ones as long as it reflects more than is good enough.
const ALBEDO: f64 = 0.975;
const ENOUGH: f64 = 0.985;
const HOLDS: usize = 3;
/// Fits that are kept: the best of each form, and of these the best.
const KEPT: usize = 24;
/// Fits that are tried in each later generation.
const TRIED: u32 = 16;
const EVOLVE_GENERATIONS: usize = 80;
/// Every so many generations an evolution strategy goes on from the best.
const EVOLVE: u32 = 4;
/// A fit with so many more numbers has to be better by this share.
const WORTH: f64 = 0.01;

/// A fit of models to samples.
pub struct Analytic {
    pub(super) seed: u64,
    pub(super) kinds: Vec<ModelKind>,
    started: Vec<Genome>,
    few: Batch,
    all: Batch,
    held: Batch,
    whole: Batch,
    albedos: Arc<Albedos>,
    pub(super) generation: u32,
    pub(super) evaluations: u64,
    pub(super) kept: Vec<Kept>,
}

/// A fit that is kept.
#[derive(Debug, Clone)]
pub(super) struct Kept {
    pub(super) space: Space,
    /// Its error is under the energy limit.
    pub(super) climb: Climb,
    /// Mean square on what is held back, under the energy limit.
    pub(super) held: f64,
}

/// A fit that is done.
#[derive(Debug, Clone)]
pub(super) struct Finished {
    pub(super) models: Vec<Model>,
    pub(super) numbers: usize,
    /// Mean squares on what it was fitted to and on what was held back, before it was refined on both.
    pub(super) fitted: f64,
    pub(super) held: f64,
}

impl Finished {
    pub(super) fn of(kept: &Kept) -> Self {
        let Kept { space, climb, held } = kept;
        let (numbers, fitted) = (space.len(), climb.error);
        Self { models: space.models(&climb.x), numbers, fitted, held: *held }
    }
}

/// Those that are reciprocal and have parameters that can be searched: not SGD, of whose 33 numbers most undo each other.
#[must_use]
pub fn usual_kinds() -> Vec<ModelKind> {
    let is_usual = |kind: &ModelKind| {
        *kind != ModelKind::Sgd && Model::new(*kind).prepare().claims().reciprocal
    };
    ModelKind::ALL.into_iter().filter(is_usual).collect()
}

impl Analytic {
    /// Begins one. Everything that comes of it depends on the samples, the kinds, what it starts from and the seed alone.
    #[must_use]
    pub fn new(samples: &Samples, kinds: Vec<ModelKind>, started: &[Genome], seed: u64) -> Self {
        let is_held = |at: &usize| at % HELD == HELD - 1;
        let (held, fitted): (Vec<usize>, Vec<usize>) = (0..samples.len()).partition(is_held);
        let batch = |indices: &[usize], count| {
            Batch::new(samples, &some_of(samples, indices, count)).with_least(samples)
        };
        let all: Vec<usize> = (0..samples.len()).collect();
        Self {
            seed,
            kinds,
            started: started.to_vec(),
            few: batch(&fitted, FEW),
            all: batch(&fitted, MANY),
            held: Batch::new(samples, &held),
            whole: Batch::new(samples, &all).with_least(samples),
            albedos: Arc::new(Albedos::new()),
            generation: 0,
            evaluations: 0,
            kept: Vec::new(),
        }
    }

    /// One generation.
    pub fn step(&mut self) -> Progress {
        if self.generation == 0 {
            self.start()
        } else {
            self.vary()
        }
        self.generation += 1;
        self.progress()
    }

    /// What the last generation came to.
    #[must_use]
    pub fn progress(&self) -> Progress {
        let best = self.kept.first();
        let of = |value: fn(&Kept) -> f64| best.map_or(f64::INFINITY, |kept| value(kept).sqrt());
        Progress {
            generation: self.generation,
            evaluations: self.evaluations,
            fitted: of(|kept| kept.climb.error),
            held: of(|kept| kept.held),
        }
    }

    fn stream(&self, slot: u32) -> Stream {
        Stream::new(
            BirthKey { seed: self.seed, slot, attempt: self.generation },
            Operator::Analytic,
        )
    }

    /// Every kind from several places, and what the search was told to start from.
    fn start(&mut self) {
        let slots: Vec<(u32, ModelKind)> = (0u32..)
            .zip(&self.kinds)
            .flat_map(|(index, kind)| (0..STARTS).map(move |k| (index * STARTS + k, *kind)))
            .collect();
        let begun: Vec<(Space, Climb)> = slots
            .into_par_iter()
            .map_init(Bench::new, |bench, (slot, kind)| {
                let space = Space::new(Form::one(kind));
                let x = match slot % STARTS {
                    0 => space.form.place(&[Model::new(kind)]),
                    _ => drawn(&space, &mut self.stream(slot)),
                };
                let mut climb = Climb::new(x);
                climb.refine(bench, &space, &self.few, Plan::coarse(STEPS));
                (space, climb)
            })
            .collect();
        let told = self.started.iter().filter_map(told).collect::<Vec<_>>();
        let mut better = Vec::new();
        for part in begun.chunks(STARTS as usize) {
            let mut part = part.to_vec();
            part.sort_by(|a, b| a.1.error.total_cmp(&b.1.error));
            self.evaluations += part.iter().map(|(_, climb)| climb.tries).sum::<u64>();
            better.extend(part.into_iter().take(BETTER));
        }
        better.extend(told);
        self.finish_off(better);
    }

    /// Variations of what is kept, and new starts.
    fn vary(&mut self) {
        let Self { kept, kinds, .. } = &*self;
        let Some(best) = kept.first() else { return };
        let tried: Vec<(Space, Climb)> = (0..TRIED)
            .into_par_iter()
            .map_init(Bench::new, |bench, slot| {
                let mut stream = self.stream(slot);
                let count = kept.len() as u32;
                // Better ones more often.
                let parent = &kept[stream.below(count).min(stream.below(count)) as usize];
                let (space, mut climb) = match slot % 8 {
                    // The best first, each generation of one sort.
                    0 if self.generation.is_multiple_of(EVOLVE) => {
                        let climb = self.evolved(bench, best, &mut stream);
                        (best.space.clone(), climb)
                    }
                    0 | 1 => pushed(parent, &mut stream),
                    2 | 3 => match parent.space.form.reworded(&mut stream) {
                        Some(form) => changed(parent, form),
                        None => pushed(parent, &mut stream),
                    },
                    4 | 5 if !kinds.is_empty() => second(parent, kinds, &mut stream)
                        .unwrap_or_else(|| pushed(parent, &mut stream)),
                    6 => match parent.space.form.turned() {
                        Some(form) => changed(parent, form),
                        None => pushed(parent, &mut stream),
                    },
                    _ if !kinds.is_empty() => {
                        let kind = kinds[stream.below(kinds.len() as u32) as usize];
                        let space = Space::new(Form::one(kind));
                        let x = drawn(&space, &mut stream);
                        (space, Climb::new(x))
                    }
                    _ => pushed(parent, &mut stream),
                };
                climb.refine(bench, &space, &self.few, Plan::coarse(STEPS));
                (space, climb)
            })
            .collect();
        self.evaluations += tried.iter().map(|(_, climb)| climb.tries).sum::<u64>();
        self.finish_off(tried);
    }

    /// Where derivatives lead nowhere.
    fn evolved(&self, bench: &mut Bench, from: &Kept, stream: &mut Stream) -> Climb {
        let space = &from.space;
        let bounds: Vec<(f64, f64)> = space.coordinates.iter().map(|c| c.bounds).collect();
        let start = Start {
            x: &from.climb.x,
            bounds: &bounds,
            sigma: 0.1,
            generations: EVOLVE_GENERATIONS,
        };
        let mut tries = 0;
        let (x, _) = evolve(&start, stream, |x| {
            tries += 1;
            bench.error(space, x, &self.few, TableDetail::Coarse) / self.few.total
        });
        Climb { tries, ..Climb::new(x) }
    }

    /// Refines on all samples and keeps what is good.
    fn finish_off(&mut self, found: Vec<(Space, Climb)>) {
        let done: Vec<Kept> = found
            .into_par_iter()
            .map_init(Bench::new, |bench, (space, climb)| {
                let (climb, divisor) =
                    self.refined(bench, (&space, &climb.x), (&self.all, Precision::Near));
                let x = (&climb.x[..], divisor);
                let held = bench.error_divided(&space, x, &self.held, TableDetail::Full);
                Kept { held: held / self.held.total.max(1.0), space, climb }
            })
            .collect();
        for mut kept in done {
            self.evaluations += std::mem::take(&mut kept.climb.tries) + 1;
            if kept.climb.error.is_finite() {
                self.kept.push(kept);
            }
        }
        self.kept.sort_by(|a, b| a.held.total_cmp(&b.held));
        // Of each form the best.
        let mut seen: Vec<Form> = Vec::new();
        self.kept.retain(|kept| {
            let is_new = !seen.contains(&kept.space.form);
            seen.push(kept.space.form.clone());
            is_new
        });
        self.kept.truncate(KEPT);
    }

    /// Steps from a place on these samples, and what the energy limit divides what was found by. Where that is more than 1, steps that
    /// are held below it as well: the better of both is what is closer once it is divided.
    fn refined(
        &self,
        bench: &mut Bench,
        (space, x): (&Space, &[f64]),
        (batch, precision): (&Batch, Precision),
    ) -> (Climb, f64) {
        let mut free = Climb::new(x.to_vec());
        free.refine(bench, space, batch, Plan::full(LAST_STEPS));
        let albedo = self.albedo(bench, space, &free.x, precision);
        if albedo <= 1.0 {
            return (free, 1.0);
        }
        let mut best = free.divided(bench, space, (batch, albedo));
        // Held it is no closer than it was without, and something as short is.
        let is_behind =
            |kept: &Kept| kept.space.len() <= space.len() && kept.climb.error <= free.error;
        if precision == Precision::Near && self.kept.iter().any(is_behind) {
            return (best, albedo);
        }
        let mut held = Climb::new(x.to_vec());
        let mut level = ALBEDO;
        for _ in 0..HOLDS {
            held.refine(bench, space, &batch.below(level, &self.albedos), Plan::full(HELD_STEPS));
            let albedo = bench.albedo(space, &held.x, &self.albedos);
            let divided = held.divided(bench, space, (batch, albedo.max(1.0)));
            if divided.error < best.error {
                best = divided;
            }
            if albedo <= ENOUGH {
                break;
            }
            // What the quadrature of the steps does not see.
            level *= ALBEDO / albedo;
        }
        let divisor = self.albedo(bench, space, &best.x, precision).max(1.0);
        let mut best = best.divided(bench, space, (batch, divisor));
        best.tries = free.tries + held.tries;
        (best, divisor)
    }

    /// What is reflected at most of the light from one direction.
    fn albedo(&self, bench: &mut Bench, space: &Space, x: &[f64], precision: Precision) -> f64 {
        let albedo = bench.albedo(space, x, &self.albedos);
        if !precision.asks(albedo) {
            return albedo;
        }
        let genome = Form::genome(space.models(x)).expect("one or two models are a genome");
        let limit = energy_limit(&Program::lower(&genome));
        if limit.divisor > 1.0 { limit.divisor } else { limit.albedo }
    }

    /// From the one with most numbers to the one with fewest, each better than all with fewer; refined on all samples.
    pub(super) fn front(&self) -> Vec<Finished> {
        let mut order: Vec<&Kept> = self.kept.iter().collect();
        order.sort_by(|a, b| a.space.len().cmp(&b.space.len()).then(a.held.total_cmp(&b.held)));
        let mut front: Vec<&Kept> = Vec::new();
        for kept in order {
            let is_better = front.last().is_none_or(|last| kept.held < (1.0 - WORTH) * last.held);
            if is_better {
                front.push(kept);
            }
        }
        front.reverse();
        let finish = |bench: &mut Bench, kept: &Kept| {
            let place = (&kept.space, &kept.climb.x[..]);
            let (climb, _) = self.refined(bench, place, (&self.whole, Precision::Exact));
            let models = kept.space.models(&climb.x);
            (climb.error, Finished { models, ..Finished::of(kept) })
        };
        let done: Vec<(f64, Finished)> =
            front.into_par_iter().map_init(Bench::new, finish).collect();
        // Under the energy limit as it is in the end some may be no better than shorter ones any more.
        let mut least = f64::INFINITY;
        let mut front: Vec<Finished> = Vec::new();
        for (error, finished) in done.into_iter().rev() {
            if error < least {
                least = error;
                front.push(finished);
            }
        }
        front.reverse();
        front
    }
}

#[cfg(test)]
#[path = "schedule_tests.rs"]
mod tests;
