//! One of several populations that breed by themselves.

use std::collections::HashSet;

use brood_genome::{BirthKey, Genome};
use brood_program::ProgramHash;
use rayon::prelude::*;

use super::breed::Breeder;
use super::cases::Cases;
use super::judge::{Member, Plain, judge};
use super::population::Population;
use super::tune::tuned;

/// Where operations are more, fewer members are tuned, by fewer steps.
const MANY: u32 = 120;
/// An improvement by less than this share is none.
const IMPROVEMENT: f64 = 1e-3;

/// A population.
#[derive(Debug, Clone, Default)]
pub(super) struct Island {
    /// The least sum first, no two of the same program.
    pub(super) members: Vec<Member>,
    /// Generations without an improvement.
    pub(super) stale: u32,
}

/// What an island reads of the search it belongs to.
pub(super) struct Surroundings<'a> {
    pub(super) cases: &'a Cases,
    pub(super) population: &'a Population,
    pub(super) seen: &'a HashSet<ProgramHash>,
    pub(super) seed: u64,
    pub(super) generation: u32,
    /// Slots from here on are this island's.
    pub(super) slot: u32,
}

/// What a generation of an island took.
#[derive(Default)]
pub(super) struct Taken {
    pub(super) evaluations: u64,
    /// Candidates whose program had been there before.
    pub(super) repeats: u64,
    /// Programs that were held against the samples for the first time.
    pub(super) hashes: Vec<ProgramHash>,
}

impl Surroundings<'_> {
    fn key(&self, index: u32) -> BirthKey {
        BirthKey { seed: self.seed, slot: self.slot + index, attempt: self.generation }
    }
}

impl Island {
    /// Begins again, with what `first` draws and those of `given`.
    pub(super) fn start(
        &mut self,
        around: &Surroundings<'_>,
        given: &[Genome],
        first: impl Fn(BirthKey) -> Genome + Sync,
    ) -> Taken {
        let drawn =
            (0..around.population.first).into_par_iter().map(|index| first(around.key(index)));
        let mut genomes = given.to_vec();
        genomes.par_extend(drawn);
        (self.members, self.stale) = (Vec::new(), 0);
        self.join(genomes, around, &HashSet::new())
    }

    /// One generation.
    pub(super) fn step(&mut self, around: &Surroundings<'_>) -> Taken {
        let before = self.least();
        let breeder = Breeder::new(&self.members, around.cases, around.population);
        let slots = 0..around.population.children;
        let children: Vec<Genome> =
            slots.into_par_iter().map(|index| breeder.child(around.key(index))).collect();
        let mut taken = self.join(children, around, around.seen);
        taken.evaluations += self.tune(around);
        let is_better = self.least() < (1.0 - IMPROVEMENT) * before;
        self.stale = if is_better { 0 } else { self.stale + 1 };
        taken
    }

    /// The least sum.
    pub(super) fn least(&self) -> f64 {
        self.members.first().map_or(f64::INFINITY, |member| member.sum)
    }

    /// Takes in a member of another island.
    pub(super) fn welcome(&mut self, member: Member, population: &Population) {
        self.members.push(member);
        self.settle(population.kept);
    }

    fn join(
        &mut self,
        genomes: Vec<Genome>,
        around: &Surroundings<'_>,
        seen: &HashSet<ProgramHash>,
    ) -> Taken {
        let mut known: HashSet<ProgramHash> =
            self.members.iter().map(|member| member.hash).collect();
        let mut plain = Plain::of(genomes);
        let bred = plain.len();
        plain.retain(|plain| !seen.contains(&plain.hash) && known.insert(plain.hash));
        let hashes: Vec<ProgramHash> = plain.iter().map(|plain| plain.hash).collect();
        self.members.extend(judge(plain, around.cases, around.population.kept));
        self.settle(around.population.kept);
        let evaluations = hashes.len() as u64;
        Taken { evaluations, repeats: bred as u64 - evaluations, hashes }
    }

    /// Tunes the best that have not been yet.
    fn tune(&mut self, around: &Surroundings<'_>) -> u64 {
        let Surroundings { cases, population: Population { kept, tuned: most, steps, .. }, .. } =
            *around;
        let untuned = || self.members.iter().filter(|member| !member.is_tuned);
        let is_long = untuned().next().is_some_and(|member| member.operations > MANY);
        let (count, steps) = if is_long { (most / 3, steps / 2) } else { (*most, *steps) };
        let chosen: Vec<&Member> = untuned().take(count).collect();
        let found: Vec<(Member, u64)> =
            chosen.par_iter().map(|member| tuned(member, cases, steps)).collect();
        let mut tries = 0;
        for (member, count) in found {
            tries += count;
            let hash = |genome: &Genome| Plain::of(vec![genome.clone()])[0].hash;
            let before = member.hash;
            let now = Member { hash: hash(&member.genome), ..member };
            self.members.retain(|other| other.hash != before);
            self.members.push(now);
        }
        self.settle(*kept);
        tries
    }

    fn settle(&mut self, kept: usize) {
        self.members.sort_by(|a, b| {
            a.sum.total_cmp(&b.sum).then_with(|| a.hash.as_bytes().cmp(b.hash.as_bytes()))
        });
        let mut known = HashSet::new();
        self.members.retain(|member| known.insert(member.hash));
        self.members.truncate(kept);
    }
}
