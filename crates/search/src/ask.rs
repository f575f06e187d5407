//! A genetic search whose errors come from outside: it is asked for genomes, and told how good each of them is. What is measured,
//! and by whom, it does not know: a render, a person, a laboratory.
//!
//! The same genetic operators as in [`crate::Strategy::Gp`], one population, tournaments; no program is asked about twice.

use std::collections::HashSet;

use brood_genome::{BirthKey, Dialect, Genome, Operator, Stream};
use brood_program::{Program, ProgramHash};
use serde::{Deserialize, Serialize};

use crate::gp::breed::{child_of, random, started};
use crate::{Population, Probe, Progress, SearchError};

/// Draws for a child until its program is new; then the last one is asked about, whatever it is.
const DRAWS: u32 = 16;
/// What the first byte of a checkpoint says. Counted up whenever the same answers would lead to other questions.
const VERSION: u8 = 1;

/// What an [`AskTell`] depends on besides what it is told.
#[derive(Debug, Clone, PartialEq)]
pub struct AskOptions {
    /// Of genomes that are drawn from nothing.
    pub dialect: Dialect,
    /// Genomes to begin with; from nothing where there is none.
    pub start: Vec<Genome>,
    /// What it draws from.
    pub seed: u64,
    /// How many genomes are asked about at once, at least 1.
    pub count: u32,
    /// How many are kept to breed from, at least 2.
    pub kept: usize,
}

/// A genome and what was told of it.
#[derive(Debug, Clone, PartialEq)]
pub struct Told {
    /// The genome.
    pub genome: Genome,
    /// How far off it is; the less the better.
    pub error: f64,
    /// Scalar operations a sample.
    pub operations: u32,
    hash: ProgramHash,
}

/// Why errors were not taken.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum TellError {
    /// More or fewer than genomes.
    #[error("{asked} genomes were asked about, and {told} errors told")]
    Count {
        /// Genomes.
        asked: usize,
        /// Errors.
        told: usize,
    },
    /// No number.
    #[error("the error of genome {0} is not a number; infinity says that it is of no use")]
    NotANumber(usize),
}

/// The search.
#[derive(Debug, Clone)]
pub struct AskTell {
    options: AskOptions,
    generation: u32,
    evaluations: u64,
    repeats: u64,
    /// Of them those before what is asked about now.
    repeats_told: u64,
    /// The least error first, no two of the same program.
    kept: Vec<Told>,
    /// From the shortest to the longest, each better than all shorter ones.
    front: Vec<Told>,
    seen: HashSet<ProgramHash>,
    asked: Vec<Genome>,
}

#[derive(Serialize, Deserialize)]
struct State {
    generation: u32,
    evaluations: u64,
    repeats: u64,
    kept: Vec<(Vec<u8>, f64)>,
    front: Vec<(Vec<u8>, f64)>,
    seen: Vec<[u8; 32]>,
}

impl AskTell {
    /// Begins one.
    #[must_use]
    pub fn new(options: AskOptions) -> Self {
        let mut new = Self {
            options,
            generation: 0,
            evaluations: 0,
            repeats: 0,
            repeats_told: 0,
            kept: Vec::new(),
            front: Vec::new(),
            seen: HashSet::new(),
            asked: Vec::new(),
        };
        new.breed();
        new
    }

    /// Goes on with one that was kept, with the same options.
    pub fn resume(options: AskOptions, checkpoint: &[u8]) -> Result<Self, SearchError> {
        let (version, state) = checkpoint.split_first().ok_or(SearchError::Damaged)?;
        if *version != VERSION {
            return Err(SearchError::Version);
        }
        let state: State = postcard::from_bytes(state).map_err(|_| SearchError::Damaged)?;
        let told = |all: Vec<(Vec<u8>, f64)>| -> Option<Vec<Told>> {
            let one = |(bytes, error): (Vec<u8>, f64)| {
                Some(Told::new(Genome::from_canonical_bytes(&bytes).ok()?, error))
            };
            all.into_iter().map(one).collect()
        };
        let mut resumed = Self {
            options,
            generation: state.generation,
            evaluations: state.evaluations,
            repeats: state.repeats,
            repeats_told: state.repeats,
            kept: told(state.kept).ok_or(SearchError::Damaged)?,
            front: told(state.front).ok_or(SearchError::Damaged)?,
            seen: state.seen.into_iter().map(ProgramHash::from_bytes).collect(),
            asked: Vec::new(),
        };
        resumed.breed();
        Ok(resumed)
    }

    /// The state: what [`AskTell::resume`] reads.
    #[must_use]
    pub fn checkpoint(&self) -> Vec<u8> {
        let told = |all: &[Told]| {
            all.iter().map(|told| (told.genome.canonical_bytes(), told.error)).collect()
        };
        // What is asked about now is bred again.
        let mut seen: Vec<[u8; 32]> = self.seen.iter().map(|hash| *hash.as_bytes()).collect();
        seen.sort_unstable();
        let state = State {
            generation: self.generation,
            evaluations: self.evaluations,
            repeats: self.repeats_told,
            kept: told(&self.kept),
            front: told(&self.front),
            seen,
        };
        let mut bytes = vec![VERSION];
        bytes.extend(postcard::to_stdvec(&state).expect("numbers and bytes can be written"));
        bytes
    }

    /// What is to be measured: the same until it is told.
    #[must_use]
    pub fn ask(&self) -> &[Genome] {
        &self.asked
    }

    /// Takes how far off each of the genomes asked about is, in their order, and breeds the next ones.
    pub fn tell(&mut self, errors: &[f64]) -> Result<Progress, TellError> {
        let (asked, told) = (self.asked.len(), errors.len());
        if asked != told {
            return Err(TellError::Count { asked, told });
        }
        if let Some(at) = errors.iter().position(|error| error.is_nan()) {
            return Err(TellError::NotANumber(at));
        }
        self.evaluations += told as u64;
        for (genome, error) in std::mem::take(&mut self.asked).into_iter().zip(errors) {
            self.seen.insert(hash_of(&genome));
            if *error < f64::INFINITY {
                let told = Told::new(genome, *error);
                self.offer(&told);
                self.kept.push(told);
            }
        }
        self.kept.sort_by(|a, b| {
            a.error.total_cmp(&b.error).then_with(|| a.hash.as_bytes().cmp(b.hash.as_bytes()))
        });
        self.kept.dedup_by(|a, b| a.hash == b.hash);
        self.kept.truncate(self.options.kept);
        self.generation += 1;
        self.repeats_told = self.repeats;
        self.breed();
        Ok(self.progress())
    }

    /// What has come of it: both errors are the one that was told.
    #[must_use]
    pub fn progress(&self) -> Progress {
        let least = self.kept.first().map_or(f64::INFINITY, |told| told.error);
        let (generation, evaluations) = (self.generation, self.evaluations);
        Progress { generation, evaluations, fitted: least, held: least }
    }

    /// How the population stands.
    #[must_use]
    pub fn probe(&self) -> Probe {
        let members = self.kept.iter().map(|told| (told.error, &told.genome));
        Probe::of_genomes(members, self.repeats)
    }

    /// The best; nothing as long as nothing was of use.
    #[must_use]
    pub fn best(&self) -> Option<&Told> {
        self.kept.first()
    }

    /// From the shortest to the longest, each better than all shorter ones.
    #[must_use]
    pub fn front(&self) -> &[Told] {
        &self.front
    }

    fn offer(&mut self, told: &Told) {
        let is_beaten =
            |by: &Told, it: &Told| by.operations <= it.operations && by.error <= it.error;
        if self.front.iter().any(|own| is_beaten(own, told)) {
            return;
        }
        self.front.retain(|own| !is_beaten(told, own));
        let place = self.front.partition_point(|own| own.operations < told.operations);
        self.front.insert(place, told.clone());
    }

    fn breed(&mut self) {
        let first = if self.generation == 0 { self.options.start.clone() } else { Vec::new() };
        let mut asked = HashSet::new();
        self.asked.clear();
        for slot in 0..self.options.count {
            let genome = match first.get(slot as usize) {
                Some(genome) => genome.clone(),
                None => self.drawn(slot, &asked),
            };
            asked.insert(hash_of(&genome));
            self.asked.push(genome);
        }
    }

    /// One whose program is new, if one comes.
    fn drawn(&mut self, slot: u32, asked: &HashSet<ProgramHash>) -> Genome {
        let mut draw = 0;
        loop {
            let attempt = self.generation.wrapping_mul(DRAWS).wrapping_add(draw);
            let genome = self.child(BirthKey { seed: self.options.seed, slot, attempt });
            let hash = hash_of(&genome);
            draw += 1;
            if draw == DRAWS || !(self.seen.contains(&hash) || asked.contains(&hash)) {
                return genome;
            }
            self.repeats += 1;
        }
    }

    fn child(&self, key: BirthKey) -> Genome {
        if self.kept.is_empty() {
            return match self.options.start.as_slice() {
                [] => random(self.options.dialect, key),
                start => started(start, key),
            };
        }
        let mut stream = Stream::new(key, Operator::Genetic);
        let count = u32::try_from(self.kept.len()).expect("populations are small");
        let Population { tournament, crossed, .. } = Population::USUAL;
        let mut parent =
            || (0..tournament).map(|_| stream.below(count)).min().unwrap_or(0) as usize;
        let (first, second) = (parent(), parent());
        let parents = (&self.kept[first].genome, &self.kept[second].genome);
        child_of(parents, crossed, key, &mut stream)
    }
}

impl Told {
    fn new(genome: Genome, error: f64) -> Self {
        let program = Program::lower(&genome);
        let operations = u32::try_from(program.operations()).unwrap_or(u32::MAX);
        Self { genome, error, operations, hash: program.hash() }
    }
}

fn hash_of(genome: &Genome) -> ProgramHash {
    Program::lower(genome).hash()
}

#[cfg(test)]
#[path = "ask_tests.rs"]
mod tests;
