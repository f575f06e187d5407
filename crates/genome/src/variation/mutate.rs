//! Mutation: each instruction changes in one field with a probability that grows with the square of the amount, each
//! constant is pushed a little with a probability that grows with the amount. docs/maths/variation.md has the table.

use super::{Draft, random};
use crate::random::{Operator, Stream};
use crate::{BirthKey, Dialect, Instruction, Operand, RANGE, Swizzle};

/// Probability that an instruction mutates at amount 1.
const INSTRUCTION_RATE: f32 = 0.5;
/// Probability that a constant register mutates at amount 1.
const CONSTANT_RATE: f32 = 0.5;
/// Share of constant mutations that draw afresh instead of pushing.
const CONSTANT_REDRAW: f32 = 0.1;
/// The kinds of instruction mutation and how many of 20 each gets.
const KINDS: [(Kind, u32); 6] = [
    (Kind::Opcode, 4),
    (Kind::Register, 6),
    (Kind::Swizzle, 4),
    (Kind::Negation, 1),
    (Kind::Mask, 2),
    (Kind::Destination, 3),
];

#[derive(Clone, Copy)]
enum Kind {
    Opcode,
    Register,
    Swizzle,
    Negation,
    Mask,
    Destination,
}

/// Mutates in place. With `force`, something changes at any amount above 0.
pub(super) fn draft(draft: &mut Draft, mutation: f32, key: BirthKey, force: bool) {
    let mut stream = Stream::new(key, Operator::MutateInstructions);
    let rate = INSTRUCTION_RATE * mutation * mutation;
    let mut changed = false;
    for instruction in &mut draft.instructions {
        if stream.chance(rate) {
            *instruction = mutant(instruction, &draft.dialect, &mut stream);
            changed = true;
        }
    }
    if force && !changed && mutation > 0.0 {
        let index = stream.below(u32::from(draft.dialect.length)) as usize;
        let instruction = &mut draft.instructions[index];
        *instruction = mutant(instruction, &draft.dialect, &mut stream);
    }
    let mut stream = Stream::new(key, Operator::MutateConstants);
    for constant in draft.constants.iter_mut() {
        if stream.chance(CONSTANT_RATE * mutation) {
            let component = &mut constant[stream.below(4) as usize];
            *component = if stream.chance(CONSTANT_REDRAW) {
                random::constant(&mut stream)
            } else {
                (*component + mutation * stream.bell()).clamp(-RANGE, RANGE)
            };
        }
    }
}

/// The instruction with one field drawn afresh until it differs.
fn mutant(instruction: &Instruction, dialect: &Dialect, stream: &mut Stream) -> Instruction {
    loop {
        let kind = kind(stream);
        let mutant = attempt(instruction, kind, dialect, stream);
        if mutant != *instruction {
            return mutant;
        }
    }
}

fn kind(stream: &mut Stream) -> Kind {
    let mut ticket = stream.below(KINDS.iter().map(|(_, share)| share).sum());
    for (kind, share) in KINDS {
        if ticket < share {
            return kind;
        }
        ticket -= share;
    }
    Kind::Opcode
}

fn attempt(
    instruction: &Instruction,
    kind: Kind,
    dialect: &Dialect,
    stream: &mut Stream,
) -> Instruction {
    let mut opcode = instruction.opcode();
    let mut dst = instruction.dst();
    let mut mask = instruction.write_mask();
    let mut operands: Vec<Operand> = instruction.operands().collect();
    let chosen = stream.below(operands.len() as u32) as usize;
    match kind {
        Kind::Opcode => {
            opcode = random::opcode(dialect, stream);
            operands.truncate(opcode.operands());
            if opcode.is_scalar() {
                let first = operands[0].swizzle.component(0) as u8;
                operands[0].swizzle = Swizzle::splat(first);
            }
            while operands.len() < opcode.operands() {
                let operand = random::operand(dialect, opcode, &operands, stream);
                operands.push(operand);
            }
        }
        Kind::Register => {
            let mut others = operands.clone();
            others.remove(chosen);
            operands[chosen].register = random::register(dialect, &others, stream);
        }
        Kind::Swizzle => operands[chosen].swizzle = random::swizzle(opcode, stream),
        Kind::Negation => operands[chosen].negate = !operands[chosen].negate,
        Kind::Mask => mask = random::mask(stream),
        Kind::Destination => dst = stream.below_u8(dialect.registers),
    }
    Instruction::new(opcode, dst, mask, &operands, dialect).expect("mutation keeps to the dialect")
}
