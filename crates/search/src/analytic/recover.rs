//! Inverse rendering: recovers the parameters of a model of known form from samples, by random
//! starts.

use std::sync::Arc;

use brood_brdf::Model;
use brood_genome::{BirthKey, Operator, Stream};
use brood_target::Samples;

use super::Form;
use super::batch::{Batch, pick_samples};
use super::evolve::{Start, evolve};
use super::refine::Plan;
use super::residual::{Space, Workspace};
use crate::levenberg_marquardt::Solution;

/// Number of samples of the first steps, and of the last ones.
const FEW: usize = 192;
const MANY: usize = 768;
/// Number of first steps, and of last ones.
const STEPS: usize = 60;
const LAST_STEPS: usize = 20;
/// Largest number of starts. Every eighth start is refined by the evolution strategy first.
const STARTS: u32 = 40;
const EVOLVE: u32 = 8;
const EVOLVE_GENERATIONS: usize = 120;
/// The last steps follow only if E_log is below this after the first ones.
const NEAR: f64 = 2e-2;

/// A recovery problem: samples of a material, and the form to fit.
pub struct Recovery {
    space: Space,
    few: Batch,
    many: Batch,
    /// E_log at which the search stops.
    enough: f64,
}

/// Result of a recovery.
#[derive(Debug, Clone, PartialEq)]
pub struct Recovered {
    /// Best model.
    pub model: Model,
    /// E_log on the samples used.
    pub e_log: f64,
    /// Number of models evaluated on samples.
    pub evaluations: u64,
    /// Number of starts; 1 if the first one succeeded.
    pub starts: u32,
}

impl Recovery {
    /// Prepares to fit models of one form.
    #[must_use]
    pub fn new(samples: &Samples, form: Form, enough: f64) -> Self {
        let all: Vec<usize> = (0..samples.len()).collect();
        let few = Batch::new(samples, &pick_samples(samples, &all, FEW)).with_lower_bounds(samples);
        let many =
            Batch::new(samples, &pick_samples(samples, &all, MANY)).with_lower_bounds(samples);
        Self { space: Space::new(form, &Arc::default()), few, many, enough }
    }

    /// Recovers a model from random start `number`, and from further starts if that one fails.
    /// Deterministic in seed and number.
    #[must_use]
    pub fn run(&self, seed: u64, number: u32) -> Recovered {
        let mut workspace = Workspace::new();
        let space = &self.space;
        let enough = self.enough * self.enough;
        let (mut best, mut evaluations): (Option<Solution<Vec<f64>>>, u64) = (None, 0);
        let mut starts = 0;
        while starts < STARTS {
            let key = BirthKey { seed, slot: number, attempt: starts };
            let mut stream = Stream::new(key, Operator::Analytic);
            starts += 1;
            let mut fit = Solution::new(random_point(space, &mut stream));
            if starts.is_multiple_of(EVOLVE) {
                fit = self.evolved(&mut workspace, fit, &mut stream);
            }
            fit.refine(&mut workspace, space, &self.few, Plan::coarse(STEPS));
            if fit.error < NEAR * NEAR {
                fit.refine(
                    &mut workspace,
                    space,
                    &self.many,
                    Plan { enough, ..Plan::full(LAST_STEPS) },
                );
            }
            evaluations += fit.evaluations;
            if best.as_ref().is_none_or(|best| fit.error < best.error) {
                best = Some(fit);
            }
            if best.as_ref().is_some_and(|best| best.error <= enough) {
                break;
            }
        }
        let best = best.expect("there is at least one start");
        let model = space.models(&best.point).remove(0);
        Recovered { model, e_log: best.error.sqrt(), evaluations, starts }
    }

    fn evolved(
        &self,
        workspace: &mut Workspace,
        fit: Solution<Vec<f64>>,
        stream: &mut Stream,
    ) -> Solution<Vec<f64>> {
        let (space, few) = (&self.space, &self.few);
        let bounds: Vec<(f64, f64)> = space.coordinates.iter().map(|c| c.bounds).collect();
        let start =
            Start { x: &fit.point, bounds: &bounds, sigma: 0.3, generations: EVOLVE_GENERATIONS };
        let mut evaluations = fit.evaluations;
        let (x, error) = evolve(&start, stream, |x| {
            evaluations += 1;
            workspace.error(space, x, few, brood_brdf::TableDetail::Coarse) / few.total
        });
        Solution { error, evaluations, ..Solution::new(x) }
    }

    /// Number of free parameters.
    #[must_use]
    pub fn unknowns(&self) -> usize {
        self.space.len()
    }
}

/// Draws a random start point.
pub(super) fn random_point(space: &Space, stream: &mut Stream) -> Vec<f64> {
    space.coordinates.iter().map(|coordinate| coordinate.start(f64::from(stream.unit()))).collect()
}

#[cfg(test)]
mod tests {
    use brood_brdf::ModelKind;
    use brood_target::draw_pairs;

    use super::*;

    /// A model with random parameters, not too extreme.
    fn truth(kind: ModelKind, number: u32) -> Model {
        let key = BirthKey { seed: 77, slot: number, attempt: 0 };
        let mut stream = Stream::new(key, Operator::RandomLayers);
        let space = Space::new(Form::one(kind), &Arc::default());
        space.models(&random_point(&space, &mut stream)).remove(0)
    }

    #[test]
    fn recovery_finds_models_from_their_samples() {
        for kind in [
            ModelKind::OrenNayar,
            ModelKind::CookTorrance,
            ModelKind::Conductor,
            ModelKind::Coated,
            ModelKind::RoughPlastic,
            ModelKind::Principled,
            ModelKind::Ward,
            ModelKind::AshikhminShirley,
            ModelKind::Abc,
        ] {
            for number in 0..3 {
                let truth = truth(kind, number);
                let samples = Samples::of(&*truth.brdf(), draw_pairs(2000, 5));
                let found = Recovery::new(&samples, Form::one(kind), 1e-6).run(1, number);
                assert!(found.e_log < 1e-5, "{truth}{found:?}");
            }
        }
    }
}
