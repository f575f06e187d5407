//! What every strategy is: generations, the best so far, and a state that can be kept.

use brood_genome::Genome;

use crate::Probe;

/// What a generation has come to.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Progress {
    /// How many there have been.
    pub generation: u32,
    /// How often a material has been held against samples, in all.
    pub evaluations: u64,
    /// E_log of the best on the samples it is fitted to.
    pub fitted: f64,
    /// On those of them that are held back from it, to choose by.
    pub held: f64,
}

/// A material that was found.
#[derive(Debug, Clone, PartialEq)]
pub struct Candidate {
    /// The material, under the energy limit.
    pub genome: Genome,
    /// How many numbers of it were fitted.
    pub numbers: usize,
    /// E_log on the samples it was fitted to.
    pub fitted: f64,
    /// E_log on the samples that were held back from it, before it was refined on these as well.
    pub held: f64,
}

impl Candidate {
    /// What one is better than another by, of whatever strategy: how far off it is where it was fitted and where it was not. The samples that were held
    /// back alone are few, and of many candidates the one that does best there is often only lucky.
    pub(crate) fn off(&self) -> f64 {
        self.fitted * self.fitted + self.held * self.held
    }
}

/// What a search has found.
#[derive(Debug, Clone, PartialEq)]
pub struct Outcome {
    /// From the longest to the shortest.
    pub front: Vec<Candidate>,
    /// Index of the best.
    pub best: usize,
}

impl Outcome {
    /// Of candidates from the longest to the shortest, each with what the least of is the best, those that are better than all shorter
    /// ones; the best of them, and of those that are as good the shortest.
    pub(crate) fn of(mut all: Vec<(Candidate, f64)>) -> Option<Self> {
        let mut least = f64::INFINITY;
        all.reverse();
        all.retain(|(_, off)| {
            let is_better = *off < least;
            least = least.min(*off);
            is_better
        });
        all.reverse();
        let better = |a: usize, b: usize| if all[b].1 < all[a].1 { b } else { a };
        let best = (0..all.len()).reduce(better)?;
        Some(Self { front: all.into_iter().map(|(candidate, _)| candidate).collect(), best })
    }
}

/// Whether there is time for more.
pub(crate) type GoOn<'a> = dyn FnMut() -> bool + 'a;

/// A strategy at work.
pub(crate) trait Method: Send {
    /// One generation.
    fn step(&mut self) -> Progress;

    /// What the last generation came to.
    fn progress(&self) -> Progress;

    /// How the population stands.
    fn probe(&self) -> Probe;

    /// The best so far; nothing before the first generation.
    fn best(&self) -> Option<Candidate>;

    /// The front; nothing before the first generation. It is asked before each part of what can be left out whether there is time for
    /// it, and once before what cannot.
    fn finish(&self, go_on: &mut GoOn<'_>) -> Option<Outcome>;

    /// Whether there is nothing to be shortened at the end.
    fn is_short(&self) -> bool {
        true
    }

    /// How many times as long as the ones before the next generation takes, about; more than once where it finishes something.
    fn next_takes(&self) -> f64 {
        1.0
    }

    /// All that the next generations depend on besides samples and options.
    fn save(&self) -> Vec<u8>;

    /// Goes on where a state was kept, of a search that has just been begun with the same samples and options; nothing where it is
    /// none of its.
    fn load(&mut self, state: &[u8]) -> Option<()>;
}
