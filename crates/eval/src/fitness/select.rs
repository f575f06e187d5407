//! The best of a population, evaluating as little as decides it.

use brood_program::Program;

use super::{Fitness, FitnessEvaluator, FitnessTarget};
use crate::EvalError;

/// What is left out of a selection.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Screening {
    /// Nothing: every program is evaluated on every sample.
    None,
    /// What can no longer be among the best; the selection is the same.
    Exact,
    /// As exact, after only this share of the programs, those with the least error on the fair samples that a target
    /// begins with ([`FitnessTarget::fair_blocks`]), was let through: the selection may differ.
    Race {
        /// Of 0 to 1; never fewer than are to be selected.
        share: f64,
    },
}

/// A program that was selected.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ranked {
    /// Its index in the population.
    pub program: usize,
    /// Its sum over the whole target.
    pub sum: f64,
}

/// The best, least error first, equal ones in the order of the population; and what it took.
#[derive(Debug, Clone, PartialEq)]
pub struct Selected {
    /// At most as many as were asked for.
    pub best: Vec<Ranked>,
    /// Blocks evaluated, the same whatever the number of threads.
    pub blocks_evaluated: u64,
    /// Blocks of all programs.
    pub blocks: u64,
}

/// Programs of the first wave; each later wave has twice as many, bounded by what the ones before left as the worst of
/// the best.
const FIRST_WAVE: usize = 16;

/// Selects the `count` programs with the least error.
///
/// Every program is evaluated on the first block. In the order of what that gives, waves of programs go on to the end; the
/// best found so far bound the next wave, so that most programs end after a few blocks, and those whose first block
/// alone passes the bound are not gone on with at all. Waves do not depend on threads: neither the selection nor the
/// number of blocks does.
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
        order.truncate(through(programs.len(), share).max(count));
    }
    let (mut best, mut wave) = (Vec::new(), FIRST_WAVE.max(count));
    let mut rest = &order[..];
    while !rest.is_empty() {
        let bound = match screening {
            Screening::Exact | Screening::Race { .. } => bound(&best, count),
            Screening::None => f64::INFINITY,
        };
        // The rest is in the order of what is known of it.
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

/// The worst of the best, once there are enough of them.
fn bound(best: &[Ranked], count: usize) -> f64 {
    match best.last() {
        Some(worst) if best.len() == count => worst.sum,
        _ => f64::INFINITY,
    }
}

fn whole(program: usize, fitness: Fitness, blocks: usize) -> Option<Ranked> {
    (fitness.blocks == blocks).then_some(Ranked { program, sum: fitness.sum })
}

#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "a share of a count is one, whatever the share"
)]
fn through(programs: usize, share: f64) -> usize {
    (programs as f64 * share).ceil() as usize
}
