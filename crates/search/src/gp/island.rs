//! An island: one of several populations that breed separately, except for migrants.

use std::collections::HashSet;

use brood_genome::{BirthKey, Genome};
use brood_program::ProgramHash;
use rayon::prelude::*;

use super::breed::Breeder;
use super::cases::Cases;
use super::evaluate::{BareGenome, Member, evaluate};
use super::population::Population;
use super::tune::tuned;

/// Members with more operations are tuned in smaller numbers and by fewer steps.
const MANY: u32 = 120;
/// An improvement by less than this share does not count.
const IMPROVEMENT: f64 = 1e-3;

/// A population.
#[derive(Debug, Clone, Default)]
pub(super) struct Island {
    /// Members, the least sum first; no two have the same program.
    pub(super) members: Vec<Member>,
    /// Number of generations without an improvement.
    pub(super) stale: u32,
}

/// State of the search that an island reads.
pub(super) struct IslandContext<'a> {
    pub(super) cases: &'a Cases,
    pub(super) population: &'a Population,
    /// Programs that were evaluated before, on any island, and are skipped.
    pub(super) seen: &'a HashSet<ProgramHash>,
    pub(super) seed: u64,
    pub(super) generation: u32,
    /// First slot of this island.
    pub(super) slot: u32,
}

/// Counts of one generation of an island.
#[derive(Default)]
pub(super) struct GenerationCounts {
    pub(super) evaluations: u64,
    /// Number of candidates whose program had been evaluated before.
    pub(super) repeats: u64,
    /// Hashes of the programs that were evaluated for the first time.
    pub(super) hashes: Vec<ProgramHash>,
}

impl IslandContext<'_> {
    fn key(&self, index: u32) -> BirthKey {
        BirthKey { seed: self.seed, slot: self.slot + index, attempt: self.generation }
    }
}

impl Island {
    /// Restarts the island with the genomes of `given`, and with [`Population::first`] genomes that
    /// `first` draws. Does not skip programs that were evaluated before.
    pub(super) fn start(
        &mut self,
        context: &IslandContext<'_>,
        given: &[Genome],
        first: impl Fn(BirthKey) -> Genome + Sync,
    ) -> GenerationCounts {
        let drawn =
            (0..context.population.first).into_par_iter().map(|index| first(context.key(index)));
        let mut genomes = given.to_vec();
        genomes.par_extend(drawn);
        (self.members, self.stale) = (Vec::new(), 0);
        self.add_evaluated(genomes, (context.cases, context.population), &HashSet::new())
    }

    /// Runs one generation.
    pub(super) fn step(&mut self, context: &IslandContext<'_>) -> GenerationCounts {
        let before = self.least();
        let breeder = Breeder::new(&self.members, context.cases, context.population);
        let slots = 0..context.population.children;
        let children: Vec<Genome> =
            slots.into_par_iter().map(|index| breeder.child(context.key(index))).collect();
        let mut counts =
            self.add_evaluated(children, (context.cases, context.population), context.seen);
        counts.evaluations += self.tune(context);
        let is_better = self.least() < (1.0 - IMPROVEMENT) * before;
        self.stale = if is_better { 0 } else { self.stale + 1 };
        counts
    }

    /// Least sum of any member; infinite if there are no members.
    pub(super) fn least(&self) -> f64 {
        self.members.first().map_or(f64::INFINITY, |member| member.sum)
    }

    /// Adds a member of another island.
    pub(super) fn add_migrant(&mut self, member: Member, population: &Population) {
        self.members.push(member);
        self.sort_and_truncate(population.kept);
    }

    /// Evaluates a genome of another search, and adds it.
    pub(super) fn immigrate(
        &mut self,
        genome: Genome,
        cases: &Cases,
        population: &Population,
    ) -> GenerationCounts {
        self.add_evaluated(vec![genome], (cases, population), &HashSet::new())
    }

    /// Evaluates the genomes whose programs are neither in `seen` nor in the island, and keeps the
    /// best members.
    fn add_evaluated(
        &mut self,
        genomes: Vec<Genome>,
        (cases, population): (&Cases, &Population),
        seen: &HashSet<ProgramHash>,
    ) -> GenerationCounts {
        let mut known: HashSet<ProgramHash> =
            self.members.iter().map(|member| member.hash).collect();
        let mut bare = BareGenome::of(genomes);
        let bred = bare.len();
        bare.retain(|bare| !seen.contains(&bare.hash) && known.insert(bare.hash));
        let hashes: Vec<ProgramHash> = bare.iter().map(|bare| bare.hash).collect();
        let kept = population.kept;
        let worst = self.members.get(kept - 1).map_or(f64::INFINITY, |worst| worst.sum);
        self.members.extend(evaluate(bare, cases, (kept, worst)));
        self.sort_and_truncate(kept);
        let evaluations = hashes.len() as u64;
        GenerationCounts { evaluations, repeats: bred as u64 - evaluations, hashes }
    }

    /// Tunes the constants of the best untuned members; returns the number of evaluations.
    fn tune(&mut self, context: &IslandContext<'_>) -> u64 {
        let IslandContext {
            cases, population: Population { kept, tuned: most, steps, .. }, ..
        } = *context;
        let untuned = || self.members.iter().filter(|member| !member.is_tuned);
        let is_long = untuned().next().is_some_and(|member| member.operations > MANY);
        let (count, steps) =
            if is_long { (most.div_ceil(3), steps.div_ceil(2)) } else { (*most, *steps) };
        let chosen: Vec<&Member> = untuned().take(count).collect();
        let found: Vec<(Member, u64)> =
            chosen.par_iter().map(|member| tuned(member, cases, steps)).collect();
        let mut evaluations = 0;
        for (member, count) in found {
            evaluations += count;
            let hash = |genome: &Genome| BareGenome::of(vec![genome.clone()])[0].hash;
            let before = member.hash;
            let now = Member { hash: hash(&member.genome), ..member };
            self.members.retain(|other| other.hash != before);
            self.members.push(now);
        }
        self.sort_and_truncate(*kept);
        evaluations
    }

    /// Sorts the members by sum, drops duplicate programs and keeps `kept` members.
    fn sort_and_truncate(&mut self, kept: usize) {
        self.members.sort_by(|a, b| {
            a.sum.total_cmp(&b.sum).then_with(|| a.hash.as_bytes().cmp(b.hash.as_bytes()))
        });
        let mut known = HashSet::new();
        self.members.retain(|member| known.insert(member.hash));
        self.members.truncate(kept);
    }
}
