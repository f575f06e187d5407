//! Levenberg-Marquardt solver on the exact error, with analytic derivatives.

use super::Lobes;
use super::batch::Batch;
use super::normal_equations::{NormalEquations, error, normal_equations};
use crate::solve::solve;

/// Damping uses at least this share of the largest diagonal entry. Without, parameters with almost
/// no effect diverge.
const DIAGONAL_FLOOR: f64 = 1e-7;
/// Largest change of a parameter in one step.
const LONGEST_STEP: f64 = 4.0;
const INITIAL_DAMPING: f64 = 1e-2;
const DAMPING_DECREASE: f64 = 0.3;
const DAMPING_INCREASE: f64 = 4.0;
/// Damping at which the solver stops: steps are too short to change an f32.
const MAX_DAMPING: f64 = 1e9;
/// Range of log2 of a factor C.
const COLOUR_RANGE: (f64, f64) = (-24.0, 15.0);

/// State of the solver: a fit, its error and the damping.
///
/// # Source
/// Marquardt, *An Algorithm for Least-Squares Estimation of Nonlinear Parameters* (1963).
#[derive(Debug, Clone)]
pub(super) struct LevenbergMarquardt {
    pub(super) lobes: Lobes,
    /// Mean squared difference, penalties included.
    pub(super) error: f64,
    pub(super) damping: f64,
    /// Number of evaluations since this was last counted.
    pub(super) evaluations: u64,
}

impl LevenbergMarquardt {
    pub(super) fn new(lobes: Lobes, batch: &Batch) -> Self {
        let error = error(&lobes, batch);
        // Maps a non-finite error to the worst value.
        let error = if error.is_finite() { error } else { f64::MAX };
        Self { lobes, error, damping: INITIAL_DAMPING, evaluations: 1 }
    }

    /// Continues with the same parameters on other samples.
    pub(super) fn on(self, batch: &Batch) -> Self {
        let evaluations = self.evaluations;
        let fit = Self::new(self.lobes, batch);
        Self { evaluations: fit.evaluations + evaluations, ..fit }
    }

    /// Tries up to `steps` steps; stops when the damping gets too large.
    pub(super) fn refine(&mut self, batch: &Batch, steps: usize) {
        let mut known: Option<NormalEquations> = None;
        for _ in 0..steps {
            self.evaluations += 1;
            let normal = known.get_or_insert_with(|| normal_equations(&self.lobes, batch).0);
            let next = step(&self.lobes, normal, self.damping);
            let found = next.map(|lobes| (error(&lobes, batch), lobes));
            match found {
                Some((error, lobes)) if error < self.error => {
                    (self.error, self.lobes) = (error, lobes);
                    self.damping = (self.damping * DAMPING_DECREASE).max(1e-12);
                    known = None;
                }
                _ => self.damping *= DAMPING_INCREASE,
            }
            if self.damping > MAX_DAMPING {
                self.damping = INITIAL_DAMPING;
                return;
            }
        }
    }
}

fn step(lobes: &Lobes, normal: &NormalEquations, damping: f64) -> Option<Lobes> {
    let count = normal.gradient.len();
    let mut matrix = normal.matrix.clone();
    let largest = (0..count).map(|k| matrix[k * count + k]).fold(0.0, f64::max);
    for k in 0..count {
        let own = &mut matrix[k * count + k];
        *own += damping * own.max(DIAGONAL_FLOOR * largest);
    }
    let change = solve(matrix, &normal.gradient)?;
    let longest = change.iter().fold(0.0f64, |longest, value| longest.max(value.abs()));
    if !longest.is_finite() {
        return None;
    }
    let length = if longest > LONGEST_STEP { LONGEST_STEP / longest } else { 1.0 };
    let mut next = lobes.clone();
    let colours = lobes.shape.colour(0, 0);
    let free = (0..next.parameters.len()).filter(|at| lobes.free[*at]);
    for (at, change) in free.zip(&change) {
        let value = next.parameters[at] - length * change;
        next.parameters[at] =
            if at < colours { value } else { value.clamp(COLOUR_RANGE.0, COLOUR_RANGE.1) };
    }
    Some(next)
}
