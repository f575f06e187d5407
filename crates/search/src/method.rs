//! What every strategy is: generations, the best so far, and a state that can be kept.

use brood_genome::Genome;

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
}

/// What a search has found.
#[derive(Debug, Clone, PartialEq)]
pub struct Outcome {
    /// From the longest to the shortest.
    pub front: Vec<Candidate>,
    /// Index of the one that does best where it was not fitted.
    pub best: usize,
}

/// A strategy at work.
pub(crate) trait Method: Send {
    /// One generation.
    fn step(&mut self) -> Progress;

    /// What the last generation came to.
    fn progress(&self) -> Progress;

    /// The best so far; nothing before the first generation.
    fn best(&self) -> Option<Candidate>;

    /// The front; nothing before the first generation.
    fn finish(&self) -> Option<Outcome>;

    /// All that the next generations depend on besides samples and options.
    fn save(&self) -> Vec<u8>;
}
