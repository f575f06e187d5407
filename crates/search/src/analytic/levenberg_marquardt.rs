//! Levenberg-Marquardt solver in a box. A coordinate stays on its bound while the error falls
//! beyond it. Derivatives are finite differences.

use brood_brdf::TableDetail;
use serde::{Deserialize, Serialize};

use super::batch::Batch;
use super::residual::{NormalEquations, Space, Workspace};
use crate::solve::solve;

/// Damping uses at least this share of the largest diagonal entry.
const DIAGONAL_FLOOR: f64 = 1e-9;
const INITIAL_DAMPING: f64 = 1e-2;
const DAMPING_DECREASE: f64 = 0.2;
const DAMPING_INCREASE: f64 = 4.0;
const MIN_DAMPING: f64 = 1e-12;
/// Damping at which the solver stops: steps no longer change anything.
const MAX_DAMPING: f64 = 1e8;
/// A step that reduces the error by a smaller share counts as converged.
const CONVERGED: f64 = 1e-7;
/// Mean square at which the solver stops: an exact fit.
const EXACT: f64 = 1e-18;

/// State of the solver: a point and its error.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(super) struct LevenbergMarquardt {
    pub(super) x: Vec<f64>,
    /// Mean squared residual.
    pub(super) error: f64,
    /// Number of evaluations of models on samples.
    #[serde(skip)]
    pub(super) evaluations: u64,
}

/// Budget and precision of a refinement.
#[derive(Debug, Clone, Copy)]
pub(super) struct Plan {
    pub(super) steps: usize,
    pub(super) detail: TableDetail,
    /// Mean square at which the refinement stops.
    pub(super) enough: f64,
}

impl Plan {
    /// `steps` steps with coarse tables, for models that have tables.
    pub(super) fn coarse(steps: usize) -> Self {
        Self { steps, detail: TableDetail::Coarse, enough: EXACT }
    }

    /// `steps` steps with full tables.
    pub(super) fn full(steps: usize) -> Self {
        Self { steps, detail: TableDetail::Full, enough: EXACT }
    }
}

impl LevenbergMarquardt {
    pub(super) fn new(x: Vec<f64>) -> Self {
        Self { x, error: f64::INFINITY, evaluations: 0 }
    }

    /// Refines the point on these samples.
    ///
    /// # Source
    /// Marquardt 1963; with bounds by projection as in Kanzow, Yamashita and Fukushima,
    /// *Levenberg-Marquardt methods with strong local convergence properties for solving nonlinear
    /// equations with convex constraints* (2004).
    pub(super) fn refine(
        &mut self,
        workspace: &mut Workspace,
        space: &Space,
        batch: &Batch,
        plan: Plan,
    ) {
        let mut damping = INITIAL_DAMPING;
        self.error = self.measure(workspace, space, &self.x.clone(), (batch, plan.detail));
        let mut known: Option<NormalEquations> = None;
        let mut converged_steps = 0;
        for _ in 0..plan.steps {
            if self.error <= plan.enough {
                return;
            }
            if known.is_none() {
                self.evaluations += space.len() as u64;
                known = Some(workspace.normal_equations(space, &self.x, batch, plan.detail));
            }
            let next = known.as_ref().and_then(|normal| step(space, &self.x, normal, damping));
            let found = next.map(|x| (self.measure(workspace, space, &x, (batch, plan.detail)), x));
            match found {
                Some((error, x)) if error < self.error => {
                    converged_steps = if error > self.error * (1.0 - CONVERGED) {
                        converged_steps + 1
                    } else {
                        0
                    };
                    (self.error, self.x) = (error, x);
                    damping = (damping * DAMPING_DECREASE).max(MIN_DAMPING);
                    known = None;
                }
                _ => damping *= DAMPING_INCREASE,
            }
            if damping > MAX_DAMPING || converged_steps == 2 {
                return;
            }
        }
    }

    /// Copy with the error after the energy limit has divided f by `divisor`.
    pub(super) fn divided(
        &self,
        workspace: &mut Workspace,
        space: &Space,
        (batch, divisor): (&Batch, f64),
    ) -> Self {
        let error = workspace.error_divided(space, (&self.x, divisor), batch, TableDetail::Full);
        Self { error: finite(error / batch.total), ..self.clone() }
    }

    fn measure(
        &mut self,
        workspace: &mut Workspace,
        space: &Space,
        x: &[f64],
        (batch, detail): (&Batch, TableDetail),
    ) -> f64 {
        self.evaluations += 1;
        finite(workspace.error(space, x, batch, detail) / batch.total)
    }
}

/// Maps a non-finite error to the worst value.
fn finite(error: f64) -> f64 {
    if error.is_finite() { error } else { f64::MAX }
}

/// Returns the next point; `None` if the normal equations have no solution.
fn step(space: &Space, x: &[f64], normal: &NormalEquations, damping: f64) -> Option<Vec<f64>> {
    let count = space.len();
    // A coordinate on its bound stays there while the error falls beyond the bound.
    let is_free = |k: &usize| {
        let (low, high) = space.coordinates[*k].bounds;
        let gradient = normal.gradient[*k];
        !(x[*k] <= low && gradient >= 0.0 || x[*k] >= high && gradient <= 0.0)
    };
    let free: Vec<usize> = (0..count).filter(is_free).collect();
    let own = |k: usize| normal.matrix[k * count + k];
    let largest = free.iter().map(|k| own(*k)).fold(0.0, f64::max);
    let mut matrix = Vec::with_capacity(free.len() * free.len());
    for a in &free {
        for b in &free {
            let damped = if a == b { damping * own(*a).max(DIAGONAL_FLOOR * largest) } else { 0.0 };
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
