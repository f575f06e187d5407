//! Formulas of models: what is computed of one lane, and the loops that compute it of all.
//!
//! A formula has no branch that depends on the lane, so that the loops become vector instructions; what is chosen once for
//! a model is a type, so that it is no branch in the loop either. With one lane the loop is the formula.

use glam::DVec3;

use crate::block::Half;
use crate::{Block, Elementary, Loop, Machine};

/// What is computed of a lane.
pub(super) trait Formula {
    /// A number or a colour.
    type Value;

    /// The value of lane `k`, whose directions are those of `half`. Implementations are inlined into the loops.
    fn at<F: Elementary>(&self, half: &Half, k: usize) -> Self::Value;
}

/// A number of each lane; of those that reflect nothing a meaningless one.
pub(super) fn numbers<const N: usize>(
    machine: impl Machine,
    block: &Block<N>,
    formula: impl Formula<Value = f64>,
) -> [f64; N] {
    machine.run(Numbers { block, formula })
}

/// Red, green and blue of each lane; 0 of those that reflect nothing.
pub(super) fn colors<const N: usize>(
    machine: impl Machine,
    block: &Block<N>,
    formula: impl Formula<Value = DVec3>,
) -> [[f64; N]; 3] {
    machine.run(Colors { block, formula })
}

struct Numbers<'a, P, const N: usize> {
    block: &'a Block<N>,
    formula: P,
}

impl<P: Formula<Value = f64>, const N: usize> Loop for Numbers<'_, P, N> {
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
