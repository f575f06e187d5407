//! Operation counts before and after each pass of lowering.

use brood_genome::{Genome, Liveness, Opcode};

use crate::Program;
use crate::build::Builder;
use crate::lower::{Collected, scalarise};

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
        let instructions = genome.instructions();
        // Numbers values without folding.
        let mut builder = Builder::new(false);
        let results = scalarise(genome, &live, &mut builder, false);
        let numbered = Collected::default().collect(&builder, results, genome);
        let sum = |masks: &mut dyn Iterator<Item = u8>| {
            instructions.iter().zip(masks).map(|(i, mask)| scalar_cost(i.opcode(), mask)).sum()
        };
        Self {
            instructions: count(instructions.len()),
            live_instructions: count(live.components.iter().filter(|mask| **mask != 0).count()),
            scalar_operations: written_operations(genome),
            live_scalar_operations: sum(&mut live.components.iter().copied()),
            numbered_operations: count(numbered.operations()),
            operations: count(Program::lower(genome).operations()),
        }
    }
}

/// Returns [`Counts::scalar_operations`] alone, which needs no lowering.
#[must_use]
pub fn written_operations(genome: &Genome) -> u32 {
    let cost = |i: &brood_genome::Instruction| scalar_cost(i.opcode(), i.write_mask().bits());
    genome.instructions().iter().map(cost).sum()
}

fn count(n: usize) -> u32 {
    u32::try_from(n).expect("a genome has at most 1024 instructions")
}

/// Number of scalar operations of an instruction for the components of `mask`; moves and negations
/// are free.
fn scalar_cost(opcode: Opcode, mask: u8) -> u32 {
    let components = mask.count_ones();
    let any = u32::from(mask != 0);
    match opcode {
        Opcode::Mov => 0,
        Opcode::Add | Opcode::Sub | Opcode::Mul => components,
        Opcode::Mad => 2 * components,
        Opcode::Lrp => 3 * components,
        Opcode::Dp3 => 5 * any,
        Opcode::Dp4 => 7 * any,
        Opcode::Dst => u32::from(mask & 2 != 0),
        Opcode::X2d => 4 * (u32::from(mask & 5 != 0) + u32::from(mask & 10 != 0)),
        Opcode::Sin | Opcode::Cos | Opcode::Ex2 => any,
        Opcode::Lg2 | Opcode::Rcp | Opcode::Rsq | Opcode::Spl => any,
    }
}
