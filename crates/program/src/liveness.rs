//! Per-component liveness of a genome: which instructions, and which components of them, can change the result.

use brood_genome::{Genome, Opcode, Operand, Register, Swizzle};

/// Temporary registers that a genome can have.
pub(crate) const REGISTERS: usize = 16;

/// What of a genome can change its result.
#[derive(Debug, Default)]
pub(crate) struct Liveness {
    /// For each instruction the components that are both written and still read later, as a mask; 0 is dead code.
    pub components: Vec<u8>,
    /// For each register the components that are read before anything is written to them.
    pub initial: [u8; REGISTERS],
}

impl Liveness {
    pub(crate) fn of(genome: &Genome) -> Self {
        let mut liveness = Self::default();
        liveness.find(genome);
        liveness
    }

    /// Takes the place of what was found before.
    pub(crate) fn find(&mut self, genome: &Genome) {
        // What is read of constants goes to the last place, which nobody asks for.
        let mut wanted = [0u8; REGISTERS + 1];
        // The result is R0.xyz.
        wanted[0] = 0b0111;
        let instructions = genome.instructions();
        self.components.clear();
        self.components.resize(instructions.len(), 0);
        for (live, instruction) in self.components.iter_mut().zip(instructions).rev() {
            let dst = usize::from(instruction.dst());
            let mut written = instruction.write_mask().bits() & wanted[dst];
            let opcode = instruction.opcode();
            if opcode == Opcode::Mov {
                written &= !idle(instruction.operand(0), instruction.dst());
            }
            if written == 0 {
                continue;
            }
            *live = written;
            wanted[dst] &= !written;
            for (position, operand) in instruction.operands().enumerate() {
                let register = match operand.register {
                    Register::Temporary(register) => usize::from(register),
                    Register::Constant(_) => REGISTERS,
                };
                wanted[register] |= components(operand.swizzle, opcode.reads(position, written));
            }
        }
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

/// For each instruction whether it can change the result.
#[must_use]
pub fn live_instructions(genome: &Genome) -> Vec<bool> {
    Liveness::of(genome).components.into_iter().map(|components| components != 0).collect()
}
