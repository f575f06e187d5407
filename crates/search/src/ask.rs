//! Ask-tell interface: a genetic search whose errors are measured by the caller. [`AskTell::ask`]
//! returns genomes and [`AskTell::tell`] takes an error for each of them, from any source: a
//! render, a person, a laboratory.
//!
//! It uses the genetic operators of [`Strategy::Gp`](brood_target::Strategy::Gp), one population
//! and tournament selection. A genome whose program was asked before is drawn again, up to sixteen
//! times.

use std::collections::HashSet;

use brood_genome::{BirthKey, Dialect, Genome, Operator, Stream};
use brood_program::{Program, ProgramHash};
use serde::{Deserialize, Serialize};

use crate::front::offer;
use crate::gp::breed::{child_of, random, start_mutant, tournament};
use crate::{Population, Probe, Progress, SearchError};

/// Largest number of draws for a child with a new program; the last draw is used in any case.
const DRAWS: u32 = 16;
/// First byte of a checkpoint. Increase it whenever the same errors would lead to other genomes.
const VERSION: u8 = 2;

/// Inputs of an [`AskTell`] besides the errors.
#[derive(Debug, Clone, PartialEq)]
pub struct AskOptions {
    /// Dialect of randomly drawn genomes.
    pub dialect: Dialect,
    /// Genomes to start from; if empty, genomes are drawn at random.
    pub start: Vec<Genome>,
    /// Seed of all random draws.
    pub seed: u64,
    /// Number of genomes per generation, at least 1.
    pub count: u32,
    /// Number of genomes kept as parents, at least 2.
    pub kept: usize,
}

/// A genome and its error.
#[derive(Debug, Clone, PartialEq)]
pub struct Evaluated {
    /// The genome.
    pub genome: Genome,
    /// Error; smaller is better.
    pub error: f64,
    /// Number of scalar operations per sample.
    pub operations: u32,
    hash: ProgramHash,
}

/// Error of [`AskTell::tell`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum TellError {
    /// The number of errors differs from the number of genomes.
    #[error("expected {expected} errors, one for each genome, got {actual}")]
    Count {
        /// Number of genomes that were asked for.
        expected: usize,
        /// Number of errors that were passed.
        actual: usize,
    },
    /// An error is NaN; contains its index.
    #[error("the error of genome {0} is NaN; use infinity for a genome that is of no use")]
    NotANumber(usize),
}

/// Ask-tell search.
#[derive(Debug, Clone)]
pub struct AskTell {
    options: AskOptions,
    generation: u32,
    evaluations: u64,
    repeats: u64,
    /// `repeats` before the genomes of the current generation were drawn.
    repeats_before: u64,
    /// Parents, the least error first; no two have the same program.
    kept: Vec<Evaluated>,
    /// From the shortest to the longest; each has a smaller error than all shorter ones.
    front: Vec<Evaluated>,
    /// Programs of all genomes whose errors are known.
    seen: HashSet<ProgramHash>,
    /// Genomes of the current generation, whose errors are not known yet.
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
    /// Creates a search and draws the first generation.
    #[must_use]
    pub fn new(options: AskOptions) -> Self {
        let mut new = Self {
            options,
            generation: 0,
            evaluations: 0,
            repeats: 0,
            repeats_before: 0,
            kept: Vec::new(),
            front: Vec::new(),
            seen: HashSet::new(),
            asked: Vec::new(),
        };
        new.breed();
        new
    }

    /// Restores a search from a checkpoint, with the same options.
    ///
    /// # Errors
    /// Returns [`SearchError::Version`] or [`SearchError::Later`] if another version wrote it, and
    /// [`SearchError::Damaged`] if it cannot be decoded.
    pub fn resume(options: AskOptions, checkpoint: &[u8]) -> Result<Self, SearchError> {
        let state = SearchError::check_version(checkpoint, VERSION)?;
        let state: State = postcard::from_bytes(state).map_err(|_| SearchError::Damaged)?;
        let evaluated = |all: Vec<(Vec<u8>, f64)>| -> Option<Vec<Evaluated>> {
            let one = |(bytes, error): (Vec<u8>, f64)| {
                Some(Evaluated::new(Genome::from_canonical_bytes(&bytes).ok()?, error))
            };
            all.into_iter().map(one).collect()
        };
        let mut resumed = Self {
            options,
            generation: state.generation,
            evaluations: state.evaluations,
            repeats: state.repeats,
            repeats_before: state.repeats,
            kept: evaluated(state.kept).ok_or(SearchError::Damaged)?,
            front: evaluated(state.front).ok_or(SearchError::Damaged)?,
            seen: state.seen.into_iter().map(ProgramHash::from_bytes).collect(),
            asked: Vec::new(),
        };
        resumed.breed();
        Ok(resumed)
    }

    /// State for [`AskTell::resume`].
    #[must_use]
    pub fn checkpoint(&self) -> Vec<u8> {
        let evaluated = |all: &[Evaluated]| {
            all.iter()
                .map(|evaluated| (evaluated.genome.canonical_bytes(), evaluated.error))
                .collect()
        };
        // The current generation is not stored: `resume` draws it again.
        let mut seen: Vec<[u8; 32]> = self.seen.iter().map(|hash| *hash.as_bytes()).collect();
        seen.sort_unstable();
        let state = State {
            generation: self.generation,
            evaluations: self.evaluations,
            repeats: self.repeats_before,
            kept: evaluated(&self.kept),
            front: evaluated(&self.front),
            seen,
        };
        let mut bytes = vec![VERSION];
        bytes.extend(postcard::to_stdvec(&state).expect("plain data serialises"));
        bytes
    }

    /// Genomes of the current generation, whose errors [`AskTell::tell`] expects; unchanged until
    /// then.
    #[must_use]
    pub fn ask(&self) -> &[Genome] {
        &self.asked
    }

    /// Takes the error of each genome of [`AskTell::ask`], in their order, and breeds the next
    /// generation. An infinite error discards the genome.
    ///
    /// # Errors
    /// Returns [`TellError::Count`] if there are not as many errors as genomes, and
    /// [`TellError::NotANumber`] if one is NaN. The search is then unchanged.
    pub fn tell(&mut self, errors: &[f64]) -> Result<Progress, TellError> {
        let (expected, actual) = (self.asked.len(), errors.len());
        if expected != actual {
            return Err(TellError::Count { expected, actual });
        }
        if let Some(at) = errors.iter().position(|error| error.is_nan()) {
            return Err(TellError::NotANumber(at));
        }
        self.evaluations += actual as u64;
        for (genome, error) in std::mem::take(&mut self.asked).into_iter().zip(errors) {
            self.seen.insert(hash_of(&genome));
            if *error < f64::INFINITY {
                let evaluated = Evaluated::new(genome, *error);
                offer(&mut self.front, &evaluated, |it| (it.operations, it.error));
                self.kept.push(evaluated);
            }
        }
        self.kept.sort_by(|a, b| {
            a.error.total_cmp(&b.error).then_with(|| a.hash.as_bytes().cmp(b.hash.as_bytes()))
        });
        // A measure with noise may give one program several errors.
        let mut kept = HashSet::new();
        self.kept.retain(|evaluated| kept.insert(evaluated.hash));
        self.kept.truncate(self.options.kept);
        self.generation += 1;
        self.repeats_before = self.repeats;
        self.breed();
        Ok(self.progress())
    }

    /// Result of the last generation; `fitted` and `held` are both the least error.
    #[must_use]
    pub fn progress(&self) -> Progress {
        let least = self.kept.first().map_or(f64::INFINITY, |evaluated| evaluated.error);
        let (generation, evaluations) = (self.generation, self.evaluations);
        Progress { generation, evaluations, fitted: least, held: least }
    }

    /// Statistics of the population.
    #[must_use]
    pub fn probe(&self) -> Probe {
        let members = self.kept.iter().map(|evaluated| (evaluated.error, &evaluated.genome));
        Probe::of_genomes(members, self.repeats)
    }

    /// Best genome; `None` while no genome has a finite error.
    #[must_use]
    pub fn best(&self) -> Option<&Evaluated> {
        self.kept.first()
    }

    /// Front, from the shortest to the longest; each has a smaller error than all shorter ones.
    #[must_use]
    pub fn front(&self) -> &[Evaluated] {
        &self.front
    }

    /// Draws the next generation. The first one begins with the genomes to start from.
    fn breed(&mut self) {
        let first = if self.generation == 0 { self.options.start.clone() } else { Vec::new() };
        let mut asked = HashSet::new();
        self.asked.clear();
        for slot in 0..self.options.count {
            let genome = match first.get(slot as usize) {
                Some(genome) => genome.clone(),
                None => self.draw_new(slot, &asked),
            };
            asked.insert(hash_of(&genome));
            self.asked.push(genome);
        }
    }

    /// Draws a genome whose program is new, within [`DRAWS`] draws.
    fn draw_new(&mut self, slot: u32, asked: &HashSet<ProgramHash>) -> Genome {
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

    /// Child of parents from tournaments; while there are no parents, a mutant of a start genome or
    /// a random genome.
    fn child(&self, key: BirthKey) -> Genome {
        if self.kept.is_empty() {
            return match self.options.start.as_slice() {
                [] => random(self.options.dialect, key),
                start => start_mutant(start, key),
            };
        }
        let mut stream = Stream::new(key, Operator::Genetic);
        let population = Population::DEFAULT;
        let mut parent = || {
            let chosen = tournament(self.kept.len(), &population, &mut stream);
            &self.kept[chosen].genome
        };
        let parents = (parent(), parent());
        child_of(parents, population.crossed, key, &mut stream)
    }
}

impl Evaluated {
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
