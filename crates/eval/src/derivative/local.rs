//! Derivatives of each operation with respect to its operands.

use brood_genome::{Arithmetic, Functions, RANGE};
use brood_program::Operation;

const EPSILON: f32 = Functions::EPSILON;
const LN_2: f32 = std::f32::consts::LN_2;

/// Returns the derivatives of `value`, the result of an operation on `a` and `b`, with respect to
/// them. The second is 0 for a unary operation; both are 0 where a clamp acts.
#[inline(always)]
pub(super) fn partials(operation: Operation, a: f32, b: f32, value: f32) -> (f32, f32) {
    // 0 where the result is clamped. The results of the functions without this factor are always
    // within the range.
    let free = if value.abs() < RANGE { 1.0 } else { 0.0 };
    match operation {
        Operation::Add => (free, free),
        Operation::Sub => (free, -free),
        Operation::Mul => (free * b, free * a),
        Operation::Sin => (within_angles(a) * a.cosine(), 0.0),
        Operation::Cos => (-within_angles(a) * a.sine(), 0.0),
        Operation::Ex2 => (free * within_exponents(a) * LN_2 * value, 0.0),
        Operation::Ex2Neg => (-free * within_exponents(-a) * LN_2 * value, 0.0),
        Operation::Lg2 => (2.0 * a / (LN_2 * (a * a + EPSILON)), 0.0),
        Operation::Rcp => {
            let t = a * a + EPSILON;
            ((EPSILON - a * a) / (t * t), 0.0)
        }
        Operation::Rsq => (-a * value * value * value, 0.0),
        Operation::Spl => (free * sigmoid(a), 0.0),
        Operation::SplNeg => (-free * sigmoid(-a), 0.0),
        Operation::Saturate => (within(a, 0.0, 1.0), 0.0),
        Operation::SaturateNeg => (-within(-a, 0.0, 1.0), 0.0),
        Operation::Step | Operation::StepNeg => (0.0, 0.0),
    }
}

/// Returns 1 where the clamp of the argument of sine or cosine does not act, else 0.
#[inline(always)]
fn within_angles(x: f32) -> f32 {
    within(x, -Functions::ANGLE_RANGE, Functions::ANGLE_RANGE)
}

/// Returns 1 where the clamp of the argument of the power of two does not act, else 0.
#[inline(always)]
fn within_exponents(x: f32) -> f32 {
    within(x, Functions::EX2_RANGE.0, Functions::EX2_RANGE.1)
}

#[inline(always)]
fn within(x: f32, low: f32, high: f32) -> f32 {
    if x > low && x < high { 1.0 } else { 0.0 }
}

/// Returns the derivative of log2(1 + 2^x).
#[inline(always)]
fn sigmoid(x: f32) -> f32 {
    1.0 / (1.0 + (-x).ex2())
}
