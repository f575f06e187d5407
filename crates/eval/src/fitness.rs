//! Fitness: error of programs against a target, summed inside the evaluator.
//!
//! Only one number per program leaves the L1 cache. Errors are not negative, so a program can be
//! dropped as soon as its sum exceeds that of the worst program to be kept; the selection stays the
//! same.
//!
//! # The sum
//! Error of a sample: e = (dr^2 + dg^2) + db^2, where d of a channel is log2(1 + f w) - t or f w -
//! t, depending on the [`Loss`], with reflectance f, weight w and value to reach t. Every operation
//! is rounded to f32 separately. Sum of a block of 256 samples, where the missing samples of the
//! last block count as 0: sums 0 to 15 take every sixteenth error in turn, then sum k takes sum k +
//! 8, then k + 4, k + 2, k + 1, all in f32. The blocks are added in f64 in their order. Every
//! implementation that adds in this order gets the same bits, on any machine and with any number of
//! threads.

mod difficulty;
mod evaluator;
mod loss;
mod population;
mod select;
mod target;

pub use evaluator::{Fitness, FitnessEvaluator, FitnessPopulation};
pub use loss::Loss;
pub use population::CanonicalPopulation;
pub use select::{Ranked, Screening, Selected, select_best};
pub use target::{FitnessTarget, TargetError};

#[cfg(test)]
#[path = "fitness/tests.rs"]
mod tests;
