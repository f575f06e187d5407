//! One pass through a program over a block of samples: the values of all steps, derivatives in
//! either mode, and their sums for the normal equations. Every loop is over the 64 lanes of a
//! quarter, for one operation at a time.

use brood_brdf::SimdKernel;
use brood_genome::Functions;
use brood_program::{Operation, for_known};

use super::equations::NormalEquations;
use super::local::partials;
use super::plan::{Adjoint, AdjointStep, Plan, PlannedStep, Tangent, TangentStep};
use crate::canonical::reflectance;
use crate::fitness::{FitnessTarget, Loss};
use crate::lanes::{BLOCK, LANES, QUARTERS, Quarter, pairwise_sum};

const ZERO: Quarter = Quarter([0.0; LANES]);
const ONE: Quarter = Quarter([1.0; LANES]);
/// Number of quarters in a column of the Jacobian of a block, which belongs to one constant: one
/// for each quarter of the block and channel.
const COLUMN: usize = 3 * QUARTERS;
/// Number of partial sums of a dot product, which take its terms in turn.
const PARTIAL_SUMS: usize = 32;

/// Steps that derivatives are propagated through. Forward: for each constant, the steps that depend
/// on it and the tangents of the results. Reverse: for each channel, the destination of the adjoint
/// of its result and the steps to visit.
pub(super) enum Walks {
    Forward(Vec<(Vec<TangentStep>, [Tangent; 3])>),
    Reverse([(Adjoint, Vec<AdjointStep>); 3]),
}

/// Buffers of a sweep, reused for all blocks of a program.
pub(super) struct SweepWorkspace {
    /// Values, by the rows of the plan.
    values: Vec<Quarter>,
    /// Derivative of every step with respect to its first operand.
    by_a: Vec<Quarter>,
    /// Derivative of every step with respect to its second operand.
    by_b: Vec<Quarter>,
    /// For every step its adjoint of one channel, or its tangent of one constant.
    carried: Vec<Quarter>,
    /// [channel][constant]: derivatives of the results g in the current quarter.
    jacobian: Vec<Quarter>,
    /// [constant][quarter][channel]: columns of the Jacobian of the residuals of the block.
    columns: Vec<Quarter>,
    /// [quarter][channel]: residuals of the block.
    residuals: [Quarter; COLUMN],
}

impl SweepWorkspace {
    pub(super) fn new(plan: &Plan<'_>) -> Self {
        let (constants, steps) = (plan.constants, plan.steps.len());
        let mut values = vec![ZERO; plan.first_step() + steps];
        for (row, constant) in values.iter_mut().zip(plan.program.constants()) {
            row.0.fill(constant.canonical);
        }
        Self {
            values,
            by_a: vec![ZERO; steps],
            by_b: vec![ZERO; steps],
            carried: vec![ZERO; steps],
            jacobian: vec![ZERO; 3 * constants],
            columns: vec![ZERO; COLUMN * constants],
            residuals: [ZERO; COLUMN],
        }
    }
}

/// Kernel that computes the normal equations of one block of samples.
pub(super) struct Sweep<'a> {
    pub(super) plan: &'a Plan<'a>,
    pub(super) walks: &'a Walks,
    pub(super) target: &'a FitnessTarget,
    pub(super) block: usize,
    pub(super) workspace: &'a mut SweepWorkspace,
}

impl SimdKernel for Sweep<'_> {
    type Output = NormalEquations;

    #[inline(always)]
    fn run(mut self) -> NormalEquations {
        let start = self.block * BLOCK;
        let quarters = (self.target.samples() - start).div_ceil(LANES).min(QUARTERS);
        for quarter in 0..quarters {
            self.read(start + quarter * LANES);
            self.forwards();
            match self.walks {
                Walks::Forward(walks) => self.tangents(walks),
                Walks::Reverse(walks) => self.adjoints(walks),
            }
            self.residuals(quarter);
        }
        self.accumulate(quarters)
    }
}

impl Sweep<'_> {
    /// Loads the inputs of the quarter that begins at the sample `start`.
    #[inline(always)]
    fn read(&mut self, start: usize) {
        let rows = &mut self.workspace.values[self.plan.constants..];
        for (input, row) in self.plan.inputs.iter().zip(rows) {
            let values = &self.target.set().input(*input)[start..];
            let count = values.len().min(LANES);
            row.0[..count].copy_from_slice(&values[..count]);
            // Lanes beyond the last sample have weight 0, so any value will do.
            row.0[count..].fill(values[count - 1]);
        }
    }

    /// Computes the values of all steps, and the derivatives of active ones with respect to their
    /// operands.
    #[inline(always)]
    fn forwards(&mut self) {
        let first_step = self.plan.first_step();
        let SweepWorkspace { values, by_a, by_b, .. } = &mut *self.workspace;
        for (index, step) in self.plan.steps.iter().enumerate() {
            let (before, rest) = values.split_at_mut(first_step + index);
            let (a, b) = (&before[step.a], &before[step.b]);
            value(step, a, b, &mut rest[0]);
            if step.is_active {
                partial_derivatives(
                    step.operation,
                    [a, b, &rest[0]],
                    &mut by_a[index],
                    &mut by_b[index],
                );
            }
        }
    }

    /// Computes the derivatives of g in forward mode.
    #[inline(always)]
    fn tangents(&mut self, walks: &[(Vec<TangentStep>, [Tangent; 3])]) {
        let constants = self.plan.constants;
        let SweepWorkspace { by_a, by_b, carried, jacobian, .. } = &mut *self.workspace;
        for (constant, (walk, results)) in walks.iter().enumerate() {
            for step in walk {
                let (before, rest) = carried.split_at_mut(step.step);
                let (by_a, by_b) = (&by_a[step.step], &by_b[step.step]);
                let out = &mut rest[0];
                match (tangent(before, step.a), tangent(before, step.b)) {
                    (Some(a), Some(b)) => {
                        for lane in 0..LANES {
                            out.0[lane] = a.0[lane] * by_a.0[lane] + b.0[lane] * by_b.0[lane];
                        }
                    }
                    (Some(a), None) => multiply(out, a, by_a),
                    (None, Some(b)) => multiply(out, b, by_b),
                    (None, None) => *out = ZERO,
                }
            }
            for (channel, result) in results.iter().enumerate() {
                let found = tangent(carried, *result);
                jacobian[channel * constants + constant] = *found.unwrap_or(&ZERO);
            }
        }
    }

    /// Computes the derivatives of g in reverse mode.
    #[inline(always)]
    fn adjoints(&mut self, walks: &[(Adjoint, Vec<AdjointStep>); 3]) {
        let constants = self.plan.constants;
        let SweepWorkspace { by_a, by_b, carried, jacobian, .. } = &mut *self.workspace;
        jacobian.fill(ZERO);
        for (channel, (result, walk)) in walks.iter().enumerate() {
            let jacobian = &mut jacobian[channel * constants..(channel + 1) * constants];
            propagate(*result, [&ONE, &ONE], carried, jacobian);
            for step in walk {
                let (before, rest) = carried.split_at_mut(step.step);
                let adjoint = &rest[0];
                propagate(step.a, [adjoint, &by_a[step.step]], before, jacobian);
                propagate(step.b, [adjoint, &by_b[step.step]], before, jacobian);
            }
        }
    }

    /// Computes the residuals of a quarter, and their derivatives from those of g by the chain
    /// rule: loss, output stage, square.
    #[inline(always)]
    fn residuals(&mut self, quarter: usize) {
        let Self { plan, target, block, workspace, .. } = self;
        let SweepWorkspace { values, jacobian, columns, residuals, .. } = &mut **workspace;
        let functions = std::hint::black_box(Functions::KNOWN);
        let rows = target.quarter(*block * QUARTERS + quarter);
        let g = plan.results.map(|row| &values[row]);
        let mut f = [ZERO; 3];
        let layers = plan.layers(*block * BLOCK + quarter * LANES);
        reflectance(plan.program, g.map(|g| &g.0), layers, &mut f);
        for channel in 0..3 {
            let (f, value, weight) = (&f[channel].0, &rows[channel].0, &rows[3 + channel].0);
            let residual = &mut residuals[3 * quarter + channel].0;
            let mut loss_derivative = ZERO;
            match target.loss() {
                Loss::Logarithmic => {
                    for lane in 0..LANES {
                        let t = 1.0 + f[lane] * weight[lane];
                        residual[lane] = functions.log2(t) - value[lane];
                        loss_derivative.0[lane] = weight[lane] / (std::f32::consts::LN_2 * t);
                    }
                }
                Loss::Squared => {
                    for lane in 0..LANES {
                        residual[lane] = f[lane] * weight[lane] - value[lane];
                        loss_derivative.0[lane] = weight[lane];
                    }
                }
            }
            let mut is_first = true;
            for (k, coefficient) in plan.coefficients[channel].into_iter().enumerate() {
                if coefficient.abs() <= 0.0 {
                    continue;
                }
                // Derivative of the residual with respect to g of channel k.
                let mut by_g = ZERO;
                for lane in 0..LANES {
                    by_g.0[lane] = loss_derivative.0[lane] * (2.0 * coefficient) * g[k].0[lane];
                }
                for constant in 0..plan.constants {
                    let column = &mut columns[constant * COLUMN + 3 * quarter + channel];
                    let derivative = &jacobian[k * plan.constants + constant];
                    match is_first {
                        true => multiply(column, &by_g, derivative),
                        false => add_product(column, &by_g, derivative),
                    }
                }
                is_first = false;
            }
            if is_first {
                for constant in 0..plan.constants {
                    columns[constant * COLUMN + 3 * quarter + channel] = ZERO;
                }
            }
        }
    }

    /// Returns the normal equations of the block: dot products of columns and residuals.
    #[inline(always)]
    fn accumulate(&self, quarters: usize) -> NormalEquations {
        let constants = self.plan.constants;
        let mut equations = NormalEquations::zero(constants);
        let residuals = &self.workspace.residuals[..3 * quarters];
        let column = |index: usize| &self.workspace.columns[index * COLUMN..][..3 * quarters];
        equations.sum = dot(residuals, residuals);
        for first in 0..constants {
            let a = column(first);
            equations.gradient[first] = dot(a, residuals);
            for second in 0..=first {
                let value = dot(a, column(second));
                equations.matrix[first * constants + second] = value;
                equations.matrix[second * constants + first] = value;
            }
        }
        equations
    }
}

/// Returns the values of a tangent, or `None` for 0.
#[inline(always)]
fn tangent(carried: &[Quarter], tangent: Tangent) -> Option<&Quarter> {
    match tangent {
        Tangent::Zero => None,
        Tangent::One => Some(&ONE),
        Tangent::Step(step) => Some(&carried[step]),
    }
}

/// Adds the product of an adjoint and a derivative to the adjoint of an operand.
#[inline(always)]
fn propagate(
    to: Adjoint,
    [adjoint, derivative]: [&Quarter; 2],
    carried: &mut [Quarter],
    jacobian: &mut [Quarter],
) {
    match to {
        Adjoint::Nowhere => {}
        Adjoint::Constant(constant) => add_product(&mut jacobian[constant], adjoint, derivative),
        Adjoint::Step { step, is_first: true } => multiply(&mut carried[step], adjoint, derivative),
        Adjoint::Step { step, is_first: false } => {
            add_product(&mut carried[step], adjoint, derivative)
        }
    }
}

#[inline(always)]
fn multiply(out: &mut Quarter, a: &Quarter, b: &Quarter) {
    for ((out, a), b) in out.0.iter_mut().zip(&a.0).zip(&b.0) {
        *out = a * b;
    }
}

#[inline(always)]
fn add_product(out: &mut Quarter, a: &Quarter, b: &Quarter) {
    for ((out, a), b) in out.0.iter_mut().zip(&a.0).zip(&b.0) {
        *out += a * b;
    }
}

/// Computes the value of a step in each lane.
#[inline(always)]
fn value(step: &PlannedStep, a: &Quarter, b: &Quarter, out: &mut Quarter) {
    for_known!(step.operation, operation => apply(operation, a, b, out));
}

#[inline(always)]
fn apply(operation: Operation, a: &Quarter, b: &Quarter, out: &mut Quarter) {
    for ((out, a), b) in out.0.iter_mut().zip(&a.0).zip(&b.0) {
        *out = operation.apply(*a, *b);
    }
}

/// Computes the derivatives of a step with respect to its operands, given these and its value.
#[inline(always)]
fn partial_derivatives(
    operation: Operation,
    known: [&Quarter; 3],
    by_a: &mut Quarter,
    by_b: &mut Quarter,
) {
    for_known!(operation, operation => partial_rows(operation, known, by_a, by_b));
}

#[inline(always)]
fn partial_rows(
    operation: Operation,
    [a, b, value]: [&Quarter; 3],
    by_a: &mut Quarter,
    by_b: &mut Quarter,
) {
    for lane in 0..LANES {
        (by_a.0[lane], by_b.0[lane]) = partials(operation, a.0[lane], b.0[lane], value.0[lane]);
    }
}

/// Returns the dot product: 32 partial sums in f32, which are added pairwise in f64.
#[inline(always)]
fn dot(a: &[Quarter], b: &[Quarter]) -> f64 {
    let mut sums = [0.0f32; PARTIAL_SUMS];
    for (a, b) in a.iter().zip(b) {
        let pairs = a.0.as_chunks::<PARTIAL_SUMS>().0.iter().zip(b.0.as_chunks::<PARTIAL_SUMS>().0);
        for (a, b) in pairs {
            for lane in 0..PARTIAL_SUMS {
                sums[lane] += a[lane] * b[lane];
            }
        }
    }
    let mut wide = [0.0f64; PARTIAL_SUMS];
    for (wide, sum) in wide.iter_mut().zip(sums) {
        *wide = f64::from(sum);
    }
    pairwise_sum(wide)
}
