//! The traits of evaluators that sum errors themselves.

use std::ops::Range;

use brood_program::Program;

use super::target::FitnessTarget;
use crate::evaluator::{EvalError, EvalResult};

/// Known part of the error of one program.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Fitness {
    /// Sum of squared differences over the samples evaluated so far, in the units of the
    /// [`crate::Loss`]. Infinite if a weighted reflectance exceeds f32.
    pub sum: f64,
    /// Number of blocks of samples evaluated, from the first.
    pub blocks: usize,
}

/// Programs bound to a target, each evaluated as far as requested.
pub trait FitnessPopulation {
    /// Returns the known part of the error of each program.
    fn fitness(&self) -> &[Fitness];

    /// Evaluates the programs of these indices on the blocks of `range`, which must be the next
    /// blocks for all of them. A program ends after the block in which its sum exceeds `bound`.
    ///
    /// # Error
    /// The same to the bit for any number of threads and any order of `programs`.
    ///
    /// # Errors
    /// As [`crate::Evaluator::eval`].
    fn extend(&mut self, programs: &[usize], range: Range<usize>, bound: f64) -> EvalResult;
}

/// Evaluators that can sum errors without returning reflectances.
pub trait FitnessEvaluator: Send + Sync {
    /// Binds programs to a target; nothing is evaluated yet.
    fn population<'a>(
        &'a self,
        programs: &[&'a Program],
        target: &'a FitnessTarget,
    ) -> Box<dyn FitnessPopulation + 'a>;

    /// Returns the sums of all programs over the whole target.
    ///
    /// # Shapes
    /// One number per program, in their order; divide by 3 [`FitnessTarget::samples`] for the mean
    /// over samples and channels.
    ///
    /// # Errors
    /// As [`crate::Evaluator::eval`].
    fn sums(&self, programs: &[&Program], target: &FitnessTarget) -> Result<Vec<f64>, EvalError> {
        let mut population = self.population(programs, target);
        let all: Vec<usize> = (0..programs.len()).collect();
        population.extend(&all, 0..target.blocks(), f64::INFINITY)?;
        Ok(population.fitness().iter().map(|fitness| fitness.sum).collect())
    }
}
