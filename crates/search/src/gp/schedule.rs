//! Generations of a genetic search over all islands, migration, and the best candidate.

use std::collections::{HashSet, VecDeque};

use brood_genome::{Dialect, Genome};
use brood_program::{ProgramHash, Tunable};
use brood_target::{Samples, Strategy, metric};

use super::breed::{random, start_mutant};
use super::cases::Cases;
use super::evaluate::{Member, values};
use super::front::Front;
use super::island::{GenerationCounts, Island, IslandContext};
use super::population::Population;
use crate::Probe;
use crate::method::{Candidate, HasTime, Method, Outcome, Progress, ranking_error};

/// Number of slots reserved for an island in a generation.
const SLOTS: u32 = 1 << 16;
/// Number of program hashes kept, so that these programs are not evaluated again.
const SEEN_CAPACITY: usize = 4096;

/// A genetic search.
pub(crate) struct Gp {
    pub(super) seed: u64,
    /// Genomes to start from.
    pub(super) start: Vec<Genome>,
    /// True if every second island starts at random even when there are genomes to start from.
    pub(super) is_mixed: bool,
    pub(super) population: Population,
    pub(super) cases: Cases,
    pub(super) generation: u32,
    pub(super) evaluations: u64,
    pub(super) repeats: u64,
    pub(super) islands: Vec<Island>,
    /// Hashes of programs that were evaluated, the oldest first.
    pub(super) seen: VecDeque<ProgramHash>,
    pub(super) front: Front,
    pub(super) best: Option<Best>,
}

/// Best member by the ranking error; with E_log on the training and on the validation samples.
#[derive(Debug, Clone)]
pub(super) struct Best {
    pub(super) member: Member,
    pub(super) fitted: f64,
    pub(super) held: f64,
}

impl Gp {
    pub(crate) fn new(samples: &Samples, start: &[Genome], seed: u64, is_mixed: bool) -> Self {
        Self { is_mixed, ..Self::of(samples, start, seed, Population::DEFAULT) }
    }

    /// Creates a search with other population parameters.
    pub(crate) fn of(
        samples: &Samples,
        start: &[Genome],
        seed: u64,
        population: Population,
    ) -> Self {
        // Genomes of the search have no limit of their own; members are compared under it.
        let start = start.iter().map(|genome| padded_to_dialect(genome.clone()).with_limit(false));
        Self {
            seed,
            start: start.collect(),
            is_mixed: false,
            population,
            cases: Cases::new(samples, seed),
            generation: 0,
            evaluations: 0,
            repeats: 0,
            islands: vec![Island::default(); population.islands],
            seen: VecDeque::new(),
            front: Front::default(),
            best: None,
        }
    }

    /// Starts an island from the start genomes and mutants of them, or at random.
    fn begin(&self, island: &mut Island, context: &IslandContext<'_>) -> GenerationCounts {
        let is_fresh = self.is_mixed && !(context.slot / SLOTS).is_multiple_of(2);
        let start = if is_fresh { &[] } else { self.start.as_slice() };
        island.start(context, start, |key| match start {
            [] => random(Strategy::DIALECT, key),
            start => start_mutant(start, key),
        })
    }

    /// Runs one generation of every island.
    fn advance(&mut self) {
        let seen: HashSet<ProgramHash> = self.seen.iter().copied().collect();
        let mut islands = std::mem::take(&mut self.islands);
        let best = islands.iter().map(Island::least).fold(f64::INFINITY, f64::min);
        for (slot, island) in (0..).step_by(SLOTS as usize).zip(&mut islands) {
            let Self { cases, population, seed, generation, .. } = &*self;
            let (seed, generation) = (*seed, *generation);
            let context = IslandContext { cases, population, seen: &seen, seed, generation, slot };
            let is_over = island.stale >= population.stale && island.least() > best;
            let counts = if island.members.is_empty() || is_over {
                self.begin(island, &context)
            } else {
                island.step(&context)
            };
            self.evaluations += counts.evaluations;
            self.repeats += counts.repeats;
            self.seen.extend(counts.hashes);
        }
        let spare = self.seen.len().saturating_sub(SEEN_CAPACITY);
        self.seen.drain(..spare);
        self.islands = islands;
        self.generation += 1;
        if self.generation.is_multiple_of(self.population.migration) {
            self.migrate();
        }
        self.update_best();
    }

    /// Copies the best member of each island to the next island.
    fn migrate(&mut self) {
        let best: Vec<Option<Member>> =
            self.islands.iter().map(|island| island.members.first().cloned()).collect();
        for (index, member) in best.into_iter().enumerate() {
            if let Some(member) = member {
                let next = (index + 1) % self.islands.len();
                self.islands[next].add_migrant(member, &self.population);
            }
        }
    }

    /// Updates the front and the best member.
    fn update_best(&mut self) {
        for member in self.islands.iter().flat_map(|island| &island.members) {
            self.front.offer(member);
        }
        for member in self.islands.iter().filter_map(|island| island.members.first()) {
            if self.best.as_ref().is_some_and(|best| best.member == *member) {
                continue;
            }
            let (fitted, held) = (self.fitted(member), self.held(member));
            let error = ranking_error(fitted, held);
            let is_better = |best: &Best| error < ranking_error(best.fitted, best.held);
            if self.best.as_ref().is_none_or(is_better) {
                self.best = Some(Best { member: member.clone(), fitted, held });
            }
        }
    }

    /// E_log on the training samples. Sums are of base-2 logarithms, E_log is of natural ones.
    fn fitted(&self, member: &Member) -> f64 {
        let count = 3.0 * self.cases.target.samples() as f64;
        std::f64::consts::LN_2 * (member.sum / count).sqrt()
    }

    /// E_log on the validation samples, under the energy limit.
    fn held(&self, member: &Member) -> f64 {
        let held = &self.cases.held;
        let program = self.cases.limited_program(&member.genome);
        let values = values(&[&program], held);
        let count = held.len();
        let found: Vec<[f64; 3]> = (0..count)
            .map(|at| [0, 1, 2].map(|c| f64::from(values[c * count + at]) * held.weight[at]))
            .collect();
        metric::e_log(&held.weighted, &found)
    }
}

/// Pads the genome to the length of [`Strategy::DIALECT`] if it otherwise has that dialect.
fn padded_to_dialect(genome: Genome) -> Genome {
    let own = Dialect { length: Strategy::DIALECT.length, ..*genome.dialect() };
    let has_room = own == Strategy::DIALECT && genome.dialect().length < Strategy::DIALECT.length;
    if has_room {
        genome
            .padded(Strategy::DIALECT.length)
            .expect("the genome is shorter than Strategy::DIALECT.length")
    } else {
        genome
    }
}

impl Method for Gp {
    fn step(&mut self) -> Progress {
        self.advance();
        self.progress()
    }

    fn progress(&self) -> Progress {
        let of = |value: fn(&Best) -> f64| self.best.as_ref().map_or(f64::INFINITY, value);
        Progress {
            generation: self.generation,
            evaluations: self.evaluations,
            fitted: of(|best| best.fitted),
            held: of(|best| best.held),
        }
    }

    fn probe(&self) -> Probe {
        let members = self.islands.iter().flat_map(|island| &island.members);
        let members = members.map(|member| (self.fitted(member), &member.genome));
        Probe::of_genomes(members, self.repeats)
    }

    fn best(&self) -> Option<Candidate> {
        self.best.as_ref().map(|best| candidate(&best.member, best.fitted, best.held))
    }

    fn result(&self) -> Option<Candidate> {
        Method::best(self)
    }

    fn finish(&self, _: &mut HasTime<'_>) -> Option<Outcome> {
        let best = self.best.as_ref()?;
        let mut members: Vec<&Member> = self.front.members.iter().rev().collect();
        if !members.contains(&&best.member) {
            let place = members.partition_point(|own| own.operations > best.member.operations);
            members.insert(place, &best.member);
        }
        let is_best = |member: &&Member| **member == best.member;
        let index = members.iter().position(is_best).expect("the best was inserted");
        let of = |member| candidate(member, self.fitted(member), self.held(member));
        let front: Vec<Candidate> = members.into_iter().map(of).collect();
        Some(Outcome { front, best: index, is_settled: false })
    }

    fn emigrants(&self) -> Vec<Genome> {
        let best = self.islands.iter().filter_map(|island| island.members.first());
        best.map(|member| member.genome.clone()).collect()
    }

    fn immigrate(&mut self, genomes: &[Genome]) {
        let count = self.islands.len();
        let mut islands = std::mem::take(&mut self.islands);
        for (index, genome) in genomes.iter().enumerate() {
            let counts =
                islands[index % count].immigrate(genome.clone(), &self.cases, &self.population);
            self.evaluations += counts.evaluations;
            self.repeats += counts.repeats;
            self.seen.extend(counts.hashes);
        }
        self.islands = islands;
        self.update_best();
    }

    fn save(&self) -> Vec<u8> {
        self.state()
    }

    fn load(&mut self, state: &[u8]) -> Option<()> {
        self.set_state(state)
    }
}

fn candidate(member: &Member, fitted: f64, held: f64) -> Candidate {
    let genome = member.genome.clone().with_limit(true);
    let places = Tunable::lower(&genome).places().iter().flatten().count();
    // Plus scale and offset of each channel.
    Candidate { genome, parameters: places + 6, fitted, held }
}

#[cfg(test)]
#[path = "schedule_tests.rs"]
mod tests;
