//! Schedule of an analytic fit: which forms are started, varied and refined in which generation.
//! Results depend only on samples, kinds, given genomes and seed.

use std::sync::Arc;

use brood_brdf::{Brdf, Model, ModelKind, TableDetail};
use brood_eval::energy_limit;
use brood_genome::{BirthKey, Genome, Operator, Stream};
use brood_program::Program;
use brood_target::Samples;
use rayon::prelude::*;

use super::Form;
use super::albedo::{Albedos, Precision};
use super::batch::{Batch, pick_means, pick_samples};
use super::evolve::{Start, evolve};
use super::kept::{Finished, Kept};
use super::prior::PriorMaterials;
use super::recover::random_point;
use super::refine::Plan;
use super::residual::{Space, Workspace};
use super::vary::{from_genome, in_form, perturbed, with_one_model, with_second_model};
use crate::Progress;
use crate::levenberg_marquardt::Solution;
use crate::method::is_held_back;

/// Difference of ln(1 + f cos_i) from which pixels of pictures count less than its square: light
/// from other parts of the object, shadows and masks that are off by a pixel, and lamps that are
/// not where they are said to be make few large differences.
const LARGE: f64 = 0.03;
/// Number of samples of the first steps.
const FEW: usize = 384;
/// Largest number of samples of the later steps; models have few parameters.
const MANY: usize = 2048;
/// Number of pairs of directions that means of the first and the later steps refer to, at most.
const FEW_PAIRS: usize = 4096;
const MANY_PAIRS: usize = 1 << 14;
/// Number of starts of each kind in the first generation.
const STARTS: u32 = 7;
/// Starts below this number are drawn from the prior, except the first, which has the model's
/// defaults. The others are uniform.
const FAMILIAR: u32 = 4;
/// Number of these that are refined on the samples of the later steps.
const BETTER: usize = 2;
/// Number of first steps, in parts, and of later ones.
const STEPS: [usize; 3] = [12, 12, 16];
const LAST_STEPS: usize = 15;
/// Refinements with the prior.
const PROBABLE: u32 = 3;
/// Number of steps of an albedo-constrained refinement.
const CONSTRAINED_STEPS: usize = 20;
/// First albedo level of the constraint. It is lowered, up to `CONSTRAINED_ROUNDS` times, while the
/// albedo is above `ALBEDO_REACHED`.
const ALBEDO_LEVEL: f64 = 0.975;
const ALBEDO_REACHED: f64 = 0.985;
const CONSTRAINED_ROUNDS: usize = 3;
/// Number of fits kept, at most one of each form.
const KEPT: usize = 24;
/// Number of fits tried in each later generation.
const TRIED: u32 = 16;
const EVOLVE_GENERATIONS: usize = 80;
/// Every fourth generation, the evolution strategy refines the best fit.
const EVOLVE: u32 = 4;
/// Number of independent observations that the samples count as. It is below the number of samples,
/// because neighbouring pixels have the same errors of model, light and camera.
pub(crate) const INDEPENDENT: f64 = 400.0;
/// Error below which fits are equally good, as a share of the root mean square of ln(1 + f cos_i):
/// renderers differ by as much.
pub(crate) const EQUAL: f64 = 1e-2;
/// The front has a fit with more parameters only if its mean square on the validation samples is
/// smaller by this share.
const MIN_GAIN: f64 = 0.01;

/// A fit of models to samples.
pub struct Analytic {
    pub(super) seed: u64,
    pub(super) kinds: Vec<ModelKind>,
    given: Vec<Genome>,
    /// [`FEW`] and [`MANY`] of the training samples.
    pub(super) few: Batch,
    all: Batch,
    /// Validation samples.
    held: Batch,
    /// Training and validation samples.
    whole: Batch,
    albedos: Arc<Albedos>,
    pub(super) prior: Arc<PriorMaterials>,
    pub(super) generation: u32,
    pub(super) evaluations: u64,
    /// Mean square below which fits are equally good.
    pub(super) equal: f64,
    /// True if only isotropic models can be compared with the samples.
    is_isotropic: bool,
    /// The best fits so far, the most probable first.
    pub(super) kept: Vec<Kept>,
}

/// Kinds that are reciprocal and can be searched. Excludes SGD, whose 33 parameters largely cancel
/// each other.
#[must_use]
pub fn default_kinds() -> Vec<ModelKind> {
    let is_searchable = |kind: &ModelKind| {
        *kind != ModelKind::Sgd && Model::new(*kind).prepare().claims().reciprocal
    };
    ModelKind::ALL.into_iter().filter(is_searchable).collect()
}

impl Analytic {
    /// Creates a fit at generation 0. Its results depend only on the samples, the kinds, the given
    /// genomes and the seed.
    #[must_use]
    pub fn new(samples: &Samples, kinds: Vec<ModelKind>, given: &[Genome], seed: u64) -> Self {
        let means = samples.means();
        let split = |count: usize| -> (Vec<usize>, Vec<usize>) {
            (0..count).partition(|at| is_held_back(*at))
        };
        let ((held, fitted), (held_means, fitted_means)) =
            (split(samples.len()), split(means.len()));
        let batch = |count, pairs| {
            Batch::new(samples, &pick_samples(samples, &fitted, count))
                .with_lower_bounds(samples)
                .with_means(pick_means(means, &fitted_means, (count, pairs)))
        };
        let large = if samples.are_of_pictures() { LARGE } else { f64::INFINITY };
        let is_sample = |at: &usize| means.values()[*at].is_sample();
        let all: Vec<usize> = (0..samples.len()).collect();
        let observed = samples.observed();
        let logs = observed.as_flattened().iter().map(|f| libm::log1p(f.max(0.0)));
        let equal = EQUAL * EQUAL * logs.map(|log| log * log).sum::<f64>();
        let equal = equal / (3 * observed.len().max(1)) as f64;
        Self {
            seed,
            kinds,
            given: given.to_vec(),
            few: batch(FEW, FEW_PAIRS),
            all: batch(MANY, MANY_PAIRS).with_large(large),
            held: Batch::new(samples, &held)
                .with_means(means.select(held_means.into_iter().filter(is_sample)))
                .with_large(large),
            whole: Batch::new(samples, &all)
                .with_lower_bounds(samples)
                .with_means(means.clone())
                .with_large(large),
            is_isotropic: means.is_isotropic(),
            albedos: Arc::new(Albedos::new()),
            prior: Arc::default(),
            generation: 0,
            evaluations: 0,
            equal,
            kept: Vec::new(),
        }
    }

    /// The same with a prior by these materials.
    #[must_use]
    pub fn with_prior(self, materials: PriorMaterials) -> Self {
        Self { prior: Arc::new(materials), ..self }
    }

    /// Runs one generation.
    pub fn step(&mut self) -> Progress {
        if self.generation == 0 {
            self.start()
        } else {
            self.vary()
        }
        self.generation += 1;
        self.progress()
    }

    /// Result of the last generation.
    #[must_use]
    pub fn progress(&self) -> Progress {
        let best = self.kept.first();
        let of = |value: fn(&Kept) -> f64| best.map_or(f64::INFINITY, |kept| value(kept).sqrt());
        Progress {
            generation: self.generation,
            evaluations: self.evaluations,
            fitted: of(|kept| kept.squares[0]),
            held: of(|kept| kept.squares[1]),
        }
    }

    /// The most probable fits, at most `count`, with their parameters.
    pub(crate) fn best_points(&self, count: usize) -> Vec<(Space, Vec<f64>)> {
        let best = self.kept.iter().take(count);
        best.map(|kept| (kept.space.clone(), kept.fit.point.clone())).collect()
    }

    fn stream(&self, slot: u32) -> Stream {
        Stream::new(
            BirthKey { seed: self.seed, slot, attempt: self.generation },
            Operator::Analytic,
        )
    }

    /// First generation: every kind from several starts, and the given genomes.
    fn start(&mut self) {
        let slots: Vec<(u32, ModelKind)> = (0u32..)
            .zip(&self.kinds)
            .flat_map(|(index, kind)| (0..STARTS).map(move |k| (index * STARTS + k, *kind)))
            .collect();
        let started: Vec<(Space, Solution<Vec<f64>>, f64)> = slots
            .into_par_iter()
            .map_init(Workspace::new, |workspace, (slot, kind)| {
                let space = Space::new(Form::one(kind), &self.prior);
                let stream = &mut self.stream(slot);
                let x = match slot % STARTS {
                    0 => space.form.place(&[Model::new(kind)]),
                    k if k < FAMILIAR => space.drawn(stream),
                    _ => random_point(&space, stream),
                };
                let (fit, score) = self.coarse(workspace, &space, Solution::new(x));
                (space, fit, score)
            })
            .collect();
        let is_comparable =
            |(space, _): &(Space, _)| !(self.is_isotropic && space.form.is_anisotropic());
        let given = self
            .given
            .iter()
            .filter_map(|given| from_genome(given, &self.prior))
            .filter(is_comparable);
        let given = given.collect::<Vec<_>>();
        let mut better = Vec::new();
        for part in started.chunks(STARTS as usize) {
            let mut part = part.to_vec();
            part.sort_by(|a, b| a.2.total_cmp(&b.2));
            self.evaluations += part.iter().map(|(_, fit, _)| fit.evaluations).sum::<u64>();
            better.extend(part.into_iter().take(BETTER).map(|(space, fit, _)| (space, fit)));
        }
        better.extend(given);
        self.refine_and_keep(better);
    }

    /// Later generations: variations of the kept fits, and new starts.
    fn vary(&mut self) {
        let Self { kept, kinds, .. } = &*self;
        let Some(best) = kept.first() else { return };
        let tried: Vec<(Space, Solution<Vec<f64>>)> = (0..TRIED)
            .into_par_iter()
            .map_init(Workspace::new, |workspace, slot| {
                let mut stream = self.stream(slot);
                let count = kept.len() as u32;
                // Biased towards better fits.
                let parent = &kept[stream.below(count).min(stream.below(count)) as usize];
                let (space, fit) = match slot % 8 {
                    // Every fourth generation, slots 0 and 8 apply the evolution strategy to the
                    // best fit. The number of a slot decides how it varies a fit.
                    0 if self.generation.is_multiple_of(EVOLVE) => {
                        let fit = self.evolved(workspace, best, &mut stream);
                        (best.space.clone(), fit)
                    }
                    0 => perturbed(parent, &mut stream),
                    1 => (parent.space.clone(), Solution::new(parent.space.drawn(&mut stream))),
                    2 | 3 => match parent.space.form.with_other_choice(&mut stream) {
                        Some(form) => in_form(parent, form),
                        None => perturbed(parent, &mut stream),
                    },
                    // In the fit of a sum, one model may come near a fit that needs no other.
                    4 | 5 => with_one_model(parent, &mut stream)
                        .or_else(|| with_second_model(parent, kinds, &mut stream))
                        .unwrap_or_else(|| perturbed(parent, &mut stream)),
                    6 => match parent.space.form.to_anisotropic() {
                        Some(form) if !self.is_isotropic => in_form(parent, form),
                        _ => perturbed(parent, &mut stream),
                    },
                    _ if !kinds.is_empty() => {
                        let kind = kinds[stream.below(kinds.len() as u32) as usize];
                        let space = parent.space.of_form(Form::one(kind));
                        let x = random_point(&space, &mut stream);
                        (space, Solution::new(x))
                    }
                    _ => perturbed(parent, &mut stream),
                };
                let (fit, _) = self.coarse(workspace, &space, fit);
                (space, fit)
            })
            .collect();
        self.evaluations += tried.iter().map(|(_, fit)| fit.evaluations).sum::<u64>();
        self.refine_and_keep(tried);
    }

    /// Refines a start on [`FEW`] samples. Also returns its score, the least of which is best: -2
    /// ln of the probability of the parameters, up to a constant.
    ///
    /// The weight of the prior is set from the error before each part of the steps. While the error
    /// is large, the prior keeps the parameters near those of known materials.
    fn coarse(
        &self,
        workspace: &mut Workspace,
        space: &Space,
        mut fit: Solution<Vec<f64>>,
    ) -> (Solution<Vec<f64>>, f64) {
        let mut error =
            workspace.error(space, &fit.point, &self.few, TableDetail::Coarse) / self.few.total;
        for steps in STEPS {
            let weight = (error + self.equal) / INDEPENDENT;
            fit.refine(workspace, space, &self.few.with_prior(weight), Plan::coarse(steps));
            error = (fit.error - weight * space.prior.squares(&fit.point)).max(0.0);
        }
        let likelihood = INDEPENDENT * libm::log(error + self.equal);
        let score = likelihood + space.prior.squares(&fit.point);
        (fit, score)
    }

    /// Applies the evolution strategy to a kept fit.
    fn evolved(
        &self,
        workspace: &mut Workspace,
        from: &Kept,
        stream: &mut Stream,
    ) -> Solution<Vec<f64>> {
        let space = &from.space;
        let bounds: Vec<(f64, f64)> = space.coordinates.iter().map(|c| c.bounds).collect();
        let start = Start {
            x: &from.fit.point,
            bounds: &bounds,
            sigma: 0.1,
            generations: EVOLVE_GENERATIONS,
        };
        let mut evaluations = 0;
        let (x, _) = evolve(&start, stream, |x| {
            evaluations += 1;
            workspace.error(space, x, &self.few, TableDetail::Coarse) / self.few.total
        });
        Solution { evaluations, ..Solution::new(x) }
    }

    /// Refines the found fits on more samples, and keeps the best of each form.
    fn refine_and_keep(&mut self, found: Vec<(Space, Solution<Vec<f64>>)>) {
        let done: Vec<Kept> = found
            .into_par_iter()
            .map_init(Workspace::new, |workspace, (space, fit)| {
                let (fit, divisor) =
                    self.refined(workspace, (&space, &fit.point), (&self.all, Precision::Near));
                let x = (&fit.point[..], divisor);
                let held = workspace.error_divided(&space, x, &self.held, TableDetail::Full);
                let held = held / self.held.total.max(1.0);
                let evidence = self.evidence(workspace, &space, (&fit, held));
                let squares =
                    [&self.all, &self.held].map(|batch| workspace.mean_square(&space, x, batch));
                Kept { held, squares, evidence, space, fit }
            })
            .collect();
        for mut kept in done {
            self.evaluations += std::mem::take(&mut kept.fit.evaluations) + 1;
            if kept.fit.error.is_finite() {
                self.kept.push(kept);
            }
        }
        self.kept.sort_by(|a, b| a.evidence.total_cmp(&b.evidence));
        // Only the best of each form.
        let mut seen: Vec<Form> = Vec::new();
        self.kept.retain(|kept| {
            let is_new = !seen.contains(&kept.space.form);
            seen.push(kept.space.form.clone());
            is_new
        });
        self.kept.truncate(KEPT);
    }

    /// Returns -2 ln of the probability of a form, up to a constant, by Laplace's approximation
    /// around its fit.
    fn evidence(
        &self,
        workspace: &mut Workspace,
        space: &Space,
        (fit, held): (&Solution<Vec<f64>>, f64),
    ) -> f64 {
        let error = 0.5 * (fit.error + held) + self.equal;
        let equations =
            workspace.normal_equations(space, &fit.point, &self.few, TableDetail::Coarse);
        let scale = INDEPENDENT / (error * self.few.total);
        let hessian: Vec<f64> = equations.matrix.iter().map(|value| scale * value).collect();
        let likelihood = INDEPENDENT * libm::log(error);
        let evidence =
            likelihood + space.prior.distance(&fit.point) + space.prior.shrinkage(&hessian);
        if evidence.is_nan() { f64::INFINITY } else { evidence }
    }

    /// Refines from a point, and returns the solution with the divisor of its energy limit. If that
    /// is above 1, also refines from the same point with a penalty on albedos, and returns the
    /// better of both after division.
    fn refined(
        &self,
        workspace: &mut Workspace,
        (space, x): (&Space, &[f64]),
        (batch, precision): (&Batch, Precision),
    ) -> (Solution<Vec<f64>>, f64) {
        let mut free = Solution::new(x.to_vec());
        free.refine(workspace, space, batch, Plan::full(LAST_STEPS));
        // The prior first has a weight as if the error were at least `equal`, which chooses between
        // parameters of nearly the same error. Its last weights are those of the error that
        // remains, so that exact samples are matched exactly.
        let mut weight = (free.error + self.equal) / INDEPENDENT;
        let probable = batch.with_prior(weight);
        for _ in 0..PROBABLE {
            free.refine(workspace, space, &batch.with_prior(weight), Plan::full(LAST_STEPS));
            free = free.divided(workspace, space, (batch, 1.0));
            weight = free.error / INDEPENDENT;
        }
        let albedo = self.albedo(workspace, space, &free.point, precision);
        if albedo <= 1.0 {
            return (free, 1.0);
        }
        let mut best = free.divided(workspace, space, (batch, albedo));
        // With the penalty the error is at least that of the free fit before division. Skipped if a
        // kept fit with no more parameters already is as good as that.
        let is_behind =
            |kept: &Kept| kept.space.len() <= space.len() && kept.fit.error <= free.error;
        if precision == Precision::Near && self.kept.iter().any(is_behind) {
            return (best, albedo);
        }
        let mut held = Solution::new(x.to_vec());
        let mut level = ALBEDO_LEVEL;
        for _ in 0..CONSTRAINED_ROUNDS {
            held.refine(
                workspace,
                space,
                &probable.with_albedo_penalty(level, &self.albedos),
                Plan::full(CONSTRAINED_STEPS),
            );
            let albedo = workspace.albedo(space, &held.point, &self.albedos);
            let divided = held.divided(workspace, space, (batch, albedo.max(1.0)));
            if divided.error < best.error {
                best = divided;
            }
            if albedo <= ALBEDO_REACHED {
                break;
            }
            // Compensates for the error of the coarse quadrature.
            level *= ALBEDO_LEVEL / albedo;
        }
        let divisor = self.albedo(workspace, space, &best.point, precision).max(1.0);
        let mut best = best.divided(workspace, space, (batch, divisor));
        best.evaluations = free.evaluations + held.evaluations;
        (best, divisor)
    }

    /// Largest directional albedo, by quadrature or, if that is not precise enough, from the exact
    /// energy limit.
    fn albedo(
        &self,
        workspace: &mut Workspace,
        space: &Space,
        x: &[f64],
        precision: Precision,
    ) -> f64 {
        let albedo = workspace.albedo(space, x, &self.albedos);
        if !precision.needs_exact(albedo) {
            return albedo;
        }
        let genome = Form::genome(space.models(x)).expect("one or two models are a genome");
        let limit = energy_limit(&Program::lower(&genome));
        if limit.divisor > 1.0 { limit.divisor } else { limit.albedo }
    }

    /// Front from most to fewest parameters, each better than all with fewer or the most probable;
    /// refined on all samples.
    pub(super) fn front(&self) -> Vec<Finished> {
        let mut order: Vec<&Kept> = self.kept.iter().collect();
        order.sort_by(|a, b| a.space.len().cmp(&b.space.len()).then(a.held.total_cmp(&b.held)));
        let is_best = |evidence| self.kept.first().is_some_and(|best| best.evidence == evidence);
        let mut front: Vec<&Kept> = Vec::new();
        for kept in order {
            let is_better =
                front.last().is_none_or(|last| kept.held < (1.0 - MIN_GAIN) * last.held);
            if is_better || is_best(kept.evidence) {
                front.push(kept);
            }
        }
        front.reverse();
        let finish = |workspace: &mut Workspace, kept: &Kept| {
            let place = (&kept.space, &kept.fit.point[..]);
            let (fit, _) = self.refined(workspace, place, (&self.whole, Precision::Exact));
            let models = kept.space.models(&fit.point);
            (fit.error, Finished { models, ..Finished::of(kept) })
        };
        let done: Vec<(f64, Finished)> =
            front.into_par_iter().map_init(Workspace::new, finish).collect();
        // The exact energy limit may make some fits no better than shorter ones.
        let mut least = f64::INFINITY;
        let mut front: Vec<Finished> = Vec::new();
        for (error, finished) in done.into_iter().rev() {
            if error < least || is_best(finished.evidence) {
                least = least.min(error);
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
