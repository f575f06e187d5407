//! Derivatives of errors with respect to the constants of a program, for least squares.
//!
//! A residual is the deviation of one channel of one sample from a [`FitnessTarget`]; r is the
//! vector of all residuals, J the matrix of their derivatives with respect to the constants.
//! Derivatives are propagated through the program step by step: forward mode, one tangent per
//! constant, or reverse mode, one adjoint per channel. Where a clamp acts, the derivative is 0. The
//! result is the input of a damped Gauss-Newton step: J^T J and J^T r.

mod equations;
mod local;
mod plan;
mod sweep;

use brood_brdf::Level;
use brood_program::Program;
use rayon::prelude::*;

use crate::fitness::FitnessTarget;
pub use equations::NormalEquations;
use plan::Plan;
use sweep::{Sweep, SweepWorkspace, Walks};

/// Mode of differentiation. Both give the same up to rounding.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Direction {
    /// Forward mode: for each constant a tangent of every step that depends on it. Cheap for few
    /// constants.
    Forward,
    /// Reverse mode: for each channel an adjoint of every step. The cost does not grow with the
    /// number of constants.
    Reverse,
}

impl Direction {
    /// Returns the faster mode for that many constants. Measured with `brood bench derivative` on
    /// one thread of a Zen 3, forward and reverse in microseconds per program: 41 and 43 for 2
    /// constants, 283 and 303 for 5 to 8, 723 and 661 for 9 to 16, 3507 and 2536 for 33 to 44. In
    /// random programs few steps depend on each constant, and forward mode visits only those.
    #[must_use]
    pub fn faster(constants: usize) -> Self {
        if constants <= 8 { Self::Forward } else { Self::Reverse }
    }
}

/// Returns the normal equations of the constants of a program ([`Program::constants`], in their
/// order) against a target.
///
/// # Error
/// Values, derivatives and partial sums of 24 products are f32; all sums above are f64 in a fixed
/// order: the same to the bit for any number of threads. Against derivatives in f64: at most 1e-4
/// of the largest entry (`derivatives_agree_with_those_in_f64`).
#[must_use]
pub fn normal_equations(
    program: &Program,
    target: &FitnessTarget,
    direction: Direction,
) -> NormalEquations {
    let (plan, level) = (Plan::new(program, target.set()), Level::best());
    let walks = match direction {
        Direction::Forward => Walks::Forward(plan.tangents()),
        Direction::Reverse => Walks::Reverse(plan.adjoints()),
    };
    let (plan, walks) = (&plan, &walks);
    let parts: Vec<NormalEquations> = (0..target.blocks())
        .into_par_iter()
        .map_init(
            || SweepWorkspace::new(plan),
            |workspace, block| level.run(Sweep { plan, walks, target, block, workspace }),
        )
        .collect();
    let mut equations = NormalEquations::zero(plan.constants);
    for part in &parts {
        equations.add(part);
    }
    equations
}

#[cfg(test)]
#[path = "derivative/tests.rs"]
mod tests;
