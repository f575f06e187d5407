//! Formulas of models for one lane, and the loops that run them over all lanes.
//!
//! A formula has no branch that depends on the lane, so that the loops become vector instructions.
//! Choices that a model makes once are types, so they are no branches in the loop either. A block
//! of one lane computes the reference.

use glam::DVec3;

use crate::block::Half;
use crate::{Block, Elementary, Loop, Machine};

/// Formula of one lane.
pub(super) trait Formula {
    /// `f64` or a colour.
    type Value;

    /// Returns the value of lane `k`, whose directions are those of `half`. Implementations
    /// must be `#[inline(always)]`.
    fn at<F: Elementary>(&self, half: &Half, k: usize) -> Self::Value;
}

/// Evaluates a scalar formula in each lane. Values of unlit lanes are meaningless.
pub(super) fn scalars<const N: usize>(
    machine: impl Machine,
    block: &Block<N>,
    formula: impl Formula<Value = f64>,
) -> [f64; N] {
    machine.run(Scalars { block, formula })
}

/// Evaluates a colour formula in each lane. Returns red, green and blue; 0 in unlit lanes.
pub(super) fn colors<const N: usize>(
    machine: impl Machine,
    block: &Block<N>,
    formula: impl Formula<Value = DVec3>,
) -> [[f64; N]; 3] {
    machine.run(Colors { block, formula })
}

struct Scalars<'a, P, const N: usize> {
    block: &'a Block<N>,
    formula: P,
}

impl<P: Formula<Value = f64>, const N: usize> Loop for Scalars<'_, P, N> {
    type Values = [f64; N];

    #[inline(always)]
    fn run<F: Elementary>(self) -> [f64; N] {
        let mut values = [0.0; N];
        for (k, value) in values.iter_mut().enumerate() {
            *value = self.formula.at::<F>(&self.block.half(k), k);
        }
        values
    }
}

struct Colors<'a, P, const N: usize> {
    block: &'a Block<N>,
    formula: P,
}

impl<P: Formula<Value = DVec3>, const N: usize> Loop for Colors<'_, P, N> {
    type Values = [[f64; N]; 3];

    #[inline(always)]
    fn run<F: Elementary>(self) -> [[f64; N]; 3] {
        let mut values = [[0.0; N]; 3];
        #[expect(
            clippy::needless_range_loop,
            reason = "zipped rows are not vectorised: twice as slow"
        )]
        for k in 0..N {
            let value = self.formula.at::<F>(&self.block.half(k), k);
            values[0][k] = self.block.where_lit(k, value.x);
            values[1][k] = self.block.where_lit(k, value.y);
            values[2][k] = self.block.where_lit(k, value.z);
        }
        values
    }
}
