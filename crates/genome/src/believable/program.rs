//! Code of believable programs, and the places of their values among the constants.
//!
//! A structure is the plain one with modules before and after it: a stretch and a pattern change
//! ln tan theta_h before the units read it, and a pattern mixes two sets of colours at the end.
//! docs/maths/believable.md has the formulas.

use std::ops::Range;
use std::sync::LazyLock;

use super::structure::{self, Structure, TERMS, WEIGHTS};
use crate::lobes::Code;
use crate::{CONSTANTS, Genome, Instruction, Opcode, Operand, RANGE, Register, Swizzle};

/// Number of values of a pattern: turns, waves along v and phases of four waves, four weights with
/// which two of them bend the others, five weights of the form, its bias, and the narrowing.
pub(super) const PATTERN: usize = 23;
/// Number of values of a stretch.
const STRETCH: usize = 2;
/// RCP fades to 0 for small numbers: its arguments are this much larger, and a value of a stretch
/// that its result is multiplied by.
pub(super) const SCALE: f32 = 4096.0;

/// Values of a program in order, as stored: weights, colours; of a stretch; of a pattern, then its
/// colours.
pub(super) type Values = Vec<f64>;

/// Ranges of the parts of [`Values`]. Parts that the structure does not have are empty.
pub(super) struct Layout {
    pub(super) weights: Range<usize>,
    pub(super) colours: Range<usize>,
    pub(super) stretch: Range<usize>,
    pub(super) pattern: Range<usize>,
    pub(super) second: Range<usize>,
}

impl Layout {
    pub(super) fn of(structure: Structure) -> Self {
        let Structure { is_brushed, is_patterned } = structure;
        let mut from = 0;
        let mut next = |count: usize, is_there: bool| {
            let part = from..from + if is_there { count } else { 0 };
            from = part.end;
            part
        };
        Self {
            weights: next(WEIGHTS, true),
            colours: next(3 * TERMS, true),
            stretch: next(STRETCH, is_brushed),
            pattern: next(PATTERN, is_patterned),
            second: next(3 * TERMS, is_patterned),
        }
    }
}

/// The instructions that all programs of a structure share, and the places of their values.
struct Template {
    structure: Structure,
    instructions: Vec<Instruction>,
    /// Constant register and component of each value.
    places: Vec<(usize, usize)>,
}

static TEMPLATES: LazyLock<Vec<Template>> = LazyLock::new(|| {
    Structure::ALL
        .into_iter()
        .map(|structure| {
            // Different values, which are then found among the constants.
            let count = Layout::of(structure).second.end;
            let values: Values = (0..count).map(|at| 100.0 + at as f64).collect();
            let genome = genome(structure, &values);
            let place = |value: &f64| {
                let held = genome.constants().as_flattened();
                let place = held.iter().position(|held| (f64::from(*held) - value).abs() < 0.1);
                let place = place.expect("every value is a constant");
                (place / 4, place % 4)
            };
            let instructions = genome.instructions().to_vec();
            Template { structure, instructions, places: values.iter().map(place).collect() }
        })
        .collect()
});

/// Structure of a program; `None` if it has the instructions of none.
pub(crate) fn structure_of(instructions: &[Instruction]) -> Option<Structure> {
    TEMPLATES.iter().find(|one| one.instructions == instructions).map(|one| one.structure)
}

/// Structure and values of a program; `None` if it has the instructions of no structure.
pub(super) fn read(
    instructions: &[Instruction],
    constants: &[[f32; 4]; CONSTANTS],
) -> Option<(Structure, Values)> {
    let template = TEMPLATES.iter().find(|one| one.instructions == instructions)?;
    let value = |(register, component): &(usize, usize)| constants[*register][*component].into();
    Some((template.structure, template.places.iter().map(value).collect()))
}

/// Writes the values that differ from `old`, of the same structure, into the constants.
pub(super) fn write(
    structure: Structure,
    (new, old): (&[f64], &[f64]),
    constants: &mut [[f32; 4]; CONSTANTS],
) {
    let template = TEMPLATES.iter().find(|one| one.structure == structure);
    let template = template.expect("there is one of each structure");
    for (at, (register, component)) in template.places.iter().enumerate() {
        if new[at].to_bits() != old[at].to_bits() {
            constants[*register][*component] = stored(new[at]);
        }
    }
}

#[expect(clippy::cast_possible_truncation, reason = "the machine is of f32")]
fn stored(value: f64) -> f32 {
    (value as f32).clamp(-RANGE, RANGE)
}

/// Program of a structure with these values, under the energy limit.
pub(super) fn genome(structure: Structure, values: &[f64]) -> Genome {
    let layout = Layout::of(structure);
    let shape = structure::shape();
    let mut parameters = vec![0.0; shape.len()];
    for (weight, value) in structure::weights().iter().zip(&values[layout.weights]) {
        // Lowering skips weights of 0, which would change the instructions.
        parameters[weight.index] = if value.abs() < 1e-6 { 1e-6 } else { *value };
    }
    let mut code = Code::new();
    let mut inputs = shape.operands().expect("registers hold all inputs");
    if structure.is_brushed {
        inputs[0] = stretched(&mut code, &values[layout.stretch], inputs[0]);
    }
    if structure.is_patterned {
        inputs[0] = pattern(&mut code, &values[layout.pattern], inputs[0]);
    }
    let terms = shape.write(&mut code, &parameters, &inputs);
    let mut mix = |register: u8, part: Range<usize>| {
        let colours = &values[part];
        code.combine(register, 3, &terms, |channel, term| colours[3 * term + channel]);
    };
    mix(0, layout.colours);
    if structure.is_patterned {
        mix(SECOND, layout.second);
        let place = at(T, 0);
        code.push(Opcode::Lrp, (0, 7), &[place, whole(SECOND), whole(0)]);
    }
    let genome = code.genome(structure::dialect()).expect("the structure fits in a program");
    let length = structure::dialect().length;
    let genome = genome.padded(length).expect("the program is shorter than the dialect's length");
    genome.with_limit(true)
}

/// Registers that hold no input that terms read. Register of the second colours:
const SECOND: u8 = 2;
/// Results of the modules: x is the pattern, y and z are ln tan theta_h.
const T: u8 = 11;
/// Phases, waves, products of waves.
const PHASES: u8 = 13;
const WAVES: u8 = 14;
const PRODUCTS: u8 = 15;

fn swizzled(register: u8, components: [u8; 4]) -> Operand {
    let swizzle = Swizzle::new(components);
    Operand { register: Register::Temporary(register), swizzle, negate: false }
}

fn whole(register: u8) -> Operand {
    swizzled(register, [0, 1, 2, 3])
}

fn at(register: u8, component: u8) -> Operand {
    swizzled(register, [component; 4])
}

fn part(of: Operand, components: [u8; 4]) -> Operand {
    Operand { swizzle: Swizzle::new(components), ..of }
}

/// Adds the logarithm of a stretch along u or v to ln tan theta_h: 1/2 ln(cosh s + sinh s cos
/// 2 phi_h). Returns the sum.
fn stretched(code: &mut Code, values: &[f64], input: Operand) -> Operand {
    let k = code.constant([-1.0, 2.0, 0.5, SCALE]);
    let [minus, two, half, scale] = [0, 1, 2, 3].map(|one| part(k, [one; 4]));
    let own =
        code.constant([stored(values[0]), stored(values[1]), std::f32::consts::LN_2 / 4.0, 0.0]);
    // p1, p3, p5, p6; q2; cos_i cos_o.
    let [p1, p3, p5, p6] = [0, 1, 2, 3].map(|one| at(0, one));
    let (q2, cosines) = (at(1, 1), at(8, 0));
    use Opcode::{Lg2, Mad, Mul, Rcp};
    let (x2, y2, z2, x3, y3) = (at(2, 0), at(2, 1), at(2, 2), at(3, 0), at(3, 1));
    let (x4, y4, z4) = (at(4, 0), at(4, 1), at(4, 2));
    let mut push = |opcode, place, operands: &[Operand]| code.push(opcode, place, operands);
    // S = sin_i^2 + sin_o^2 = 2 - p1^2 + 2 cos_i cos_o.
    push(Mul, (2, 1), &[p1, p1]);
    push(Mad, (2, 1), &[x2, minus, two]);
    push(Mad, (2, 1), &[cosines, two, x2]);
    // With s the sum of the tangential parts of wi and wo, s_x^2 - s_y^2 = 2 p5 + D,
    // D = (S p3 p5 + p1 q2 p6 / 2) / (p5^2 + p6^2).
    push(Mul, (2, 2), &[p5, p5]);
    push(Mad, (2, 2), &[p6, p6, y2]);
    push(Mul, (2, 2), &[y2, scale]);
    push(Rcp, (2, 4), &[y2]);
    push(Mul, (2, 4), &[z2, scale]);
    push(Mul, (3, 1), &[p1, q2]);
    push(Mul, (3, 1), &[x3, half]);
    push(Mul, (3, 1), &[x3, p6]);
    push(Mul, (3, 2), &[x2, p3]);
    push(Mad, (3, 1), &[y3, p5, x3]);
    push(Mul, (3, 1), &[x3, z2]);
    // |s|^2 = S + 2 p3; cos 2 phi_h is the quotient of the two, here divided by SCALE.
    push(Mad, (4, 1), &[p3, two, x2]);
    push(Mad, (4, 2), &[p5, two, x3]);
    push(Mul, (4, 1), &[x4, scale]);
    push(Rcp, (4, 4), &[x4]);
    push(Mul, (4, 2), &[y4, z4]);
    let [cosh, sinh, quarter] = [0, 1, 2].map(|one| part(own, [one; 4]));
    push(Mad, (4, 2), &[y4, sinh, cosh]);
    push(Lg2, (4, 2), &[y4]);
    push(Mad, (T, 4), &[y4, quarter, input]);
    at(T, 2)
}

/// Computes a pattern of u and v, from 0 to 1, and adds its narrowing to ln tan theta_h. Returns
/// the sum.
fn pattern(code: &mut Code, values: &[f64], input: Operand) -> Operand {
    let mut four = |from: usize| {
        let value = |component: usize| stored(values.get(from + component).copied().unwrap_or(0.0));
        code.constant([0, 1, 2, 3].map(value))
    };
    let (turns, across, phases, warp) = (four(0), four(4), four(8), four(12));
    // Weights of squares, product and first wave; of the second wave, bias and narrowing.
    let (form, rest) = (four(16), four(20));
    let (u, v) = (at(1, 2), at(1, 3));
    use Opcode::{Add, Dp4, Ex2, Mad, Mul, Sin, Spl};
    let mut push = |opcode, place, operands: &[Operand]| code.push(opcode, place, operands);
    push(Mul, (PHASES, 15), &[u, turns]);
    push(Mad, (PHASES, 15), &[v, across, whole(PHASES)]);
    push(Add, (PHASES, 15), &[whole(PHASES), phases]);
    // Two waves bend the phases of the other two.
    push(Sin, (WAVES, 1), &[at(PHASES, 0)]);
    push(Sin, (WAVES, 2), &[at(PHASES, 1)]);
    push(Mad, (PHASES, 12), &[at(WAVES, 0), part(warp, [0, 1, 0, 1]), whole(PHASES)]);
    push(Mad, (PHASES, 12), &[at(WAVES, 1), part(warp, [2, 3, 2, 3]), whole(PHASES)]);
    push(Sin, (WAVES, 4), &[at(PHASES, 2)]);
    push(Sin, (WAVES, 8), &[at(PHASES, 3)]);
    // z^2, w^2, z w, z.
    push(Mul, (PRODUCTS, 7), &[swizzled(WAVES, [2, 3, 2, 2]), swizzled(WAVES, [2, 3, 3, 3])]);
    push(Mul, (PRODUCTS, 8), &[at(WAVES, 2), at(9, 3)]);
    push(Dp4, (T, 1), &[whole(PRODUCTS), form]);
    push(Mad, (T, 1), &[at(WAVES, 3), part(rest, [0; 4]), at(T, 0)]);
    push(Add, (T, 1), &[at(T, 0), part(rest, [1; 4])]);
    // 1 / (1 + 2^x).
    push(Spl, (T, 1), &[at(T, 0)]);
    push(Ex2, (T, 1), &[Operand { negate: true, ..at(T, 0) }]);
    push(Mad, (T, 2), &[at(T, 0), part(rest, [2; 4]), input]);
    at(T, 1)
}
