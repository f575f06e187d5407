//! Refinement of models by the Levenberg-Marquardt method in a box. A coordinate stays on its bound
//! while the error falls beyond it. Derivatives are finite differences.
//!
//! # Source
//! Kanzow, Yamashita and Fukushima, *Levenberg-Marquardt methods with strong local convergence
//! properties for solving nonlinear equations with convex constraints* (2004): bounds by
//! projection.

use brood_brdf::TableDetail;

use super::batch::Batch;
use super::residual::{Space, Workspace};
use crate::levenberg_marquardt::{NormalEquations, Problem, Rules, Solution, finite};

const RULES: Rules = Rules {
    diagonal_floor: 1e-9,
    decrease: 0.2,
    increase: 4.0,
    max_damping: 1e8,
    // An exact fit.
    enough: 1e-18,
    converged: (2, 1e-7),
    stops_when_singular: false,
};

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
        Self { steps, detail: TableDetail::Coarse, enough: RULES.enough }
    }

    /// `steps` steps with full tables.
    pub(super) fn full(steps: usize) -> Self {
        Self { detail: TableDetail::Full, ..Self::coarse(steps) }
    }
}

/// The mean squared residual of models in their box on a batch.
struct InBox<'a> {
    workspace: &'a mut Workspace,
    space: &'a Space,
    batch: &'a Batch,
    detail: TableDetail,
    /// Coordinates that are not held on a bound.
    free: Vec<usize>,
    evaluations: u64,
}

impl Problem for InBox<'_> {
    type Point = Vec<f64>;

    fn error(&mut self, x: &Vec<f64>) -> f64 {
        self.evaluations += 1;
        self.workspace.error(self.space, x, self.batch, self.detail) / self.batch.total
    }

    fn normal_equations(&mut self, at: &mut Solution<Vec<f64>>) -> NormalEquations {
        let Self { space, batch, detail, .. } = *self;
        let x = &at.point;
        self.evaluations += space.len() as u64;
        let all = self.workspace.normal_equations(space, x, batch, detail);
        // A coordinate on its bound stays there while the error falls beyond the bound.
        let is_free = |k: &usize| {
            let (low, high) = space.coordinates[*k].bounds;
            let gradient = all.gradient[*k];
            !(x[*k] <= low && gradient >= 0.0 || x[*k] >= high && gradient <= 0.0)
        };
        self.free = (0..space.len()).filter(is_free).collect();
        all.of(&self.free)
    }

    fn longest_step(&self, index: usize) -> f64 {
        self.space.coordinates[self.free[index]].longest
    }

    fn moved(&self, x: &Vec<f64>, change: &[f64]) -> Option<Vec<f64>> {
        let mut next = x.clone();
        for (k, change) in self.free.iter().zip(change) {
            next[*k] -= change;
        }
        self.space.clamp(&mut next);
        change.iter().any(|change| change.abs() > 0.0).then_some(next)
    }
}

impl Solution<Vec<f64>> {
    /// Refines the point on these samples.
    pub(super) fn refine(
        &mut self,
        workspace: &mut Workspace,
        space: &Space,
        batch: &Batch,
        plan: Plan,
    ) {
        let Plan { steps, detail, enough } = plan;
        let free = Vec::new();
        let mut problem = InBox { workspace, space, batch, detail, free, evaluations: 0 };
        self.start(&mut problem);
        self.minimise(&mut problem, &Rules { enough, ..RULES }, steps);
        self.evaluations += problem.evaluations;
    }

    /// Copy with the error after the energy limit has divided f by `divisor`.
    pub(super) fn divided(
        &self,
        workspace: &mut Workspace,
        space: &Space,
        (batch, divisor): (&Batch, f64),
    ) -> Self {
        let point = (&self.point[..], divisor);
        let error = workspace.error_divided(space, point, batch, TableDetail::Full);
        Self { error: finite(error / batch.total), ..self.clone() }
    }
}
