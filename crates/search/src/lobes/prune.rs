//! Shorter fits: weights that are needed least are left out, step by step, what is left being fitted again.

use super::Lobes;
use super::batch::Batch;
use super::damped::Damped;
use super::normal::normal;
use crate::solve::inverse_diagonal;

/// Of the weights that are left, this share goes in a step; where that is too much, the next one.
const SHARES: [f64; 3] = [0.08, 0.02, 0.0];
const STEPS: usize = 8;
/// Fits that are this many times as far off as the first one, where it is fitted or where it is not, are not looked for.
const WORST: f64 = 6.0;
/// So that what changes nothing can be told apart from what cannot be known.
const DAMPING: f64 = 1e-9;

/// A fit's shorter ones, each made of the one before.
///
/// # Source
/// Hassibi and Stork, *Second Order Derivatives for Network Pruning: Optimal Brain Surgeon* (1993): a weight w is needed by
/// w^2 / (2 [H^-1]_ww).
pub(super) struct Shorter<'a> {
    fit: Damped,
    batch: &'a Batch,
    /// Mean squared difference of the worst that is looked for.
    worst: f64,
}

impl<'a> Shorter<'a> {
    /// Of a fit whose mean squared difference where it was not fitted is `held`.
    pub(super) fn new(fit: Damped, held: f64, batch: &'a Batch) -> Self {
        let worst = WORST * WORST * fit.error.max(held);
        Self { fit, batch, worst }
    }
}

impl Iterator for Shorter<'_> {
    type Item = Damped;

    fn next(&mut self) -> Option<Damped> {
        self.fit = SHARES.iter().find_map(|share| {
            let shorter = without_least(&self.fit.lobes, self.batch, *share)?;
            let mut shorter = Damped::new(shorter, self.batch);
            shorter.refine(self.batch, STEPS);
            (shorter.error <= self.worst).then_some(shorter)
        })?;
        Some(self.fit.clone())
    }
}

/// The lobes without that share of the weights, at least one, those that are needed least; nothing where none would be left.
fn without_least(lobes: &Lobes, batch: &Batch, share: f64) -> Option<Lobes> {
    let mut next = lobes.clone();
    let colours = lobes.shape.colour(0, 0);
    let free: Vec<usize> = (0..lobes.numbers.len()).filter(|at| lobes.free[*at]).collect();
    let count = free.len();
    let mut matrix = normal(lobes, batch).0.matrix;
    let largest = (0..count).map(|k| matrix[k * count + k]).fold(0.0, f64::max);
    for k in 0..count {
        matrix[k * count + k] += DAMPING * largest;
    }
    let inverse = inverse_diagonal(matrix, count)?;
    let needed = |(at, number): (usize, &usize)| {
        let value = lobes.numbers[*number];
        (value * value / inverse[at], *number)
    };
    let mut weights: Vec<(f64, usize)> =
        free.iter().enumerate().map(needed).filter(|(_, number)| *number < colours).collect();
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
    for (_, number) in &weights[..gone] {
        leave_out(&mut next, *number);
    }
    leave_out_units(&mut next);
    Some(next)
}

fn leave_out(lobes: &mut Lobes, number: usize) {
    lobes.numbers[number] = 0.0;
    lobes.free[number] = false;
}

/// Units that no term reads need no weights.
fn leave_out_units(lobes: &mut Lobes) {
    let shape = lobes.shape.clone();
    for unit in 0..shape.units {
        let is_read = (0..shape.terms).any(|term| lobes.free[shape.term(term, unit)]);
        for input in 0..=shape.inputs.len() {
            let number = shape.unit(unit, input);
            if !is_read && lobes.free[number] {
                leave_out(lobes, number);
            }
        }
    }
}
