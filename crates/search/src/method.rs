//! Interface of a search strategy: generations, the best candidate, and a state that can be saved.
//!
//! A strategy splits the samples it is given into training samples, which fits minimise, and
//! validation samples, by which it chooses between fits. In names, `fitted` and `held` (held back)
//! are the errors on these two.

use brood_genome::Genome;
use brood_program::Program;

use crate::Probe;

/// One in this many samples is a validation sample.
const HOLDOUT_STRIDE: usize = 7;

/// True if the sample of this index is a validation sample: held back from fits, to choose between
/// candidates.
pub(crate) fn is_held_back(index: usize) -> bool {
    index % HOLDOUT_STRIDE == HOLDOUT_STRIDE - 1
}

/// Error used for ranking, comparable between strategies: the squares of E_log on the training and
/// on the validation samples, added. The validation samples alone are few, and the best of many
/// candidates on them is often only lucky.
pub(crate) fn ranking_error(fitted: f64, held: f64) -> f64 {
    fitted * fitted + held * held
}

/// Result of a generation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Progress {
    /// Number of generations so far.
    pub generation: u32,
    /// Total number of evaluations of a material on samples.
    pub evaluations: u64,
    /// E_log of the best candidate on the training samples.
    pub fitted: f64,
    /// E_log of the best candidate on the validation samples.
    pub held: f64,
}

impl Progress {
    /// Error of the best candidate used for ranking.
    pub(crate) fn ranking_error(&self) -> f64 {
        ranking_error(self.fitted, self.held)
    }
}

/// A material found by a search.
#[derive(Debug, Clone, PartialEq)]
pub struct Candidate {
    /// Genome, under the energy limit.
    pub genome: Genome,
    /// Number of fitted parameters.
    pub parameters: usize,
    /// E_log on the training samples.
    pub fitted: f64,
    /// E_log on the validation samples, before refinement on these as well.
    pub held: f64,
}

impl Candidate {
    /// Error used for ranking.
    pub(crate) fn ranking_error(&self) -> f64 {
        ranking_error(self.fitted, self.held)
    }
}

/// Result of a search.
#[derive(Debug, Clone, PartialEq)]
pub struct Outcome {
    /// Front, from the longest to the shortest: each candidate has a smaller error than all shorter
    /// ones, or is the best.
    pub front: Vec<Candidate>,
    /// Index in `front` of the search's choice, before the front is measured.
    pub best: usize,
    /// True if that choice stands: it is the most probable candidate. Otherwise the measured errors
    /// decide; see [`Found::best`](crate::Found::best).
    pub is_settled: bool,
}

impl Outcome {
    /// Filters candidates, given from the longest to the shortest with their ranking errors: keeps
    /// those better than all shorter ones. The best is the one of least error; among equals, the
    /// shortest.
    pub(crate) fn of(mut all: Vec<(Candidate, f64)>) -> Option<Self> {
        let mut least = f64::INFINITY;
        all.reverse();
        all.retain(|(_, error)| {
            let is_better = *error < least;
            least = least.min(*error);
            is_better
        });
        all.reverse();
        let better = |a: usize, b: usize| if all[b].1 < all[a].1 { b } else { a };
        let best = (0..all.len()).reduce(better)?;
        let front = all.into_iter().map(|(candidate, _)| candidate).collect();
        Some(Self { front, best, is_settled: false })
    }

    /// Adds a candidate at its place by length, unless the front has its genome.
    pub(crate) fn with(mut self, candidate: Candidate) -> Self {
        if self.front.iter().any(|own| own.genome == candidate.genome) {
            return self;
        }
        let length = |candidate: &Candidate| Program::lower(&candidate.genome).operations();
        let own = length(&candidate);
        let place = self.front.partition_point(|longer| length(longer) > own);
        self.best += usize::from(place <= self.best);
        self.front.insert(place, candidate);
        self
    }
}

/// Materials that match samples about as well as the best.
#[derive(Debug, Clone, PartialEq)]
pub struct Posterior {
    /// The materials, under the energy limit; some may be equal.
    pub genomes: Vec<Genome>,
    /// Mean squared error of observations that they were drawn with.
    pub error: f64,
}

/// Callback that returns true while there is time for more work.
pub(crate) type HasTime<'a> = dyn FnMut() -> bool + 'a;

/// A running search strategy.
pub(crate) trait Method: Send {
    /// Runs one generation.
    fn step(&mut self) -> Progress;

    /// Result of the last generation.
    fn progress(&self) -> Progress;

    /// Statistics of the population.
    fn probe(&self) -> Probe;

    /// Best candidate so far; `None` before the first generation.
    fn best(&self) -> Option<Candidate>;

    /// Best candidate so far as [`Method::finish`] returns it, without shorter ones; `None` before
    /// the first generation, and if the strategy chooses by probability.
    fn result(&self) -> Option<Candidate> {
        None
    }

    /// Result so far; `None` before the first generation. If finishing takes time, calls `has_time`
    /// once before the part that is always done, and before each optional part, which it skips from
    /// the first `false` on.
    fn finish(&self, has_time: &mut HasTime<'_>) -> Option<Outcome>;

    /// Random materials that match the samples about as well as the best; `None` if the strategy
    /// has no probabilities.
    fn posterior(&self, _count: usize) -> Option<Posterior> {
        None
    }

    /// True if [`Method::finish`] has no fits to shorten, and so takes next to no time.
    fn finishes_quickly(&self) -> bool {
        true
    }

    /// Estimated duration of the next generation as a multiple of the previous ones; above 1 if it
    /// also finishes a stage.
    fn next_step_cost(&self) -> f64 {
        1.0
    }

    /// Genomes that other islands of the search can add; none before the first program, and for
    /// strategies without a population of programs.
    fn emigrants(&self) -> Vec<Genome> {
        Vec::new()
    }

    /// Adds genomes of another island; does nothing where [`Method::emigrants`] returns none.
    fn immigrate(&mut self, _genomes: &[Genome]) {}

    /// State that the next generations depend on besides samples and options.
    fn save(&self) -> Vec<u8>;

    /// Restores a saved state into a new search with the same samples and options. Returns `None`
    /// if the state does not fit this search.
    fn load(&mut self, state: &[u8]) -> Option<()>;
}
