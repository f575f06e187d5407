//! Selection of the best of a population with as few evaluations as possible.

use brood_program::Program;

use super::evaluator::{Fitness, FitnessEvaluator};
use super::target::FitnessTarget;
use crate::evaluator::EvalError;

/// Evaluations that a selection skips.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Screening {
    /// Skips nothing: every program is evaluated on every sample.
    None,
    /// Skips programs that can no longer be among the best; the selection is the same.
    Exact,
    /// As `Exact`, but first keeps only this share of the programs: those with the least error on
    /// the representative samples at the beginning of the target ([`FitnessTarget::fair_blocks`]).
    /// The selection may differ.
    Race {
        /// Share from 0 to 1; at least as many programs as are to be selected are kept.
        share: f64,
    },
}

/// A selected program.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ranked {
    /// Index in the population.
    pub program: usize,
    /// Sum over the whole target.
    pub sum: f64,
}

/// The best programs, least error first, ties in the order of the population; and the cost.
#[derive(Debug, Clone, PartialEq)]
pub struct Selected {
    /// The selected programs, at most as many as requested.
    pub best: Vec<Ranked>,
    /// Number of blocks evaluated; does not depend on the number of threads.
    pub blocks_evaluated: u64,
    /// Number of blocks of all programs.
    pub blocks: u64,
}

/// Smallest number of programs in the first wave. Each later wave has twice as many as the one
/// before, and its bound is the worst of the best so far.
const FIRST_WAVE: usize = 16;

/// Selects the `count` programs with the least error.
///
/// Every program is evaluated on the first block. In the order of the resulting errors, waves of
/// programs are evaluated to the end. The best found so far bound the next wave, so that most
/// programs end after a few blocks, and programs whose first block alone exceeds the bound are not
/// evaluated further. Waves do not depend on threads, so neither the selection nor the number of
/// blocks does.
///
/// # Errors
/// As [`crate::Evaluator::eval`].
pub fn select_best(
    evaluator: &dyn FitnessEvaluator,
    programs: &[&Program],
    target: &FitnessTarget,
    count: usize,
    screening: Screening,
) -> Result<Selected, EvalError> {
    let blocks = target.blocks();
    let mut population = evaluator.population(programs, target);
    let mut order: Vec<usize> = (0..programs.len()).collect();
    let prefix = match screening {
        Screening::None => 0,
        Screening::Exact => 1.min(blocks),
        Screening::Race { .. } => target.fair_blocks(),
    };
    population.extend(&order, 0..prefix, f64::INFINITY)?;
    let first: Vec<f64> = population.fitness().iter().map(|fitness| fitness.sum).collect();
    order.sort_unstable_by(|a, b| first[*a].total_cmp(&first[*b]).then(a.cmp(b)));
    if let Screening::Race { share } = screening {
        order.truncate(kept_by_race(programs.len(), share).max(count));
    }
    let (mut best, mut wave) = (Vec::new(), FIRST_WAVE.max(count));
    let mut rest = &order[..];
    while !rest.is_empty() {
        let bound = match screening {
            Screening::Exact | Screening::Race { .. } => bound(&best, count),
            Screening::None => f64::INFINITY,
        };
        // The rest is sorted by the known part of the error.
        rest = &rest[..rest.partition_point(|program| first[*program] <= bound)];
        let (now, later) = rest.split_at(wave.min(rest.len()));
        population.extend(now, prefix..blocks, bound)?;
        let found = now.iter().map(|program| (*program, population.fitness()[*program]));
        best.extend(found.filter_map(|(program, fitness)| whole(program, fitness, blocks)));
        best.sort_by(|a, b| a.sum.total_cmp(&b.sum).then(a.program.cmp(&b.program)));
        best.truncate(count);
        (rest, wave) = (later, 2 * wave);
    }
    let evaluated = population.fitness().iter().map(|fitness| fitness.blocks as u64).sum();
    let blocks = (blocks * programs.len()) as u64;
    Ok(Selected { best, blocks_evaluated: evaluated, blocks })
}

/// Returns the error of the worst of the best, once there are `count` of them.
fn bound(best: &[Ranked], count: usize) -> f64 {
    match best.last() {
        Some(worst) if best.len() == count => worst.sum,
        _ => f64::INFINITY,
    }
}

/// Returns the program if it was evaluated on all blocks.
fn whole(program: usize, fitness: Fitness, blocks: usize) -> Option<Ranked> {
    (fitness.blocks == blocks).then_some(Ranked { program, sum: fitness.sum })
}

#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "a share of a count is a count; saturates for other shares"
)]
/// Returns the number of programs that a race keeps.
fn kept_by_race(programs: usize, share: f64) -> usize {
    (programs as f64 * share).ceil() as usize
}
