//! Levenberg-Marquardt solver: damped steps on the normal equations of a least-squares problem.

use crate::solve::solve;

const INITIAL_DAMPING: f64 = 1e-2;
const MIN_DAMPING: f64 = 1e-12;

/// J^T J and J^T r of the free parameters of a point.
#[derive(Debug, Clone)]
pub(crate) struct NormalEquations {
    /// J^T J, row by row.
    pub(crate) matrix: Vec<f64>,
    /// J^T r.
    pub(crate) gradient: Vec<f64>,
}

impl NormalEquations {
    pub(crate) fn zero(count: usize) -> Self {
        Self { matrix: vec![0.0; count * count], gradient: vec![0.0; count] }
    }

    /// Normal equations of these parameters only.
    pub(crate) fn of(&self, free: &[usize]) -> Self {
        let count = self.gradient.len();
        let entries = free.iter().flat_map(|a| free.iter().map(move |b| a * count + b));
        Self {
            matrix: entries.map(|at| self.matrix[at]).collect(),
            gradient: free.iter().map(|at| self.gradient[*at]).collect(),
        }
    }
}

/// A least-squares problem.
pub(crate) trait Problem {
    type Point;

    /// Error of a point; not finite if the point is unusable.
    fn error(&mut self, point: &Self::Point) -> f64;

    /// Normal equations of the free parameters at a point. May set its error, which is a by-product
    /// of the derivatives.
    fn normal_equations(&mut self, at: &mut Solution<Self::Point>) -> NormalEquations;

    /// Largest change of the free parameter of this index in one step. If any parameter changes by
    /// more, the whole step is scaled down.
    fn longest_step(&self, index: usize) -> f64;

    /// Returns the point minus the change of each free parameter, within the bounds; `None` if the
    /// change is zero.
    fn moved(&self, point: &Self::Point, change: &[f64]) -> Option<Self::Point>;
}

/// Constants of a solver.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Rules {
    /// A diagonal entry of J^T J is damped as if it were at least this share of the largest one.
    /// Without this, parameters with almost no effect diverge.
    pub(crate) diagonal_floor: f64,
    /// Factor of the damping after a step that reduces the error.
    pub(crate) decrease: f64,
    /// Factor of the damping after a rejected step.
    pub(crate) increase: f64,
    /// Damping above which the solver stops, because steps no longer change anything.
    pub(crate) max_damping: f64,
    /// Error at which the solver stops.
    pub(crate) enough: f64,
    /// The solver stops after this many accepted steps in a row that each reduce the error by less
    /// than this share; a share of 0 turns this off.
    pub(crate) converged: (u32, f64),
    /// True if the solver stops when the normal equations have no solution, instead of increasing
    /// the damping.
    pub(crate) stops_when_singular: bool,
}

/// State of the solver.
///
/// # Source
/// Marquardt, *An Algorithm for Least-Squares Estimation of Nonlinear Parameters* (1963).
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Solution<P> {
    pub(crate) point: P,
    /// Error, penalties included; infinite before it is measured.
    pub(crate) error: f64,
    pub(crate) damping: f64,
    /// Number of evaluations that the owner has not yet added to its total.
    pub(crate) evaluations: u64,
}

impl<P> Solution<P> {
    pub(crate) fn new(point: P) -> Self {
        Self { point, error: f64::INFINITY, damping: INITIAL_DAMPING, evaluations: 0 }
    }

    /// Measures the error, and starts with the initial damping.
    pub(crate) fn start(&mut self, problem: &mut impl Problem<Point = P>) {
        self.error = finite(problem.error(&self.point));
        self.damping = INITIAL_DAMPING;
    }

    /// Tries up to `steps` steps; returns the number of steps tried. The error must be measured, by
    /// [`Solution::start`] or by the problem's normal equations.
    pub(crate) fn minimise(
        &mut self,
        problem: &mut impl Problem<Point = P>,
        rules: &Rules,
        steps: usize,
    ) -> u64 {
        let mut known: Option<NormalEquations> = None;
        let (mut tried, mut converged) = (0, 0);
        for _ in 0..steps {
            if self.error <= rules.enough {
                break;
            }
            tried += 1;
            let normal = known.get_or_insert_with(|| problem.normal_equations(self));
            let change = change(problem, normal, self.damping, rules);
            if change.is_none() && rules.stops_when_singular {
                break;
            }
            let next = change.and_then(|change| problem.moved(&self.point, &change));
            match next.map(|point| (problem.error(&point), point)) {
                Some((error, point)) if error < self.error => {
                    let is_converged = error > self.error * (1.0 - rules.converged.1);
                    converged = if is_converged { converged + 1 } else { 0 };
                    (self.error, self.point) = (error, point);
                    self.damping = (self.damping * rules.decrease).max(MIN_DAMPING);
                    known = None;
                }
                _ => self.damping *= rules.increase,
            }
            if self.damping > rules.max_damping {
                self.damping = INITIAL_DAMPING;
                break;
            }
            if converged == rules.converged.0 {
                break;
            }
        }
        tried
    }
}

/// Maps a non-finite error to the worst value.
pub(crate) fn finite(error: f64) -> f64 {
    if error.is_finite() { error } else { f64::MAX }
}

/// Solves the damped normal equations, and shortens the step if it is too long; `None` if they have
/// no solution.
fn change(
    problem: &impl Problem,
    normal: &NormalEquations,
    damping: f64,
    rules: &Rules,
) -> Option<Vec<f64>> {
    let count = normal.gradient.len();
    let mut matrix = normal.matrix.clone();
    let largest = (0..count).map(|k| matrix[k * count + k]).fold(0.0, f64::max);
    for k in 0..count {
        let own = &mut matrix[k * count + k];
        *own += damping * own.max(rules.diagonal_floor * largest);
    }
    let mut change = solve(matrix, &normal.gradient)?;
    let share = |(k, change): (usize, &f64)| change.abs() / problem.longest_step(k);
    let longest = change.iter().enumerate().map(share).fold(0.0, f64::max);
    if !longest.is_finite() {
        return None;
    }
    if longest > 1.0 {
        change.iter_mut().for_each(|change| *change *= 1.0 / longest);
    }
    Some(change)
}
