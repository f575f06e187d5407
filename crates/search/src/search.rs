//! A search of any strategy: a deterministic sequence of generations that can be kept and gone on with.

use std::fmt;
use std::str::FromStr;

use brood_genome::{Dialect, Genome, ModelKind, OpcodeSet, Parametrisation};
use serde::{Deserialize, Serialize};

use crate::analytic::{Analytic, usual_kinds};
use crate::gp::Gp;
use crate::hybrid::Hybrid;
use crate::lobes::{Fit, Shape};
use crate::method::{Candidate, Method, Outcome, Progress};
use crate::{Population, Probe, Samples};

/// The dialect of what searches find from nothing, so that it can be bred further. Fits of lobes are shorter and can be padded
/// to this length.
pub const DIALECT: Dialect = Dialect {
    opcodes: OpcodeSet::Extended,
    parametrisation: Parametrisation::Smooth,
    registers: 16,
    length: 120,
    isotropic: true,
    homogeneous: true,
};

/// Sizes of the family of lobes that are tried: units and terms.
const SHAPES: [(usize, usize); 2] = [(4, 5), (6, 7)];
/// What the first byte of a checkpoint says. Counted up whenever a strategy changes what it does.
const VERSION: u8 = 6;

/// How a search goes about it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Strategy {
    /// Fits of a smooth family, and what is left of it when it is shortened.
    Lobes,
    /// Models of reflectance that everybody knows, one of them or the sum of two, by their own parameters.
    Analytic,
    /// Genetic programs, tuned by their derivatives; from nothing or from materials that are there.
    Gp,
    /// Lobes first, then genetic programs, of which every second island starts from them.
    Hybrid,
}

impl Strategy {
    /// All of them.
    pub const ALL: [Self; 4] = [Self::Hybrid, Self::Lobes, Self::Analytic, Self::Gp];

    /// As it is written.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Lobes => "lobes",
            Self::Analytic => "analytic",
            Self::Gp => "gp",
            Self::Hybrid => "hybrid",
        }
    }
}

impl fmt::Display for Strategy {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// A name that no strategy has.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("a strategy is one of {}", Strategy::ALL.map(Strategy::name).join(", "))]
pub struct UnknownStrategy;

impl FromStr for Strategy {
    type Err = UnknownStrategy;

    fn from_str(text: &str) -> Result<Self, UnknownStrategy> {
        Self::ALL.into_iter().find(|strategy| strategy.name() == text).ok_or(UnknownStrategy)
    }
}

/// What a search depends on besides its samples.
#[derive(Debug, Clone, PartialEq)]
pub struct Options {
    /// How it goes about it.
    pub strategy: Strategy,
    /// What it draws from.
    pub seed: u64,
    /// Whether the material is its own mirror image, so that nothing need tell left from right.
    pub is_mirrored: bool,
    /// Materials to start from, by the strategies that can.
    pub start: Vec<Genome>,
}

/// Why a search cannot go on.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum SearchError {
    /// Written by something else.
    #[error("the checkpoint was written by another version of this program")]
    Version,
    /// Not what was written.
    #[error("the checkpoint is damaged, or one of another search")]
    Damaged,
}

/// A search. Everything that comes of it depends on the samples, the options and the number of generations alone.
pub struct Search {
    method: Box<dyn Method>,
}

impl Search {
    /// Begins one.
    #[must_use]
    pub fn new(samples: &Samples, options: &Options) -> Self {
        let method: Box<dyn Method> = match options.strategy {
            Strategy::Lobes => Box::new(lobes(samples, options)),
            Strategy::Analytic => Box::new(analytic(samples, options, usual_kinds())),
            Strategy::Gp => Box::new(genetic(samples, options)),
            Strategy::Hybrid => Box::new(hybrid(samples, options)),
        };
        Self { method }
    }

    /// Begins one of [`Strategy::Analytic`] with these models alone; [`Search::resume`] goes on with them.
    #[must_use]
    pub fn of_kinds(samples: &Samples, options: &Options, kinds: Vec<ModelKind>) -> Self {
        Self { method: Box::new(analytic(samples, options, kinds)) }
    }

    /// Begins one of [`Strategy::Gp`] with another population than usually, which cannot be gone on with after a break.
    #[must_use]
    pub fn of_population(samples: &Samples, options: &Options, population: Population) -> Self {
        Self { method: Box::new(Gp::of(samples, &options.start, options.seed, population)) }
    }

    /// Goes on with one that was kept: with the same samples and options the next generations have the same bits as if there
    /// had been no break.
    pub fn resume(
        samples: &Samples,
        options: &Options,
        checkpoint: &[u8],
    ) -> Result<Self, SearchError> {
        let (version, state) = checkpoint.split_first().ok_or(SearchError::Damaged)?;
        if *version != VERSION {
            return Err(SearchError::Version);
        }
        let mut method = Self::new(samples, options).method;
        method.load(state).ok_or(SearchError::Damaged)?;
        Ok(Self { method })
    }

    /// One generation.
    pub fn step(&mut self) -> Progress {
        self.method.step()
    }

    /// What the last generation came to.
    #[must_use]
    pub fn progress(&self) -> Progress {
        self.method.progress()
    }

    /// How the population stands after it.
    #[must_use]
    pub fn probe(&self) -> Probe {
        self.method.probe()
    }

    /// The best so far, by how far off it is where it is fitted and where it is not; nothing before the first generation.
    #[must_use]
    pub fn best(&self) -> Option<Candidate> {
        self.method.best()
    }

    /// The front of error against length; nothing before the first generation.
    #[must_use]
    pub fn finish(&self) -> Option<Outcome> {
        self.method.finish(&mut || true)
    }

    /// The same, but for shorter ones that `go_on` leaves no time for: it is asked before each few of them, and once before the best
    /// is finished in any case.
    #[must_use]
    pub fn finish_while(&self, mut go_on: impl FnMut() -> bool) -> Option<Outcome> {
        self.method.finish(&mut go_on)
    }

    /// Whether finishing takes next to no time.
    #[must_use]
    pub fn is_short(&self) -> bool {
        self.method.is_short()
    }

    /// How many times as long as the ones before the next generation takes, about; more than once where it finishes something.
    #[must_use]
    pub fn next_takes(&self) -> f64 {
        self.method.next_takes()
    }

    /// The state: what [`Search::resume`] reads. Two searches that have come to the same have the same bytes.
    #[must_use]
    pub fn checkpoint(&self) -> Vec<u8> {
        let mut bytes = vec![VERSION];
        bytes.extend(self.method.save());
        bytes
    }
}

fn lobes(samples: &Samples, options: &Options) -> Fit {
    let shape = |(units, terms): (usize, usize)| Shape::new(units, terms, options.is_mirrored);
    Fit::new(samples, SHAPES.map(shape).to_vec(), options.seed)
}

fn analytic(samples: &Samples, options: &Options, kinds: Vec<ModelKind>) -> Analytic {
    Analytic::new(samples, kinds, &options.start, options.seed)
}

fn genetic(samples: &Samples, options: &Options) -> Gp {
    Gp::new(samples, &options.start, options.seed, false)
}

fn hybrid(samples: &Samples, options: &Options) -> Hybrid {
    Hybrid::new(lobes(samples, options), samples, &options.start, options.seed)
}

#[cfg(test)]
#[path = "search_tests.rs"]
mod tests;
