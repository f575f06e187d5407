//! Damped Gauss-Newton steps on the exact error: Levenberg's and Marquardt's method.

use super::Lobes;
use super::batch::Batch;
use super::normal::{Normal, error, normal};
use crate::solve::solve;

/// The diagonal counts at least this share of its largest entry in the damping: without, numbers that change next to nothing run
/// away.
const FLOOR: f64 = 1e-7;
/// No number changes by more in one step.
const LONGEST: f64 = 4.0;
const DAMPING: f64 = 1e-2;
const LESS: f64 = 0.3;
const MORE: f64 = 4.0;
/// Damping beyond which steps are too short to change an f32.
const MOST: f64 = 1e9;
/// log2 of a factor C stays within these.
const COLOURS: (f64, f64) = (-24.0, 15.0);

/// A fit that is under way.
///
/// # Source
/// Marquardt, *An Algorithm for Least-Squares Estimation of Nonlinear Parameters* (1963).
#[derive(Debug, Clone)]
pub(super) struct Damped {
    pub(super) lobes: Lobes,
    /// Mean of the squared differences.
    pub(super) error: f64,
    pub(super) damping: f64,
    /// Steps that have been tried since this was last counted.
    pub(super) tries: u64,
}

impl Damped {
    pub(super) fn new(lobes: Lobes, batch: &Batch) -> Self {
        let error = error(&lobes, batch);
        // A start that is nowhere is the worst of all.
        let error = if error.is_finite() { error } else { f64::MAX };
        Self { lobes, error, damping: DAMPING, tries: 1 }
    }

    /// The same numbers on other samples.
    pub(super) fn on(self, batch: &Batch) -> Self {
        let tries = self.tries;
        let fit = Self::new(self.lobes, batch);
        Self { tries: fit.tries + tries, ..fit }
    }

    /// Tries that many steps, fewer where none makes a difference any more.
    pub(super) fn refine(&mut self, batch: &Batch, steps: usize) {
        let mut known: Option<Normal> = None;
        for _ in 0..steps {
            self.tries += 1;
            let normal = known.get_or_insert_with(|| normal(&self.lobes, batch).0);
            let next = step(&self.lobes, normal, self.damping);
            let found = next.map(|lobes| (error(&lobes, batch), lobes));
            match found {
                Some((error, lobes)) if error < self.error => {
                    (self.error, self.lobes) = (error, lobes);
                    self.damping = (self.damping * LESS).max(1e-12);
                    known = None;
                }
                _ => self.damping *= MORE,
            }
            if self.damping > MOST {
                self.damping = DAMPING;
                return;
            }
        }
    }
}

fn step(lobes: &Lobes, normal: &Normal, damping: f64) -> Option<Lobes> {
    let count = normal.gradient.len();
    let mut matrix = normal.matrix.clone();
    let largest = (0..count).map(|k| matrix[k * count + k]).fold(0.0, f64::max);
    for k in 0..count {
        let own = &mut matrix[k * count + k];
        *own += damping * own.max(FLOOR * largest);
    }
    let change = solve(matrix, &normal.gradient)?;
    let longest = change.iter().fold(0.0f64, |longest, value| longest.max(value.abs()));
    if !longest.is_finite() {
        return None;
    }
    let length = if longest > LONGEST { LONGEST / longest } else { 1.0 };
    let mut next = lobes.clone();
    let colours = lobes.shape.colour(0, 0);
    let free = (0..next.numbers.len()).filter(|at| lobes.free[*at]);
    for (at, change) in free.zip(&change) {
        let value = next.numbers[at] - length * change;
        next.numbers[at] = if at < colours { value } else { value.clamp(COLOURS.0, COLOURS.1) };
    }
    Some(next)
}
