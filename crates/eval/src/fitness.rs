//! Fitness: how far programs are from a target, summed inside the evaluator.
//!
//! Nothing but one number for each program leaves the innermost cache. Errors are not negative, so evaluation may end as
//! soon as the sum passes a bound, and what ends early would not have been within it: selection is the same.
//!
//! # The sum
//! Error of a sample: e = (dr^2 + dg^2) + db^2, where d is log2(1 + f w) - t or f w - t, every operation rounded to f32
//! on its own. Sum of a block of 256 samples, the missing ones of the last counting as 0: sums 0 to 15 take every
//! sixteenth error in turn, then sum k takes sum k + 8, then k + 4, k + 2, k + 1, all in f32. The blocks are added in f64
//! in their order. Whoever adds like that, on whatever machine and with how many threads, gets the same bits.

mod difficulty;
mod population;
mod select;
mod target;

pub use population::CanonicalPopulation;
pub use select::{Ranked, Screening, Selected, select_best};
pub use target::{FitnessTarget, Loss, TargetError};

use std::ops::Range;

use brood_program::Program;

use crate::{CanonicalEvaluator, EvalError};

/// What is known of the error of one program.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Fitness {
    /// Sum of squared differences over the samples seen, in the units of the [`Loss`]. Infinite where a weighted
    /// reflectance leaves f32.
    pub sum: f64,
    /// Blocks of samples seen, from the first.
    pub blocks: usize,
}

/// Programs bound to a target, each evaluated as far as was asked for.
pub trait Population {
    /// What is known of each program.
    fn fitness(&self) -> &[Fitness];

    /// Goes on with the programs of these indices through the blocks of `range`, where it is what comes next for all of
    /// them; a program ends after the block in which its sum passes `bound`.
    ///
    /// # Error
    /// The same to the bit for any number of threads and any order of `programs`.
    fn extend(
        &mut self,
        programs: &[usize],
        range: Range<usize>,
        bound: f64,
    ) -> Result<(), EvalError>;
}

/// Evaluators that can sum errors where they arise.
pub trait FitnessEvaluator: Send + Sync {
    /// Binds programs to a target, nothing being evaluated yet.
    fn population<'a>(
        &'a self,
        programs: &[&'a Program],
        target: &'a FitnessTarget,
    ) -> Box<dyn Population + 'a>;

    /// The sums of all programs over the whole target.
    ///
    /// # Shapes
    /// One number a program, in their order; divide by 3 [`FitnessTarget::samples`] for the mean over samples and channels.
    fn sums(&self, programs: &[&Program], target: &FitnessTarget) -> Result<Vec<f64>, EvalError> {
        let mut population = self.population(programs, target);
        let all: Vec<usize> = (0..programs.len()).collect();
        population.extend(&all, 0..target.blocks(), f64::INFINITY)?;
        Ok(population.fitness().iter().map(|fitness| fitness.sum).collect())
    }
}

impl FitnessEvaluator for CanonicalEvaluator {
    fn population<'a>(
        &'a self,
        programs: &[&'a Program],
        target: &'a FitnessTarget,
    ) -> Box<dyn Population + 'a> {
        Box::new(CanonicalPopulation::new(programs, target, self.level()))
    }
}

#[cfg(test)]
#[path = "fitness/tests.rs"]
mod tests;
