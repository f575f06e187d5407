//! Parameters of a genetic search: numbers of islands, members and children, and how parents are
//! selected.

/// Parameters of the populations of a genetic search. docs/maths/fit.md reports how they were
/// tuned.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Population {
    /// Number of islands, which breed separately.
    pub islands: usize,
    /// Number of members that an island keeps between generations.
    pub kept: usize,
    /// Number of children of an island per generation.
    pub children: u32,
    /// Number of random genomes that an island starts with.
    pub first: u32,
    /// Number of members of an island whose constants are tuned per generation.
    pub tuned: usize,
    /// Largest number of tuning steps of a member.
    pub steps: usize,
    /// Number of members of a tournament.
    pub tournament: u32,
    /// Share of parents selected by lexicase selection instead of tournament.
    pub lexicase: f32,
    /// Share of children with two parents.
    pub crossed: f32,
    /// Number of generations between migrations of the best of each island to the next one.
    pub migration: u32,
    /// Number of generations without an improvement after which an island restarts, unless it is
    /// the best one.
    pub stale: u32,
}

impl Population {
    /// Parameters of [`Strategy::Gp`](brood_target::Strategy::Gp).
    pub const DEFAULT: Self = Self {
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
