//! Scalar operations on the device: their code and their cost. The interpreter has its own code in
//! interpreter.wgsl, where operations that share a function share a case.

use brood_program::Operation;

/// Returns the expression of an operation, with the functions of functions.wgsl.
pub(crate) fn call(operation: Operation, a: &str, b: &str) -> String {
    match operation {
        Operation::Add => format!("limit(hold({a} + {b}))"),
        Operation::Sub => format!("limit(hold({a} - {b}))"),
        Operation::Mul => format!("limit(product({a}, {b}))"),
        Operation::Sin => format!("sine({a}, 0)"),
        Operation::Cos => format!("sine({a}, 1)"),
        Operation::Ex2 => format!("ex2({a})"),
        Operation::Ex2Neg => format!("ex2(-{a})"),
        Operation::Lg2 => format!("lg2({a})"),
        Operation::Rcp => format!("rcp({a})"),
        Operation::Rsq => format!("rsq({a})"),
        Operation::Spl => format!("spl({a})"),
        Operation::SplNeg => format!("spl(-{a})"),
        Operation::Saturate => format!("limit_to({a}, 0.0, 1.0)"),
        Operation::SaturateNeg => format!("limit_to(-{a}, 0.0, 1.0)"),
        Operation::Step => format!("is_positive({a})"),
        Operation::StepNeg => format!("is_positive(-{a})"),
    }
}

/// Returns the approximate cost of a step in loop iterations, so that a tile of sines does not take
/// many times as long as one of sums.
pub(crate) fn cost(operation: Operation) -> u64 {
    match operation {
        Operation::Add | Operation::Sub | Operation::Mul => 1,
        Operation::Saturate | Operation::SaturateNeg | Operation::Step | Operation::StepNeg => 1,
        Operation::Sin | Operation::Cos | Operation::Ex2 | Operation::Ex2Neg => 2,
        Operation::Lg2 | Operation::Rcp | Operation::Rsq => 2,
        Operation::Spl | Operation::SplNeg => 3,
    }
}
