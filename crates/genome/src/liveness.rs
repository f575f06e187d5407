//! Per-component liveness of a genome: which instructions, and which components of them, can change the result.

use crate::{Genome, Instruction, Opcode, Operand, Register, Swizzle};

/// Temporary registers that a genome can have.
pub const REGISTERS: usize = 16;

/// The components of R0 that are the result.
pub(crate) const RESULT: u8 = 0b0111;

/// What of a genome can change its result.
#[derive(Debug, Default)]
pub struct Liveness {
    /// For each instruction the components that are both written and still read later, as a mask; 0 is dead code.
    pub components: Vec<u8>,
    /// For each register the components that are read before anything is written to them.
    pub initial: [u8; REGISTERS],
}

/// The components of each register that are still read; what is read of constants goes to the last place, which nobody asks for.
pub(crate) type Wanted = [u8; REGISTERS + 1];

/// For each instruction, last to first, the components that are both written and still read later, as a mask, and what is
/// wanted after it.
pub(crate) fn walk_back(
    instructions: &[Instruction],
    result: u8,
    mut at: impl FnMut(usize, u8, &Wanted),
) -> Wanted {
    let mut wanted = [0u8; REGISTERS + 1];
    wanted[0] = result;
    for (index, instruction) in instructions.iter().enumerate().rev() {
        let dst = usize::from(instruction.dst());
        let mut written = instruction.write_mask().bits() & wanted[dst];
        let opcode = instruction.opcode();
        if opcode == Opcode::Mov {
            written &= !idle(instruction.operand(0), instruction.dst());
        }
        at(index, written, &wanted);
        if written == 0 {
            continue;
        }
        wanted[dst] &= !written;
        for (position, operand) in instruction.operands().enumerate() {
            let register = match operand.register {
                Register::Temporary(register) => usize::from(register),
                Register::Constant(_) => REGISTERS,
            };
            wanted[register] |= components(operand.swizzle, opcode.reads(position, written));
        }
    }
    wanted
}

impl Liveness {
    /// Of a genome.
    #[must_use]
    pub fn of(genome: &Genome) -> Self {
        let mut liveness = Self::default();
        liveness.find(genome);
        liveness
    }

    /// Takes the place of what was found before.
    pub fn find(&mut self, genome: &Genome) {
        let instructions = genome.instructions();
        self.components.clear();
        self.components.resize(instructions.len(), 0);
        let components = &mut self.components;
        let wanted = walk_back(instructions, RESULT, |index, live, _| components[index] = live);
        self.initial.copy_from_slice(&wanted[..REGISTERS]);
    }
}

/// The components of a register that a move of this operand to it leaves as they are.
#[inline]
fn idle(operand: Operand, dst: u8) -> u8 {
    if operand.register != Register::Temporary(dst) || operand.negate {
        return 0;
    }
    let own = |place: usize| u8::from(operand.swizzle.component(place) == place) << place;
    own(0) | own(1) | own(2) | own(3)
}

/// The components that stand in these places.
#[inline]
fn components(swizzle: Swizzle, places: u8) -> u8 {
    let component = |place: usize| (places >> place & 1) << swizzle.component(place);
    component(0) | component(1) | component(2) | component(3)
}

/// For each instruction the channels that depend on it before the colour matrix: bits 0, 1, 2 are red, green, blue.
#[must_use]
pub fn channels_of_instructions(genome: &Genome) -> Vec<u8> {
    let mut masks = vec![0; genome.instructions().len()];
    for channel in 0..3 {
        walk_back(genome.instructions(), 1 << channel, |index, live, _| {
            masks[index] |= u8::from(live != 0) << channel;
        });
    }
    masks
}

/// For each instruction whether it can change the result.
#[must_use]
pub fn live_instructions(genome: &Genome) -> Vec<bool> {
    Liveness::of(genome).components.into_iter().map(|components| components != 0).collect()
}
