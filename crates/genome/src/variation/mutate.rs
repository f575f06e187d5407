//! Mutation of programs. Each instruction changes in one field, with a probability that grows with
//! the square of the amount. Each constant is perturbed, with a probability that grows with the
//! amount. Parts that cannot change the result mutate four times less often.
//! docs/maths/variation.md has the table of rates.

use super::draft::Draft;
use super::strength::{MutationScale, Part, Strength};
use super::{layer, paint, random, toward};
use crate::believable::{self, Rules, Structure};
use crate::effect;
use crate::liveness::{RESULT, walk_backwards};
use crate::locks::ResolvedLocks;
use crate::random::{Operator, Stream};
use crate::{BirthKey, CONSTANTS, Dialect, Instruction, Operand, RANGE, Swizzle};

/// Probability that a live instruction mutates at amount 1.
const INSTRUCTION_RATE: f32 = 0.8;
/// Ratio of the mutation rates of live and dead code (also of constants that live code reads or
/// not). Most mutations are then visible, and dead code still drifts.
const LIVE_WEIGHT: u32 = 4;
/// Draws of a mutant that locked channels allow, before the instruction is left unchanged.
const MAX_LOCKED_DRAWS: u32 = 16;
/// Kinds of instruction mutation with their weights, out of 20.
const KINDS: [(Kind, u32); 6] = [
    (Kind::Opcode, 4),
    (Kind::Register, 6),
    (Kind::Swizzle, 4),
    (Kind::Negation, 1),
    (Kind::Mask, 2),
    (Kind::Destination, 3),
];

/// Field of an instruction that is redrawn.
#[derive(Clone, Copy)]
enum Kind {
    Opcode,
    Register,
    Swizzle,
    Negation,
    Mask,
    Destination,
}

/// Instructions and constants of a draft that can change its result.
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
        walk_backwards(&draft.instructions, RESULT, |index, components, _| {
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

/// Weight of live or dead code.
fn weight(live: bool) -> u32 {
    if live { LIVE_WEIGHT } else { 1 }
}

/// Mutation rate of live or dead code, given the rate for live code.
fn rate(of_live: f32, live: bool) -> f32 {
    of_live * weight(live) as f32 / LIVE_WEIGHT as f32
}

/// Rules of a mutation.
#[derive(Clone, Copy)]
pub(super) struct How {
    /// Amount of mutation.
    pub(super) mutation: f32,
    /// Meaning of the amount.
    pub(super) scale: MutationScale,
    /// True if something must change at any amount above 0.
    pub(super) force: bool,
    /// In lineages that start with believable programs: modules that children may have.
    pub(super) believable: Option<Structure>,
}

impl How {
    /// Rules for believable programs under locks, if the lineage has such a start.
    pub(super) fn rules(self, locked: &ResolvedLocks) -> Option<Rules> {
        // Locks name instructions and constants by their places.
        let most = self.believable?;
        let most = (!locked.locks_any()).then_some(most);
        Some(Rules { channels: locked.channels(), steered: locked.kept(), most })
    }
}

/// Mutates parts that are not locked. With `force`, at least one instruction, or one constant that
/// live code reads, changes at any amount above 0 if the locks allow it. Without a program, one
/// value of a layer does.
pub(super) fn draft(draft: &mut Draft, key: BirthKey, how: How, locked: &ResolvedLocks) {
    let How { mutation, scale, force, .. } = how;
    let strength = |part| Strength::new(mutation, part, scale);
    let is_done = parameters(draft, strength(Part::Believable), key, (how, locked));
    if !draft.instructions.is_empty() && !is_done {
        program(draft, strength(Part::Program), key, force, locked);
    }
    // A forced change has already happened in the program, if there is one.
    let force = force && draft.instructions.is_empty();
    if !draft.effects.is_empty() {
        // A change of the program may not show, so that one of the effects is forced too.
        let is_by_brdf = effect::are_by_brdf(&draft.effects);
        let amounts = (mutation, !draft.instructions.is_empty());
        paint::mutate(&mut draft.effects, amounts, (key, how.force), locked.effects());
        if !is_by_brdf {
            return;
        }
    }
    let strength = strength(Part::Layers);
    layer::mutate(&mut draft.layers, strength, key, force, locked.layers());
    let toward = (locked.kept().toward, strength.amount);
    toward::step(&mut draft.layers, toward, key, locked.layers());
}

/// Mutates the parameters of a believable program, except locked ones. Returns false if the program
/// is not believable, or the lineage has another start.
fn parameters(
    draft: &mut Draft,
    strength: Strength,
    key: BirthKey,
    (how, locked): (How, &ResolvedLocks),
) -> bool {
    let Some(rules) = how.rules(locked) else { return false };
    let old = draft.constants.clone();
    let program = (&mut draft.instructions, &mut *draft.constants);
    let is_done = believable::mutate(program, strength.amount, rules, key);
    locked.restore_named(&mut draft.constants, &old);
    is_done
}

/// Mutates instructions, then constants.
pub(super) fn program(
    draft: &mut Draft,
    strength: Strength,
    key: BirthKey,
    force: bool,
    locked: &ResolvedLocks,
) {
    let mutation = strength.amount;
    let live = Live::of(draft);
    let mut stream = Stream::new(key, Operator::MutateInstructions);
    let of_live = INSTRUCTION_RATE * mutation * mutation;
    let mut changed = false;
    for (position, instruction) in draft.instructions.iter_mut().enumerate() {
        if locked.locks_instruction(position)
            || !stream.chance(rate(of_live, live.instructions[position]))
        {
            continue;
        }
        if let Some(mutant) = mutant(instruction, &draft.dialect, &mut stream, locked, position) {
            *instruction = mutant;
            changed = true;
        }
    }
    // At small amounts, small changes are expected: the forced change is then a constant.
    let force_instruction = force && !changed && stream.chance(strength.forced_instruction());
    if force_instruction && mutation > 0.0 {
        changed = mutate_one(draft, &live, locked, &mut stream);
    }
    if mutation <= 0.0 {
        return;
    }
    let mut stream = Stream::new(key, Operator::MutateConstants);
    for (index, constant) in draft.constants.iter_mut().enumerate() {
        if locked.locks_constant(index)
            || !stream.chance(rate(strength.value_rate(), live.constants[index]))
        {
            continue;
        }
        perturb(constant, strength, &mut stream);
        changed |= live.constants[index];
    }
    if force && !changed {
        let free = |index: &usize| live.constants[*index] && !locked.locks_constant(*index);
        let indices: Vec<usize> = (0..CONSTANTS).filter(free).collect();
        if indices.is_empty() {
            mutate_one(draft, &live, locked, &mut stream);
        } else {
            let chosen = indices[stream.below(indices.len() as u32) as usize];
            perturb(&mut draft.constants[chosen], strength, &mut stream);
        }
    }
}

/// Perturbs one component of a constant, or sometimes redraws it.
fn perturb(constant: &mut [f32; 4], strength: Strength, stream: &mut Stream) {
    let component = &mut constant[stream.below(4) as usize];
    *component = if stream.chance(strength.redraw()) {
        random::constant(stream)
    } else {
        (*component + strength.amount * stream.bell()).clamp(-RANGE, RANGE)
    };
}

/// Mutates one instruction, drawn by weight, if any may. Returns true if it did.
fn mutate_one(draft: &mut Draft, live: &Live, locked: &ResolvedLocks, stream: &mut Stream) -> bool {
    let free = |position: &usize| !locked.locks_instruction(*position);
    let share = |position: usize| weight(live.instructions[position]);
    let positions = || (0..draft.instructions.len()).filter(free);
    let shares: u32 = positions().map(share).sum();
    if shares == 0 {
        return false;
    }
    let mut draw = stream.below(shares);
    let chosen = positions().find(|position| match draw.checked_sub(share(*position)) {
        Some(rest) => {
            draw = rest;
            false
        }
        None => true,
    });
    let position = chosen.expect("the draw is below the sum of the shares");
    let instruction = &draft.instructions[position];
    let mutant = mutant(instruction, &draft.dialect, stream, locked, position);
    let found = mutant.is_some();
    draft.instructions[position] = mutant.unwrap_or(*instruction);
    found
}

/// Returns the instruction with one field redrawn until it differs and the locks allow it; `None`
/// after too many draws.
fn mutant(
    instruction: &Instruction,
    dialect: &Dialect,
    stream: &mut Stream,
    locked: &ResolvedLocks,
    position: usize,
) -> Option<Instruction> {
    let mut rejected = 0;
    while rejected < MAX_LOCKED_DRAWS {
        let kind = kind(stream);
        let mutant = attempt(instruction, kind, dialect, stream);
        if mutant == *instruction {
            continue;
        }
        if locked.allows(position, &mutant) {
            return Some(mutant);
        }
        rejected += 1;
    }
    None
}

/// Draws a kind by weight.
fn kind(stream: &mut Stream) -> Kind {
    let mut draw = stream.below(KINDS.iter().map(|(_, share)| share).sum());
    for (kind, share) in KINDS {
        if draw < share {
            return kind;
        }
        draw -= share;
    }
    Kind::Opcode
}

/// Returns the instruction with the field of this kind redrawn, which may give the same value.
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
