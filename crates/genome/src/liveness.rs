//! Liveness analysis per component: the instructions, and their components, that can change the
//! result of a genome.

use crate::{Genome, Instruction, Opcode, Operand, REGISTERS, Register, Swizzle};

/// Mask of the components of R0 that are the result.
pub(crate) const RESULT: u8 = 0b0111;

/// Parts of a genome that can change its result.
#[derive(Debug, Default)]
pub struct Liveness {
    /// For each instruction, mask of the components that it writes and that are read later; 0 is
    /// dead code.
    pub components: Vec<u8>,
    /// For each register, mask of the components that are read before they are written.
    pub initial: [u8; REGISTERS],
}

/// For each register, mask of the components that are read later. The last entry collects constants
/// and is not used.
pub(crate) type LiveComponents = [u8; REGISTERS + 1];

/// Walks from the last instruction to the first, where `result` is the mask of the components of R0
/// that are the result. Calls `at` with the index of the instruction, the mask of its live
/// components, and the components needed after it. Returns the components that are read before they
/// are written. A component that a move leaves unchanged is not live.
pub(crate) fn walk_backwards(
    instructions: &[Instruction],
    result: u8,
    mut at: impl FnMut(usize, u8, &LiveComponents),
) -> LiveComponents {
    let mut needed = [0u8; REGISTERS + 1];
    needed[0] = result;
    for (index, instruction) in instructions.iter().enumerate().rev() {
        let dst = usize::from(instruction.dst());
        let mut written = instruction.write_mask().bits() & needed[dst];
        let opcode = instruction.opcode();
        if opcode == Opcode::Mov {
            written &= !unchanged_components(instruction.operand(0), instruction.dst());
        }
        at(index, written, &needed);
        if written == 0 {
            continue;
        }
        needed[dst] &= !written;
        for (position, operand) in instruction.operands().enumerate() {
            let register = match operand.register {
                Register::Temporary(register) => usize::from(register),
                Register::Constant(_) => REGISTERS,
            };
            needed[register] |= components(operand.swizzle, opcode.reads(position, written));
        }
    }
    needed
}

impl Liveness {
    /// Analyses a genome.
    #[must_use]
    pub fn of(genome: &Genome) -> Self {
        let mut liveness = Self::default();
        liveness.find(genome);
        liveness
    }

    /// Counts everything that is written as live.
    #[must_use]
    pub fn written(genome: &Genome) -> Self {
        let masks = genome.instructions().iter().map(|it| it.write_mask().bits());
        Self { components: masks.collect(), initial: [0b1111; REGISTERS] }
    }

    /// Analyses another genome, reusing the memory.
    pub fn find(&mut self, genome: &Genome) {
        let instructions = genome.instructions();
        self.components.clear();
        self.components.resize(instructions.len(), 0);
        let components = &mut self.components;
        let needed =
            walk_backwards(instructions, RESULT, |index, live, _| components[index] = live);
        self.initial.copy_from_slice(&needed[..REGISTERS]);
    }
}

/// Components of register `dst` that a move of this operand to it leaves unchanged.
#[inline]
fn unchanged_components(operand: Operand, dst: u8) -> u8 {
    if operand.register != Register::Temporary(dst) || operand.negate {
        return 0;
    }
    let own = |place: usize| u8::from(operand.swizzle.component(place) == place) << place;
    own(0) | own(1) | own(2) | own(3)
}

/// Components that the swizzle reads in these places.
#[inline]
fn components(swizzle: Swizzle, places: u8) -> u8 {
    let component = |place: usize| (places >> place & 1) << swizzle.component(place);
    component(0) | component(1) | component(2) | component(3)
}

/// Returns for each instruction the channels that depend on it, before the colour matrix: bits 0,
/// 1, 2 are red, green, blue.
#[must_use]
pub fn channels_of_instructions(genome: &Genome) -> Vec<u8> {
    let mut masks = vec![0; genome.instructions().len()];
    for channel in 0..3 {
        walk_backwards(genome.instructions(), 1 << channel, |index, live, _| {
            masks[index] |= u8::from(live != 0) << channel;
        });
    }
    masks
}

/// Returns for each instruction true if it can change the result.
#[must_use]
pub fn live_instructions(genome: &Genome) -> Vec<bool> {
    Liveness::of(genome).components.into_iter().map(|components| components != 0).collect()
}
