//! Mutation: each instruction changes in one field with a probability that grows with the square of the amount, each
//! constant is pushed a little with a probability that grows with the amount; what cannot change the result does so four
//! times less often. docs/maths/variation.md has the table.

use super::{Draft, layer, random};
use crate::liveness::{RESULT, walk_back};
use crate::locks::Held;
use crate::random::{Operator, Stream};
use crate::{BirthKey, CONSTANTS, Dialect, Instruction, Operand, RANGE, Swizzle};

/// Probability that a live instruction mutates at amount 1.
const INSTRUCTION_RATE: f32 = 0.8;
/// Probability that a constant register that is read mutates at amount 1.
const CONSTANT_RATE: f32 = 0.5;
/// A dead instruction, and a constant that no live one reads, mutates this many times less often than a live one: most
/// mutations are then to be seen, and dead code still drifts into something new.
const LIVE_FAVOUR: u32 = 4;
/// Draws of a mutant that writes to nothing a locked channel needs, before the instruction stays as it is.
const HELD_DRAWS: u32 = 16;
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

/// What of a draft can change its result.
struct Live {
    instructions: Vec<bool>,
    constants: [bool; CONSTANTS],
}

impl Live {
    fn of(draft: &Draft) -> Self {
        let mut live = Self {
            instructions: vec![false; draft.instructions.len()],
            constants: [false; CONSTANTS],
        };
        walk_back(&draft.instructions, RESULT, |index, components, _| {
            if components != 0 {
                live.instructions[index] = true;
                if let Some(constant) = draft.instructions[index].constant() {
                    live.constants[usize::from(constant)] = true;
                }
            }
        });
        live
    }
}

/// Shares of what is live and what is not.
fn favour(live: bool) -> u32 {
    if live { LIVE_FAVOUR } else { 1 }
}

/// A rate of live code, for code that is live or not.
fn rate(of_live: f32, live: bool) -> f32 {
    of_live * favour(live) as f32 / LIVE_FAVOUR as f32
}

/// Mutates in place what is not held. With `force`, something live changes at any amount above 0 as far as it can be had.
pub(super) fn draft(draft: &mut Draft, mutation: f32, key: BirthKey, force: bool, held: &Held) {
    if !draft.instructions.is_empty() {
        program(draft, mutation, key, force, held);
    }
    // A program has changed already where something must.
    let force = force && draft.instructions.is_empty();
    layer::mutate(&mut draft.layers, mutation, key, force, held.layers());
}

fn program(draft: &mut Draft, mutation: f32, key: BirthKey, force: bool, held: &Held) {
    let live = Live::of(draft);
    let mut stream = Stream::new(key, Operator::MutateInstructions);
    let of_live = INSTRUCTION_RATE * mutation * mutation;
    let mut changed = false;
    for (position, instruction) in draft.instructions.iter_mut().enumerate() {
        if held.instruction(position) || !stream.chance(rate(of_live, live.instructions[position]))
        {
            continue;
        }
        if let Some(mutant) = mutant(instruction, &draft.dialect, &mut stream, held, position) {
            *instruction = mutant;
            changed = true;
        }
    }
    // Of small amounts, small changes are expected: the forced one is a constant as often as not.
    let force_instruction = force && !changed && stream.chance(2.0 * mutation);
    if force_instruction && mutation > 0.0 {
        changed = mutate_one(draft, &live, held, &mut stream);
    }
    let mut stream = Stream::new(key, Operator::MutateConstants);
    for (index, constant) in draft.constants.iter_mut().enumerate() {
        if held.constant(index)
            || !stream.chance(rate(CONSTANT_RATE * mutation, live.constants[index]))
        {
            continue;
        }
        push(constant, mutation, &mut stream);
        changed |= live.constants[index];
    }
    if force && !changed && mutation > 0.0 {
        let free = |index: &usize| live.constants[*index] && !held.constant(*index);
        let indices: Vec<usize> = (0..CONSTANTS).filter(free).collect();
        if indices.is_empty() {
            mutate_one(draft, &live, held, &mut stream);
        } else {
            let chosen = indices[stream.below(indices.len() as u32) as usize];
            push(&mut draft.constants[chosen], mutation, &mut stream);
        }
    }
}

/// One component of a constant pushed a little, or now and then drawn afresh.
fn push(constant: &mut [f32; 4], mutation: f32, stream: &mut Stream) {
    let component = &mut constant[stream.below(4) as usize];
    *component = if stream.chance(CONSTANT_REDRAW) {
        random::constant(stream)
    } else {
        (*component + mutation * stream.bell()).clamp(-RANGE, RANGE)
    };
}

/// Mutates one instruction, each with its share, if any may; whether it did.
fn mutate_one(draft: &mut Draft, live: &Live, held: &Held, stream: &mut Stream) -> bool {
    let free = |position: &usize| !held.instruction(*position);
    let share = |position: usize| favour(live.instructions[position]);
    let positions = || (0..draft.instructions.len()).filter(free);
    let shares: u32 = positions().map(share).sum();
    if shares == 0 {
        return false;
    }
    let mut ticket = stream.below(shares);
    let chosen = positions().find(|position| match ticket.checked_sub(share(*position)) {
        Some(rest) => {
            ticket = rest;
            false
        }
        None => true,
    });
    let position = chosen.expect("the ticket is below the sum of the shares");
    let instruction = &draft.instructions[position];
    let mutant = mutant(instruction, &draft.dialect, stream, held, position);
    let found = mutant.is_some();
    draft.instructions[position] = mutant.unwrap_or(*instruction);
    found
}

/// The instruction with one field drawn afresh until it differs and writes to nothing that is held; none where that takes
/// too many draws.
fn mutant(
    instruction: &Instruction,
    dialect: &Dialect,
    stream: &mut Stream,
    held: &Held,
    position: usize,
) -> Option<Instruction> {
    let mut refused = 0;
    while refused < HELD_DRAWS {
        let kind = kind(stream);
        let mutant = attempt(instruction, kind, dialect, stream);
        if mutant == *instruction {
            continue;
        }
        if held.allows(position, &mutant) {
            return Some(mutant);
        }
        refused += 1;
    }
    None
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
