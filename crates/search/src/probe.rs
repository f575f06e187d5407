//! Statistics of a population after a generation, beyond its best member.

use std::collections::HashSet;
use std::hash::Hash;

use brood_genome::{Genome, Instruction, Model, ModelKind, live_instructions};

/// Statistics of a population after a generation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Probe {
    /// Number of members of all islands.
    pub members: u32,
    /// Median E_log of the members on the training samples; infinite if there are no members.
    pub median: f64,
    /// Number of distinct structures (genomes that differ in more than constants) over the number
    /// of members; 0 if there are no members.
    pub diversity: f64,
    /// Total number of candidates that were not evaluated, because the same program had been.
    pub repeats: u64,
}

impl Probe {
    /// Statistics of genomes with their errors.
    pub(crate) fn of_genomes<'a>(
        members: impl Iterator<Item = (f64, &'a Genome)>,
        repeats: u64,
    ) -> Self {
        Self::of(members.map(|(error, genome)| (error, structure(genome))), repeats)
    }

    /// Statistics of members given as errors and structures; members of the same structure differ
    /// in constants only.
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

/// Structure of a genome without its constants: its models and its live instructions.
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
    fn probe_has_median_and_diversity() {
        let members = [(0.5, 'a'), (0.1, 'b'), (0.3, 'a'), (f64::INFINITY, 'a')];
        let probe = Probe::of(members.into_iter(), 7);
        assert_eq!(probe, Probe { members: 4, median: 0.5, diversity: 0.5, repeats: 7 });
        let nothing = Probe::of([(0.0, 'a'); 0].into_iter(), 0);
        assert_eq!((nothing.median, nothing.diversity), (f64::INFINITY, 0.0));
    }
}
