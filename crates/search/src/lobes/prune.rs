//! Pruning: removes the least needed weights step by step, refitting the rest after each step.

use super::Lobes;
use super::batch::Batch;
use super::normal_equations::normal_equations;
use crate::levenberg_marquardt::Solution;
use crate::solve::inverse_diagonal;

/// Shares of the remaining weights to remove in a step, at least one weight; a smaller share is
/// tried if the fit without a larger one is too bad.
const SHARES: [f64; 3] = [0.08, 0.02, 0.0];
/// Number of refinement steps after each removal.
const STEPS: usize = 8;
/// Pruning stops when the root of the error on training samples would exceed this multiple of the
/// first fit's, on training or on validation samples, whichever is larger.
const WORST: f64 = 6.0;
/// Share of the largest diagonal entry that is added to the diagonal, so that the inverse exists
/// even if samples do not determine a weight.
const REGULARISATION: f64 = 1e-9;

/// Iterator over shorter fits, each pruned from the previous one.
///
/// # Source
/// Hassibi and Stork, *Second Order Derivatives for Network Pruning: Optimal Brain Surgeon* (1993):
/// the saliency of a weight w is w^2 / (2 [H^-1]_ww).
pub(super) struct Shorter<'a> {
    fit: Solution<Lobes>,
    batch: &'a Batch,
    /// Largest error of a result.
    worst: f64,
}

impl<'a> Shorter<'a> {
    /// Starts from a fit whose error on the validation samples is `held`.
    pub(super) fn new(fit: Solution<Lobes>, held: f64, batch: &'a Batch) -> Self {
        let worst = WORST * WORST * fit.error.max(held);
        Self { fit, batch, worst }
    }
}

impl Iterator for Shorter<'_> {
    type Item = Solution<Lobes>;

    fn next(&mut self) -> Option<Solution<Lobes>> {
        self.fit = SHARES.iter().find_map(|share| {
            let shorter = without_least(&self.fit.point, self.batch, *share)?;
            let mut shorter = Solution::of(shorter, self.batch);
            shorter.refine(self.batch, STEPS);
            (shorter.error <= self.worst).then_some(shorter)
        })?;
        Some(self.fit.clone())
    }
}

/// Removes that share of the weights, at least one, the least salient first; `None` if no weight
/// would remain. Colours are not removed.
fn without_least(lobes: &Lobes, batch: &Batch, share: f64) -> Option<Lobes> {
    let mut next = lobes.clone();
    let colours = lobes.shape.colour(0, 0);
    let free: Vec<usize> = (0..lobes.parameters.len()).filter(|at| lobes.free[*at]).collect();
    let count = free.len();
    let mut matrix = normal_equations(lobes, batch).0.matrix;
    let largest = (0..count).map(|k| matrix[k * count + k]).fold(0.0, f64::max);
    for k in 0..count {
        matrix[k * count + k] += REGULARISATION * largest;
    }
    let inverse = inverse_diagonal(matrix, count)?;
    let needed = |(at, index): (usize, &usize)| {
        let value = lobes.parameters[*index];
        (value * value / inverse[at], *index)
    };
    let mut weights: Vec<(f64, usize)> =
        free.iter().enumerate().map(needed).filter(|(_, index)| *index < colours).collect();
    weights.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "it is a small share"
    )]
    let gone = ((share * weights.len() as f64) as usize).max(1);
    if weights.len() <= gone {
        return None;
    }
    for (_, index) in &weights[..gone] {
        leave_out(&mut next, *index);
    }
    leave_out_units(&mut next);
    Some(next)
}

fn leave_out(lobes: &mut Lobes, index: usize) {
    lobes.parameters[index] = 0.0;
    lobes.free[index] = false;
}

/// Removes the weights of units that no term reads.
fn leave_out_units(lobes: &mut Lobes) {
    let shape = lobes.shape.clone();
    for unit in 0..shape.units {
        let is_read = (0..shape.terms).any(|term| lobes.free[shape.term(term, unit)]);
        for input in 0..=shape.inputs.len() {
            let index = shape.unit(unit, input);
            if !is_read && lobes.free[index] {
                leave_out(lobes, index);
            }
        }
    }
}
