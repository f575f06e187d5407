//! Derivatives of each operation with respect to its operands.

use brood_genome::{Arithmetic, RANGE};
use brood_program::Operation;

/// Constant that keeps logarithm and reciprocals of the machine finite at 0: 2^-24.
const EPSILON: f32 = 1.0 / 16_777_216.0;
const LN_2: f32 = std::f32::consts::LN_2;

/// Returns the derivatives of `value`, the result of an operation on `a` and `b`, with respect to
/// them. The second is 0 for a unary operation; both are 0 where a clamp acts.
#[inline(always)]
pub(super) fn partials(operation: Operation, a: f32, b: f32, value: f32) -> (f32, f32) {
    let free = if value.abs() < RANGE { 1.0 } else { 0.0 };
    match operation {
        Operation::Add => (free, free),
        Operation::Sub => (free, -free),
        Operation::Mul => (free * b, free * a),
        Operation::Sin => (within(a, -1024.0, 1024.0) * a.cosine(), 0.0),
        Operation::Cos => (-within(a, -1024.0, 1024.0) * a.sine(), 0.0),
        Operation::Ex2 => (free * within(a, -24.0, 16.0) * LN_2 * value, 0.0),
        Operation::Ex2Neg => (-free * within(-a, -24.0, 16.0) * LN_2 * value, 0.0),
        Operation::Lg2 => (2.0 * a / (LN_2 * (a * a + EPSILON)), 0.0),
        Operation::Rcp => {
            let t = a * a + EPSILON;
            ((EPSILON - a * a) / (t * t), 0.0)
        }
        Operation::Rsq => (-a * value * value * value, 0.0),
        Operation::Spl => (free * sigmoid(a), 0.0),
        Operation::SplNeg => (-free * sigmoid(-a), 0.0),
    }
}

#[inline(always)]
fn within(x: f32, low: f32, high: f32) -> f32 {
    if x > low && x < high { 1.0 } else { 0.0 }
}

/// d/dx log2(1 + 2^x).
#[inline(always)]
fn sigmoid(x: f32) -> f32 {
    1.0 / (1.0 + (-x).ex2())
}
