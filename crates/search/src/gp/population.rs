//! The numbers of a genetic search that no derivative finds: how many islands, members and children, and how parents are chosen.

/// How populations are kept and bred. docs/maths/fit.md says what they were tuned on.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Population {
    /// Islands that breed by themselves.
    pub islands: usize,
    /// Members that an island keeps from one generation to the next.
    pub kept: usize,
    /// Children of an island in a generation.
    pub children: u32,
    /// Genomes that an island starts with, of which the best are kept.
    pub first: u32,
    /// Members of an island whose constants are tuned in a generation.
    pub tuned: usize,
    /// Steps of each of these at most.
    pub steps: usize,
    /// Members of a tournament.
    pub tournament: u32,
    /// Share of parents that are chosen by lexicase selection instead.
    pub lexicase: f32,
    /// Share of children that have two parents.
    pub crossed: f32,
    /// Every so many generations the best of each island goes to the next one.
    pub migration: u32,
    /// Generations without an improvement after which an island that is not the best one begins again.
    pub stale: u32,
}

impl Population {
    /// What searches take.
    pub const USUAL: Self = Self {
        islands: 4,
        kept: 64,
        children: 192,
        first: 512,
        tuned: 6,
        steps: 6,
        tournament: 3,
        lexicase: 0.5,
        crossed: 0.4,
        migration: 16,
        stale: 40,
    };
}
