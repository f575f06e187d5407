//! Random bumps, their mutation and crossover.
//!
//! Random bumps are two waves over the texture that two others bend, their product and its square:
//! hammered metal, orange peel, ripples, weaves, dimples and scratches by their values.
//! docs/maths/bumps.md has the formula.

use std::f32::consts::TAU;
use std::sync::LazyLock;

use super::draft::Draft;
use super::mutate;
use super::strength::{MutationScale, Part, Strength};
use crate::interpret::Numbers;
use crate::locks::ResolvedLocks;
use crate::random::{Operator, Stream};
use crate::{
    BUMP_STRENGTH_MAX, BirthKey, Bump, CONSTANTS, Genome, Input, Instruction, Liveness, expand,
};

/// Program of random bumps. C0 to C3 hold four waves: radians per unit of u, radians per unit of v,
/// phase. The waves of C0 and C1 bend those of C2 and C3. C4.x and C4.y hold the radians of
/// bending. C5 holds the weights of the product of both bent waves, of each of them, and of the
/// square of that sum.
const WAVES: &str = "\
brood 1
.dialect paper smooth registers 7
.model lambert
.bump strength 1
.bump DP3 R1, R0, C0
.bump SIN R1, R1.x
.bump DP3 R2, R0, C1
.bump SIN R2, R2.x
.bump DP3 R3, R0, C2
.bump MAD R3, R1, C4.x, R3
.bump SIN R3, R3.x
.bump DP3 R4, R0, C3
.bump MAD R4, R2, C4.y, R4
.bump SIN R4, R4.x
.bump MUL R5, R3, R4
.bump MUL R5, R5, C5.x
.bump MAD R5, R3, C5.y, R5
.bump MAD R5, R4, C5.z, R5
.bump MUL R6, R5, R5
.bump MAD R0, R6, C5.w, R5
";

/// Index of the constants of the bending, and of the weights.
const BENDING: usize = 4;
const WEIGHTS: usize = 5;
/// Largest number of radians along u or v: the machine's sine is constant beyond 1024.
const RADIANS_MAX: f32 = 900.0;
/// Largest number of turns around u.
const TURNS_MAX: f32 = 140.0;
/// Probability that a value mutates, and its step at amount 1 in powers of two.
const VALUE_RATE: f32 = 0.5;
const STEP: f32 = 1.5;
/// Probability at amount 1 that random bumps replace those of the parent.
const REDRAW: f32 = 0.15;

/// Mean slope that mutants do not exceed, unless their parent does.
const STEEPEST: f32 = 0.7;
/// Number of places at which slopes are measured, and the distance of two heights.
const PLACES: u32 = 32;
const SPACING: f32 = 1.0 / 2048.0;

static INSTRUCTIONS: LazyLock<Vec<Instruction>> = LazyLock::new(|| {
    let genome: Genome = WAVES.parse().expect("the program of waves is valid");
    genome.bump().expect("it has bumps").program().instructions().to_vec()
});

/// Ranges of the values of a look: turns around u of the bending waves and of the two carriers,
/// radians along v per radian along u, bending, weights, and the mean slope.
struct Look {
    bending_turns: (f32, f32),
    turns: [(f32, f32); 2],
    across: [(f32, f32); 2],
    bending: (f32, f32),
    weights: [(f32, f32); 4],
    slope: (f32, f32),
}

const LOOKS: [Look; 6] = [
    // Hammered metal.
    Look {
        bending_turns: (2.0, 9.0),
        turns: [(6.0, 18.0), (6.0, 18.0)],
        across: [(0.3, 0.8), (-0.8, -0.3)],
        bending: (0.8, 2.2),
        weights: [(0.5, 1.0), (0.0, 0.5), (0.0, 0.5), (-0.5, 0.0)],
        slope: (0.15, 0.4),
    },
    // Orange peel.
    Look {
        bending_turns: (8.0, 25.0),
        turns: [(25.0, 50.0), (20.0, 45.0)],
        across: [(0.4, 0.9), (-0.9, -0.4)],
        bending: (1.0, 2.5),
        weights: [(0.3, 1.0), (0.2, 0.6), (0.2, 0.6), (0.0, 0.0)],
        slope: (0.06, 0.18),
    },
    // Ripples.
    Look {
        bending_turns: (1.0, 5.0),
        turns: [(0.0, 6.0), (1.0, 4.0)],
        across: [(6.0, 20.0), (0.5, 2.0)],
        bending: (0.5, 3.0),
        weights: [(0.0, 0.0), (1.0, 1.0), (0.0, 0.3), (0.0, 0.4)],
        slope: (0.15, 0.5),
    },
    // Weave.
    Look {
        bending_turns: (1.0, 4.0),
        turns: [(20.0, 48.0), (0.0, 0.0)],
        across: [(0.0, 0.0), (10.0, 24.0)],
        bending: (0.0, 0.15),
        weights: [(-1.0, 1.0), (0.2, 0.6), (0.2, 0.6), (-0.4, 0.4)],
        slope: (0.2, 0.5),
    },
    // Dimples.
    Look {
        bending_turns: (1.0, 4.0),
        turns: [(14.0, 32.0), (14.0, 32.0)],
        across: [(0.5, 0.5), (-0.5, -0.5)],
        bending: (0.0, 0.4),
        weights: [(-0.3, 0.3), (0.5, 0.5), (0.5, 0.5), (-0.9, 0.5)],
        slope: (0.15, 0.45),
    },
    // Scratches.
    Look {
        bending_turns: (2.0, 8.0),
        turns: [(1.0, 3.0), (1.0, 3.0)],
        across: [(20.0, 45.0), (15.0, 40.0)],
        bending: (2.0, 6.0),
        weights: [(0.4, 1.0), (0.3, 1.0), (0.3, 1.0), (0.0, 0.3)],
        slope: (0.06, 0.2),
    },
];

/// Draws bumps. They have no seam where u goes from 1 to 0.
pub(super) fn random(key: BirthKey) -> Bump {
    drawn(&mut Stream::new(key, Operator::RandomBump))
}

fn drawn(stream: &mut Stream) -> Bump {
    let look = &LOOKS[stream.below(LOOKS.len() as u32) as usize];
    let mut constants = Box::new([[0.0; 4]; CONSTANTS]);
    let mut steepest: f32 = 1.0;
    for wave in 0..4 {
        let of_carrier = usize::checked_sub(wave, 2);
        let turns = of_carrier.map_or(look.bending_turns, |carrier| look.turns[carrier]);
        let around = TAU * between(turns, stream).round();
        let across = of_carrier.map_or((-1.0, 1.0), |carrier| look.across[carrier]);
        let across = TAU.max(around) * between(across, stream);
        if of_carrier.is_some() {
            steepest = steepest.max(around.hypot(across));
        }
        constants[wave] = [around, across, between((0.0, TAU), stream), 0.0];
    }
    constants[BENDING] = [between(look.bending, stream), between(look.bending, stream), 0.0, 0.0];
    let weights = look.weights.map(|range| between(range, stream));
    let sum: f32 = weights[..3].iter().map(|weight| weight.abs()).sum();
    let height = between(look.slope, stream) * 2.0 / (sum * steepest);
    let [product, first, second, square] = weights;
    // The square is of the height itself, so that its weight is relative to it.
    constants[WEIGHTS] =
        [product * height, first * height, second * height, square / (sum * height)];
    Bump::new(1.0, INSTRUCTIONS.clone(), constants).expect("values are drawn within the range")
}

fn between((low, high): (f32, f32), stream: &mut Stream) -> f32 {
    low + (high - low) * stream.unit()
}

/// Mutates bumps by an amount of the operators.
pub(super) fn mutate(bump: &mut Bump, amount: f32, key: BirthKey) {
    if amount <= 0.0 {
        return;
    }
    let mut stream = Stream::new(key, Operator::MutateBump);
    if stream.chance(REDRAW * amount) {
        *bump = drawn(&mut stream);
        return;
    }
    let strength =
        scaled(bump.strength(), amount, &mut stream).clamp(-BUMP_STRENGTH_MAX, BUMP_STRENGTH_MAX);
    let program = bump.program();
    let made = if program.instructions() == *INSTRUCTIONS {
        let mut constants = Box::new(*program.constants());
        for wave in 0..4 {
            let [around, across, phase, _] = &mut constants[wave];
            // Whole turns have no seam.
            *around = TAU * (scaled(*around, amount, &mut stream) / TAU).round();
            *around = around.clamp(-TAU * TURNS_MAX, TAU * TURNS_MAX);
            *across = scaled(*across, amount, &mut stream).clamp(-RADIANS_MAX, RADIANS_MAX);
            *phase += STEP * amount * stream.bell();
        }
        for value in constants[BENDING..=WEIGHTS].as_flattened_mut() {
            *value = scaled(*value, amount, &mut stream);
        }
        let is_free = constants.iter().flatten().all(|value| value.abs() <= crate::RANGE);
        let constants = if is_free { constants } else { Box::new(*program.constants()) };
        Bump::new(strength, INSTRUCTIONS.clone(), constants)
    } else {
        let mut draft = Draft::copy(program);
        let strength_of = Strength::new(amount, Part::Program, MutationScale::Operators);
        let none = ResolvedLocks::none(draft.instructions.len());
        mutate::program(&mut draft, strength_of, other(key), false, &none);
        // Steps of constants are relative: heights are far below 1.
        let mut constants = Box::new(*program.constants());
        for value in constants.as_flattened_mut() {
            *value = scaled(*value, amount, &mut stream).clamp(-crate::RANGE, crate::RANGE);
        }
        Bump::new(strength, draft.instructions, constants)
    };
    let made = made.expect("operators keep to the ranges");
    let (before, after) = (steepness(bump), steepness(&made));
    let most = STEEPEST.max(before);
    let strength = if after > most { made.strength() * (most / after) } else { made.strength() };
    *bump = made.with_strength(strength).expect("it is smaller than before");
}

/// Mean slope of bumps at some places, from differences of their heights.
fn steepness(bump: &Bump) -> f32 {
    let program = bump.program();
    let liveness = Liveness::of(program);
    let height = |u: f32, v: f32| {
        let inputs = |input| if input == Input::U { u } else { v };
        let [height, ..] = expand(program, &liveness, &mut Numbers { inputs });
        height
    };
    let places = (0..PLACES).map(|at| {
        // Irrational steps: no wave has the same phase at all places.
        let at = at as f32;
        let (u, v) = ((0.1 + 0.618_034 * at).fract(), (0.1 + 0.414_213_6 * at).fract());
        let here = height(u, v);
        let [along_u, along_v] = [height(u + SPACING, v) - here, height(u, v + SPACING) - here];
        along_u.hypot(along_v) / SPACING
    });
    let sum: f32 = places.sum();
    bump.strength().abs() * sum / PLACES as f32
}

/// Draws whether a value changes; if so, multiplies it.
fn scaled(value: f32, amount: f32, stream: &mut Stream) -> f32 {
    let factor = (STEP * amount * stream.bell()).exp2();
    if stream.chance(VALUE_RATE) { value * factor } else { value }
}

/// Key of the second program of a genome, so that its draws are not those of the first.
fn other(key: BirthKey) -> BirthKey {
    BirthKey { seed: key.seed ^ 0x6275_6d70, ..key }
}

/// Chooses the bumps of one of two parents; `share` is the probability of the second.
pub(super) fn recombine(
    (first, second): (&Genome, &Genome),
    share: f32,
    key: BirthKey,
) -> Option<Bump> {
    let takes_second = Stream::new(key, Operator::RecombineBump).chance(share);
    (if takes_second { second } else { first }).bump().cloned()
}

#[cfg(test)]
#[path = "bump_tests.rs"]
mod tests;
