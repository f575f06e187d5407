//! Per-component liveness of a genome: which instructions, and which components of them, can change the result.

use brood_genome::{Genome, Register};

/// For each instruction the components that are both written and still read later, as a mask; 0 is dead code.
pub(crate) fn live_components(genome: &Genome) -> Vec<u8> {
    let mut wanted = [0u8; 16];
    // The result is R0.xyz.
    wanted[0] = 0b0111;
    let mut live = vec![0; genome.instructions().len()];
    for (index, instruction) in genome.instructions().iter().enumerate().rev() {
        let dst = usize::from(instruction.dst());
        let written = instruction.write_mask().bits() & wanted[dst];
        live[index] = written;
        wanted[dst] &= !written;
        for (position, operand) in instruction.operands().enumerate() {
            let Register::Temporary(register) = operand.register else { continue };
            let read = instruction.opcode().reads(position, written);
            for place in (0..4).filter(|place| read >> place & 1 == 1) {
                wanted[usize::from(register)] |= 1 << operand.swizzle.component(place);
            }
        }
    }
    live
}

/// For each instruction whether it can change the result.
#[must_use]
pub fn live_instructions(genome: &Genome) -> Vec<bool> {
    live_components(genome).into_iter().map(|components| components != 0).collect()
}
