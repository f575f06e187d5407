//! Damped Gauss-Newton steps in a box: Levenberg's and Marquardt's method with numbers that stay on a bound as long as the error
//! falls beyond it.

use brood_brdf::TableDetail;
use serde::{Deserialize, Serialize};

use super::batch::Batch;
use super::residual::{Bench, Normal, Space};
use crate::solve::solve;

/// The diagonal counts at least this share of its largest entry in the damping.
const FLOOR: f64 = 1e-9;
const DAMPING: f64 = 1e-2;
const LESS: f64 = 0.2;
const MORE: f64 = 4.0;
const LEAST: f64 = 1e-12;
/// Damping beyond which steps change nothing.
const MOST: f64 = 1e8;
/// A step that lowers the error by a smaller share has come to the end.
const SETTLED: f64 = 1e-7;
/// Mean square of differences in ln(1 + f cos_i) that is nothing.
const NOTHING: f64 = 1e-18;

/// A place in a space, and how good it is.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(super) struct Climb {
    pub(super) x: Vec<f64>,
    /// Mean of the squared differences.
    pub(super) error: f64,
    /// How often models have been held against samples for it.
    #[serde(skip)]
    pub(super) tries: u64,
}

/// How far a climb goes.
#[derive(Debug, Clone, Copy)]
pub(super) struct Plan {
    pub(super) steps: usize,
    pub(super) detail: TableDetail,
    /// Mean square at which it is good enough.
    pub(super) enough: f64,
}

impl Plan {
    /// So many steps, coarsely where models have tables.
    pub(super) fn coarse(steps: usize) -> Self {
        Self { steps, detail: TableDetail::Coarse, enough: NOTHING }
    }

    /// So many steps on the models as they are.
    pub(super) fn full(steps: usize) -> Self {
        Self { steps, detail: TableDetail::Full, enough: NOTHING }
    }
}

impl Climb {
    pub(super) fn new(x: Vec<f64>) -> Self {
        Self { x, error: f64::INFINITY, tries: 0 }
    }

    /// Steps on these samples, at most as many as the plan says.
    ///
    /// # Source
    /// Marquardt 1963; with bounds by projection as in Kanzow, Yamashita and Fukushima, *Levenberg-Marquardt methods with strong
    /// local convergence properties for solving nonlinear equations with convex constraints* (2004).
    pub(super) fn refine(&mut self, bench: &mut Bench, space: &Space, batch: &Batch, plan: Plan) {
        let mut damping = DAMPING;
        self.error = self.measure(bench, space, &self.x.clone(), (batch, plan.detail));
        let mut known: Option<Normal> = None;
        let mut settled = 0;
        for _ in 0..plan.steps {
            if self.error <= plan.enough {
                return;
            }
            if known.is_none() {
                self.tries += space.len() as u64;
                known = Some(bench.normal(space, &self.x, batch, plan.detail));
            }
            let next = known.as_ref().and_then(|normal| step(space, &self.x, normal, damping));
            let found = next.map(|x| (self.measure(bench, space, &x, (batch, plan.detail)), x));
            match found {
                Some((error, x)) if error < self.error => {
                    settled = if error > self.error * (1.0 - SETTLED) { settled + 1 } else { 0 };
                    (self.error, self.x) = (error, x);
                    damping = (damping * LESS).max(LEAST);
                    known = None;
                }
                _ => damping *= MORE,
            }
            if damping > MOST || settled == 2 {
                return;
            }
        }
    }

    /// The same place, as far off as it is once the energy limit has divided by so much.
    pub(super) fn divided(
        &self,
        bench: &mut Bench,
        space: &Space,
        (batch, divisor): (&Batch, f64),
    ) -> Self {
        let error = bench.error_divided(space, (&self.x, divisor), batch, TableDetail::Full);
        Self { error: finite(error / batch.total), ..self.clone() }
    }

    fn measure(
        &mut self,
        bench: &mut Bench,
        space: &Space,
        x: &[f64],
        (batch, detail): (&Batch, TableDetail),
    ) -> f64 {
        self.tries += 1;
        finite(bench.error(space, x, batch, detail) / batch.total)
    }
}

/// A place that is nowhere is the worst of all.
fn finite(error: f64) -> f64 {
    if error.is_finite() { error } else { f64::MAX }
}

/// The next place; none where the equations have no solution.
fn step(space: &Space, x: &[f64], normal: &Normal, damping: f64) -> Option<Vec<f64>> {
    let count = space.len();
    // The error falls beyond the bound that a number is on: it stays there.
    let is_free = |k: &usize| {
        let (low, high) = space.coordinates[*k].bounds;
        let slope = normal.gradient[*k];
        !(x[*k] <= low && slope >= 0.0 || x[*k] >= high && slope <= 0.0)
    };
    let free: Vec<usize> = (0..count).filter(is_free).collect();
    let own = |k: usize| normal.matrix[k * count + k];
    let largest = free.iter().map(|k| own(*k)).fold(0.0, f64::max);
    let mut matrix = Vec::with_capacity(free.len() * free.len());
    for a in &free {
        for b in &free {
            let damped = if a == b { damping * own(*a).max(FLOOR * largest) } else { 0.0 };
            matrix.push(normal.matrix[a * count + b] + damped);
        }
    }
    let right: Vec<f64> = free.iter().map(|k| normal.gradient[*k]).collect();
    let change = solve(matrix, &right)?;
    let over = |(k, change): (&usize, &f64)| change.abs() / space.coordinates[*k].longest;
    let longest = free.iter().zip(&change).map(over).fold(0.0f64, f64::max);
    if !longest.is_finite() || longest == 0.0 {
        return None;
    }
    let length = if longest > 1.0 { 1.0 / longest } else { 1.0 };
    let mut next = x.to_vec();
    for (k, change) in free.iter().zip(&change) {
        next[*k] -= length * change;
    }
    space.clamp(&mut next);
    Some(next)
}
