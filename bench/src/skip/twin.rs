//! Neutral twins: mutants with the program of their parent need no picture of their own and are
//! redrawn.

use anyhow::Result;
use brood_genome::{BirthKey, Genome, Variation};
use brood_program::Program;

use super::kept::picture_ms;
use super::{Saving, Workload};
use crate::measure::{fastest_ms, genomes};

/// Amounts of mutation, from small to large.
const AMOUNTS: [f32; 3] = [0.02, 0.1, 0.3];
/// Number of mutants of each parent.
const MUTANTS: u32 = 50;
/// Largest number of parents.
const PARENTS: u32 = 40;

/// Measures the pictures that twins save, by amount of mutation.
pub fn measure(workload: &Workload) -> Result<Vec<Saving>> {
    let parents = genomes(workload.seed, workload.genomes.min(PARENTS));
    let programs: Vec<Program> = parents.iter().take(10).map(Program::lower).collect();
    let picture_ms = picture_ms(workload, &programs)?;
    let mut savings = Vec::new();
    for amount in AMOUNTS {
        let draw = || Ok(neutral(&parents, amount, workload.seed));
        let (draw_ms, neutral) = fastest_ms(workload.repeats.min(2), draw)?;
        let drawn = u64::from(MUTANTS) * parents.len() as u64;
        savings.push(Saving {
            name: format!("neutral twins, mutation {amount}"),
            counted: "pictures of mutants drawn",
            without: drawn,
            with: drawn - neutral,
            timed: "births, lowering, hashes, and pictures of all or of all but twins",
            without_ms: draw_ms + drawn as f64 * picture_ms,
            with_ms: draw_ms + (drawn - neutral) as f64 * picture_ms,
            percent_same: 100.0,
        });
    }
    Ok(savings)
}

/// Number of mutants with the program of their parent.
fn neutral(parents: &[Genome], amount: f32, seed: u64) -> u64 {
    let of_parent = |parent: &Genome| {
        let hash = Program::lower(parent).hash();
        let variation = Variation::mutate(parent, amount);
        let mutant = |slot| variation.birth(BirthKey { seed, slot, attempt: 0 });
        (0..MUTANTS).filter(|slot| Program::lower(&mutant(*slot)).hash() == hash).count() as u64
    };
    parents.iter().map(of_parent).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn small_mutations_are_neutral_more_often_than_large_ones() {
        let parents = genomes(1, 4);
        let [small, middle, large] = AMOUNTS.map(|amount| neutral(&parents, amount, 1));
        assert!(small > middle && middle > large, "{small} {middle} {large}");
    }
}
