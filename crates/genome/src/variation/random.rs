//! Random genomes: independent draws of every field of every instruction, or a random model if
//! there is no program.

use super::draft::Draft;
use super::layer;
use crate::random::{Operator, Stream};
use crate::{
    BirthKey, CONSTANTS, Dialect, Instruction, Opcode, OpcodeSet, Operand, Register, Swizzle,
    WriteMask,
};

/// Probability that an operand is a constant register.
const CONSTANT_SHARE: f32 = 1.0 / 6.0;
/// Constants are uniform in +-this: enough to change a sign or double a term, too little to drown
/// the inputs.
const CONSTANT_RANGE: f32 = 2.0;

pub(super) fn genome(dialect: Dialect, key: BirthKey) -> Draft {
    if dialect.length == 0 {
        return Draft { layers: layer::random(key), ..Draft::empty(dialect) };
    }
    let mut stream = Stream::new(key, Operator::RandomInstructions);
    let instructions = (0..dialect.length).map(|_| instruction(&dialect, &mut stream)).collect();
    let mut stream = Stream::new(key, Operator::RandomConstants);
    let mut constants = Box::new([[0.0; 4]; CONSTANTS]);
    for component in constants.iter_mut().flatten() {
        *component = constant(&mut stream);
    }
    Draft { instructions, constants, ..Draft::empty(dialect) }
}

fn instruction(dialect: &Dialect, stream: &mut Stream) -> Instruction {
    let opcode = opcode(dialect, stream);
    let dst = stream.below_u8(dialect.registers);
    let mask = mask(stream);
    let mut operands = Vec::with_capacity(3);
    for _ in 0..opcode.operands() {
        let operand = operand(dialect, opcode, &operands, stream);
        operands.push(operand);
    }
    Instruction::new(opcode, dst, mask, &operands, dialect).expect("drawn from the dialect")
}

pub(super) fn opcode(dialect: &Dialect, stream: &mut Stream) -> Opcode {
    let count = match dialect.opcodes {
        OpcodeSet::Paper => Opcode::PAPER,
        OpcodeSet::Extended | OpcodeSet::Directed | OpcodeSet::Surface => Opcode::ALL.len(),
    };
    Opcode::ALL[stream.below(count as u32) as usize]
}

pub(super) fn mask(stream: &mut Stream) -> WriteMask {
    WriteMask::new(1 + stream.below_u8(15)).expect("1 to 15")
}

/// Draws an operand for an instruction with operands `others`. A second constant register must be
/// the same as the first.
pub(super) fn operand(
    dialect: &Dialect,
    opcode: Opcode,
    others: &[Operand],
    stream: &mut Stream,
) -> Operand {
    let register = register(dialect, others, stream);
    Operand { register, swizzle: swizzle(opcode, stream), negate: stream.chance(0.5) }
}

pub(super) fn register(dialect: &Dialect, others: &[Operand], stream: &mut Stream) -> Register {
    if !stream.chance(CONSTANT_SHARE) {
        return Register::Temporary(stream.below_u8(dialect.registers));
    }
    let taken = others.iter().find_map(|operand| match operand.register {
        Register::Constant(_) => Some(operand.register),
        Register::Temporary(_) => None,
    });
    taken.unwrap_or_else(|| Register::Constant(stream.below_u8(128)))
}

pub(super) fn swizzle(opcode: Opcode, stream: &mut Stream) -> Swizzle {
    if opcode.is_scalar() {
        Swizzle::splat(stream.below_u8(4))
    } else {
        Swizzle::new(std::array::from_fn(|_| stream.below_u8(4)))
    }
}

pub(super) fn constant(stream: &mut Stream) -> f32 {
    CONSTANT_RANGE * (2.0 * stream.unit() - 1.0)
}
