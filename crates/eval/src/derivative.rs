//! Derivatives of errors with respect to a program's constants, for least squares.
//!
//! A residual is the deviation of one channel of one sample from a [`FitnessTarget`]. Its derivatives go through the
//! program step by step: forwards, one tangent for each constant, or backwards, one adjoint for each channel. Where a
//! clamp acts, the derivative is 0. What comes out is what a damped Gauss-Newton step needs: J^T J and J^T r.

mod local;
mod plan;
mod sweep;

use brood_program::Program;
use rayon::prelude::*;

use crate::{FitnessTarget, Level};
use plan::Plan;
use sweep::{Room, Sweep, Walks};

/// In which direction derivatives are carried through a program. Both give the same up to rounding.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Direction {
    /// A tangent of every step that a constant changes, for each constant: cheap for few constants.
    Forward,
    /// An adjoint of every step for each channel: its cost does not grow with the constants.
    Reverse,
}

impl Direction {
    /// The one that is faster for that many constants, by `brood bench derivative` on one thread of a Zen 3, forward and
    /// reverse in microseconds a program: 41 and 43 for 2 constants, 283 and 303 for 5 to 8, 723 and 661 for 9 to 16, 3507
    /// and 2536 for 33 to 44. Random programs change in few steps with each constant, which is what forward walks.
    #[must_use]
    pub fn faster(constants: usize) -> Self {
        if constants <= 8 { Self::Forward } else { Self::Reverse }
    }
}

/// J^T J and J^T r over all residuals of a target.
#[derive(Debug, Clone, PartialEq)]
pub struct NormalEquations {
    /// Constants of the program: n.
    pub constants: usize,
    /// J^T J, row by row, n x n, symmetric.
    pub matrix: Vec<f64>,
    /// J^T r, n long.
    pub gradient: Vec<f64>,
    /// r^T r.
    pub sum: f64,
}

impl NormalEquations {
    fn zero(constants: usize) -> Self {
        let (matrix, gradient) = (vec![0.0; constants * constants], vec![0.0; constants]);
        Self { constants, matrix, gradient, sum: 0.0 }
    }

    fn add(&mut self, other: &Self) {
        for (sum, value) in self.matrix.iter_mut().zip(&other.matrix) {
            *sum += value;
        }
        for (sum, value) in self.gradient.iter_mut().zip(&other.gradient) {
            *sum += value;
        }
        self.sum += other.sum;
    }
}

/// The normal equations of a program's constants ([`Program::constants`], in their order) against a target.
///
/// # Error
/// Values and derivatives are f32, each 24 products that are added first are f32, everything above is f64 in a fixed
/// order: the same to the bit for any number of threads. Against derivatives in f64: at most 1e-4 of the largest entry
/// (`derivatives_agree_with_those_in_f64`).
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
            || Room::new(plan),
            |room, block| level.run(Sweep { plan, walks, target, block, room }),
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
