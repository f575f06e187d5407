//! A generation looked at: what its best does not show.

use std::collections::HashSet;
use std::hash::Hash;

use brood_genome::{Genome, Instruction, Model, ModelKind, live_instructions};

/// How a population stands after a generation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Probe {
    /// Members of all islands.
    pub members: u32,
    /// E_log of the middle one of them on what they are fitted to; infinite where there is none.
    pub median: f64,
    /// How many differ in more than their numbers, over how many there are: 1 where all do, 0 where there is none.
    pub diversity: f64,
    /// Candidates in all that were not held against samples, because the same program had been.
    pub repeats: u64,
}

impl Probe {
    /// Of genomes with their errors.
    pub(crate) fn of_genomes<'a>(
        members: impl Iterator<Item = (f64, &'a Genome)>,
        repeats: u64,
    ) -> Self {
        Self::of(members.map(|(error, genome)| (error, structure(genome))), repeats)
    }

    /// Of members with their errors, and what of them is the same where only numbers differ.
    pub(crate) fn of<S: Hash + Eq>(members: impl Iterator<Item = (f64, S)>, repeats: u64) -> Self {
        let (mut errors, structures): (Vec<f64>, Vec<S>) = members.unzip();
        errors.sort_by(f64::total_cmp);
        let count = errors.len();
        let distinct = structures.into_iter().collect::<HashSet<S>>().len();
        Self {
            members: u32::try_from(count).expect("populations are small"),
            median: errors.get(count / 2).copied().unwrap_or(f64::INFINITY),
            diversity: distinct as f64 / count.max(1) as f64,
            repeats,
        }
    }
}

/// Of a genome what is the same where only numbers differ: its models and the instructions that count.
fn structure(genome: &Genome) -> (Vec<ModelKind>, Vec<Instruction>) {
    let live = live_instructions(genome);
    let code = genome.instructions().iter().zip(live).filter(|(_, is_live)| *is_live);
    let models = genome.layers().iter().map(Model::kind);
    (models.collect(), code.map(|(instruction, _)| *instruction).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_middle_and_the_kinds_are_told() {
        let members = [(0.5, 'a'), (0.1, 'b'), (0.3, 'a'), (f64::INFINITY, 'a')];
        let probe = Probe::of(members.into_iter(), 7);
        assert_eq!(probe, Probe { members: 4, median: 0.5, diversity: 0.5, repeats: 7 });
        let nothing = Probe::of([(0.0, 'a'); 0].into_iter(), 0);
        assert_eq!((nothing.median, nothing.diversity), (f64::INFINITY, 0.0));
    }
}
