//! Operation counts before and after each pass of lowering.

use brood_genome::{Function, Genome, Input, Liveness, ScalarMachine, expand};

use crate::Program;
use crate::build::Builder;
use crate::lower::Collected;

/// Operation counts before and after each pass.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Counts {
    /// Number of instructions of the genome.
    pub instructions: u32,
    /// Number of instructions that can change the result.
    pub live_instructions: u32,
    /// Number of scalar operations of all components written.
    pub scalar_operations: u32,
    /// Number of them after per-component dead-code removal.
    pub live_scalar_operations: u32,
    /// Number of them after value numbering.
    pub numbered_operations: u32,
    /// Number of them after folding: the operations executed for each sample.
    pub operations: u32,
}

impl Counts {
    /// Returns the counts of a genome.
    #[must_use]
    pub fn of(genome: &Genome) -> Self {
        let live = Liveness::of(genome);
        // Numbers values without folding.
        let mut builder = Builder::new(false);
        let results = expand(genome, &live, &mut builder);
        let numbered = Collected::default().collect(&builder, results, genome);
        Self {
            instructions: count(genome.instructions().len()),
            live_instructions: count(live.components.iter().filter(|mask| **mask != 0).count()),
            scalar_operations: written_operations(genome),
            live_scalar_operations: operations(genome, &live),
            numbered_operations: count(numbered.operations()),
            operations: count(Program::lower(genome).operations()),
        }
    }
}

/// Returns [`Counts::scalar_operations`] alone, which needs no lowering.
#[must_use]
pub fn written_operations(genome: &Genome) -> u32 {
    operations(genome, &Liveness::written(genome))
}

/// Number of scalar operations of the live components; moves and negations are free.
fn operations(genome: &Genome, liveness: &Liveness) -> u32 {
    let mut counter = Counter(0);
    expand(genome, liveness, &mut counter);
    counter.0
}

/// Counts operations.
struct Counter(u32);

impl ScalarMachine for Counter {
    type Value = ();

    fn constant(&mut self, _: f32) {}

    fn input(&mut self, _: Input) {}

    fn neg(&mut self, (): ()) {}

    fn add(&mut self, (): (), (): ()) {
        self.0 += 1;
    }

    fn mul(&mut self, (): (), (): ()) {
        self.0 += 1;
    }

    fn function(&mut self, _: Function, (): ()) {
        self.0 += 1;
    }
}

fn count(n: usize) -> u32 {
    u32::try_from(n).expect("a genome has at most 1024 instructions")
}

#[cfg(test)]
mod tests {
    use brood_genome::{BirthKey, Dialect, Variation, live_instructions};

    use super::*;

    #[test]
    fn each_optimisation_leaves_fewer_operations() {
        let (mut live, mut numbered, mut folded) = (0, 0, 0);
        for seed in 0..50 {
            let key = BirthKey { seed, slot: 0, attempt: 0 };
            let genome = Variation::random(Dialect::default()).birth(key);
            let counts = Counts::of(&genome);
            let is_live = live_instructions(&genome);
            assert_eq!(counts.instructions as usize, is_live.len());
            let live_count = is_live.iter().filter(|live| **live).count();
            assert_eq!(counts.live_instructions as usize, live_count);
            assert_eq!(counts.scalar_operations, written_operations(&genome));
            assert_eq!(counts.operations as usize, Program::lower(&genome).operations());
            live += counts.scalar_operations - counts.live_scalar_operations;
            numbered += counts.live_scalar_operations - counts.numbered_operations;
            folded += counts.numbered_operations - counts.operations;
        }
        assert!(live > 0 && numbered > 0 && folded > 0, "{live} {numbered} {folded}");
    }
}
