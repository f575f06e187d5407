//! Refinement of lobes by the Levenberg-Marquardt method, with analytic derivatives.

use super::Lobes;
use super::batch::Batch;
use super::normal_equations::{error, normal_equations};
use crate::levenberg_marquardt::{NormalEquations, Problem, Rules, Solution};

const RULES: Rules = Rules {
    diagonal_floor: 1e-7,
    decrease: 0.3,
    increase: 4.0,
    max_damping: 1e9,
    enough: f64::NEG_INFINITY,
    // Off: the number of steps is the limit.
    converged: (1, 0.0),
    stops_when_singular: false,
};
/// Largest change of a parameter in one step.
const LONGEST_STEP: f64 = 4.0;
/// Range of log2 of a factor C.
const COLOUR_RANGE: (f64, f64) = (-24.0, 15.0);

/// The objective on a batch: mean squared difference plus penalties.
struct OnBatch<'a>(&'a Batch);

impl Problem for OnBatch<'_> {
    type Point = Lobes;

    fn error(&mut self, lobes: &Lobes) -> f64 {
        error(lobes, self.0)
    }

    fn normal_equations(&mut self, at: &mut Solution<Lobes>) -> NormalEquations {
        normal_equations(&at.point, self.0).0
    }

    fn longest_step(&self, _: usize) -> f64 {
        LONGEST_STEP
    }

    fn moved(&self, lobes: &Lobes, change: &[f64]) -> Option<Lobes> {
        let mut next = lobes.clone();
        let colours = lobes.shape.colour(0, 0);
        let free = (0..next.parameters.len()).filter(|at| lobes.free[*at]);
        for (at, change) in free.zip(change) {
            let value = next.parameters[at] - change;
            next.parameters[at] =
                if at < colours { value } else { value.clamp(COLOUR_RANGE.0, COLOUR_RANGE.1) };
        }
        Some(next)
    }
}

impl Solution<Lobes> {
    /// Starts from these parameters on a batch, and measures their error.
    pub(super) fn of(lobes: Lobes, batch: &Batch) -> Self {
        Self::new(lobes).on(batch)
    }

    /// Continues with the same parameters on another batch: measures the error there.
    pub(super) fn on(mut self, batch: &Batch) -> Self {
        self.start(&mut OnBatch(batch));
        self.evaluations += 1;
        self
    }

    /// Tries up to `steps` steps; stops when the damping gets too large.
    pub(super) fn refine(&mut self, batch: &Batch, steps: usize) {
        self.evaluations += self.minimise(&mut OnBatch(batch), &RULES, steps);
    }
}
