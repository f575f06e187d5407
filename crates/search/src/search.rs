//! A search of any strategy: a deterministic sequence of generations that can be saved and resumed.

use brood_genome::lobes::Shape;
use brood_genome::{Genome, ModelKind};
use brood_target::{Objective, Samples, Strategy};
use serde::{Deserialize, Serialize};

use crate::analytic::{Analytic, PriorMaterials, default_kinds};
use crate::gp::Gp;
use crate::guided::Guided;
use crate::hybrid::Hybrid;
use crate::kept::{Kept, KeptState, Reported};
use crate::lobes::{Fit, Terms};
use crate::method::{Candidate, Method, Outcome, Posterior, Progress};
use crate::{Population, Probe};

/// Sizes (units, terms) of the family of lobes that are tried.
const SHAPES: [(usize, usize); 2] = [(4, 5), (6, 7)];
/// First byte of a checkpoint. Increase it whenever a strategy changes its results.
const VERSION: u8 = 12;

/// Inputs of a search besides its samples.
#[derive(Debug, Clone, PartialEq)]
pub struct Options {
    /// Strategy.
    pub strategy: Strategy,
    /// Seed of all random draws.
    pub seed: u64,
    /// True if the material is its own mirror image, so that inputs that distinguish left from
    /// right are left out.
    pub is_mirrored: bool,
    /// Genomes to start from, without their bumps, which pairs of directions do not show; ignored
    /// by [`Strategy::Lobes`].
    pub start: Vec<Genome>,
    /// Error that lobes minimise; ignored by strategies without lobes.
    pub objective: Objective,
}

impl Default for Options {
    /// A search of [`Strategy::Hybrid`] with seed 1, which starts from nothing.
    fn default() -> Self {
        Self {
            strategy: Strategy::Hybrid,
            seed: 1,
            is_mirrored: false,
            start: Vec::new(),
            objective: Objective::default(),
        }
    }
}

/// Error of resuming a search from a checkpoint.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum SearchError {
    /// The checkpoint has an earlier version.
    #[error("the checkpoint was written by another version of this program")]
    Version,
    /// The checkpoint has a later version.
    #[error("the checkpoint was written by a later version of this program")]
    Later,
    /// The checkpoint cannot be decoded, or belongs to another search.
    #[error("the checkpoint is damaged, or one of another search")]
    Damaged,
}

impl SearchError {
    /// Returns the state of a checkpoint, which is behind its version.
    pub(crate) fn check_version(checkpoint: &[u8], version: u8) -> Result<&[u8], Self> {
        match checkpoint.split_first() {
            Some((own, state)) if *own == version => Ok(state),
            Some((own, _)) if *own > version => Err(Self::Later),
            Some(_) => Err(Self::Version),
            None => Err(Self::Damaged),
        }
    }
}

/// A search. Its results depend only on the samples, the options and the number of generations.
pub struct Search {
    method: Box<dyn Method>,
    /// Measures results on the samples of [`Search::reporting`].
    reported: Option<Reported>,
    kept: Option<Kept>,
}

/// State of a search in a checkpoint.
#[derive(Serialize, Deserialize)]
struct State {
    kept: Option<KeptState>,
    method: Vec<u8>,
}

impl Search {
    /// Creates a search at generation 0.
    #[must_use]
    pub fn new(samples: &Samples, options: &Options) -> Self {
        if options.strategy == Strategy::Analytic {
            return Self::of(unguided(samples, options));
        }
        // Only models are fitted to means.
        let centres = samples.at_centres();
        Self::of(match samples.are_of_pictures() {
            true => {
                let (seed, own) = (options.seed, options.clone());
                let build = Box::new(move |samples: &Samples| unguided(samples, &own));
                let models = analytic(samples, options, default_kinds());
                Box::new(Guided::new(models, centres, seed, build))
            }
            false => unguided(&centres, options),
        })
    }

    fn of(method: Box<dyn Method>) -> Self {
        Self { method, reported: None, kept: None }
    }

    /// Keeps the result of least E_log on these samples, which are held out from the search, and
    /// adds it to the front: more generations do not make the least error of the front larger than
    /// that of the best fit before. Results of fits are refined for this whenever the best fit
    /// changes. Does nothing for [`Strategy::Analytic`], which chooses by probability.
    #[must_use]
    pub fn reporting(self, held_out: &Samples) -> Self {
        Self { reported: Some(Reported::new(held_out)), ..self }
    }

    /// Creates a search of [`Strategy::Analytic`] over these model kinds only. [`Search::resume`]
    /// keeps them.
    #[must_use]
    pub fn with_kinds(samples: &Samples, options: &Options, kinds: Vec<ModelKind>) -> Self {
        Self::of(Box::new(analytic(samples, options, kinds)))
    }

    /// Creates a search of [`Strategy::Analytic`] with a prior by these materials, which
    /// [`Search::resume`] does not restore.
    #[must_use]
    pub fn with_prior(samples: &Samples, options: &Options, materials: PriorMaterials) -> Self {
        Self::of(Box::new(analytic(samples, options, default_kinds()).with_prior(materials)))
    }

    /// Creates a search of [`Strategy::Gp`] with the given population parameters, which
    /// [`Search::resume`] does not restore.
    #[must_use]
    pub fn with_population(samples: &Samples, options: &Options, population: Population) -> Self {
        let (samples, starts) = (samples.at_centres(), starts(options));
        Self::of(Box::new(Gp::of(&samples, &starts, options.seed, population)))
    }

    /// Creates a search of [`Strategy::Lobes`] with these terms of the objective, which
    /// [`Search::resume`] does not restore.
    #[must_use]
    pub fn with_terms(samples: &Samples, options: &Options, terms: Terms) -> Self {
        Self::of(Box::new(lobes(&samples.at_centres(), options, terms)))
    }

    /// Restores a search from a checkpoint. With the same samples and options, the next generations
    /// have the same bits as without the interruption. The checkpoint does not contain them, so
    /// a wrong one is not detected. Call [`Search::reporting`] again if the search had it.
    ///
    /// # Errors
    /// Returns [`SearchError::Version`] or [`SearchError::Later`] if another version wrote it, and
    /// [`SearchError::Damaged`] if it cannot be decoded or has another form than a search of this
    /// strategy.
    pub fn resume(
        samples: &Samples,
        options: &Options,
        checkpoint: &[u8],
    ) -> Result<Self, SearchError> {
        let state = SearchError::check_version(checkpoint, VERSION)?;
        let damaged = SearchError::Damaged;
        let State { kept, method: state } = postcard::from_bytes(state).map_err(|_| damaged)?;
        let mut search = Self::new(samples, options);
        search.method.load(&state).ok_or(damaged)?;
        let kept = kept.map(|kept| kept.kept().ok_or(damaged)).transpose()?;
        Ok(Self { kept, ..search })
    }

    /// Runs one generation.
    pub fn step(&mut self) -> Progress {
        let progress = self.method.step();
        if let Some(reported) = &mut self.reported {
            reported.offer(&*self.method, &mut self.kept);
        }
        progress
    }

    /// Result of the last generation.
    #[must_use]
    pub fn progress(&self) -> Progress {
        self.method.progress()
    }

    /// Statistics of the population after the last generation.
    #[must_use]
    pub fn probe(&self) -> Probe {
        self.method.probe()
    }

    /// Best candidate so far; `None` before the first generation. [`Strategy::Analytic`] chooses
    /// the most probable form of model, the other strategies the least error on training and
    /// validation samples together.
    #[must_use]
    pub fn best(&self) -> Option<Candidate> {
        self.method.best()
    }

    /// Front of error against length; `None` before the first generation. Fits of lobes and of
    /// models are refined on all samples first, validation samples included.
    #[must_use]
    pub fn finish(&self) -> Option<Outcome> {
        self.finish_while(|| true)
    }

    /// Like [`Search::finish`], but leaves out shorter candidates when time runs out. `has_time` is
    /// called before every few candidates, and once before the best one, which is always finished.
    #[must_use]
    pub fn finish_while(&self, mut has_time: impl FnMut() -> bool) -> Option<Outcome> {
        let outcome = self.method.finish(&mut has_time)?;
        Some(match &self.kept {
            Some(kept) => outcome.with(kept.candidate.clone()),
            None => outcome,
        })
    }

    /// Draws `count` materials that match the samples about as well as the best. `None` before the
    /// first generation and for other strategies than [`Strategy::Analytic`].
    #[must_use]
    pub fn posterior(&self, count: usize) -> Option<Posterior> {
        self.method.posterior(count)
    }

    /// True if [`Search::finish`] takes next to no time.
    #[must_use]
    pub fn finishes_quickly(&self) -> bool {
        self.method.finishes_quickly()
    }

    /// Estimated duration of the next generation as a multiple of the previous ones; above 1 if it
    /// also finishes a stage.
    #[must_use]
    pub fn next_step_cost(&self) -> f64 {
        self.method.next_step_cost()
    }

    /// Genomes for [`Search::immigrate`] of the next island.
    #[must_use]
    pub fn emigrants(&self) -> Vec<Genome> {
        self.method.emigrants()
    }

    /// Adds genomes of the previous island. Does nothing before the first program.
    pub fn immigrate(&mut self, genomes: &[Genome]) {
        self.method.immigrate(genomes);
        if let Some(reported) = &mut self.reported {
            reported.offer(&*self.method, &mut self.kept);
        }
    }

    /// State for [`Search::resume`]. Searches in the same state have the same bytes.
    #[must_use]
    pub fn checkpoint(&self) -> Vec<u8> {
        let kept = self.kept.as_ref().map(KeptState::of);
        let state = State { kept, method: self.method.save() };
        postcard::to_extend(&state, vec![VERSION]).expect("plain data serialises")
    }
}

/// Genomes to start from, without bumps.
fn starts(options: &Options) -> Vec<Genome> {
    options.start.iter().map(|genome| genome.clone().with_bump(None)).collect()
}

fn lobes(samples: &Samples, options: &Options, terms: Terms) -> Fit {
    let shape = |(units, terms): (usize, usize)| Shape::new(units, terms, options.is_mirrored);
    Fit::new(samples, SHAPES.map(shape).to_vec(), terms, options.seed)
}

fn analytic(samples: &Samples, options: &Options, kinds: Vec<ModelKind>) -> Analytic {
    Analytic::new(samples, kinds, &starts(options), options.seed)
}

/// Method of the strategy alone.
fn unguided(samples: &Samples, options: &Options) -> Box<dyn Method> {
    match options.strategy {
        Strategy::Lobes => Box::new(lobes(samples, options, options.objective.into())),
        Strategy::Gp => Box::new(genetic(samples, options)),
        Strategy::Analytic => Box::new(analytic(samples, options, default_kinds())),
        Strategy::Hybrid => Box::new(hybrid(samples, options)),
    }
}

fn genetic(samples: &Samples, options: &Options) -> Gp {
    Gp::new(samples, &starts(options), options.seed, false)
}

fn hybrid(samples: &Samples, options: &Options) -> Hybrid {
    let fit = lobes(samples, options, options.objective.into());
    Hybrid::new(fit, samples, &starts(options), options.seed)
}

#[cfg(test)]
#[path = "search_tests.rs"]
mod tests;
