//! Conformance suite of evaluators, exported so that each backend runs the same checks.
//!
//! An exact evaluator must return the canonical bits in every case. Any other one must stay within
//! the tolerance table on single operations. On programs that are only layers, both must stay
//! within [`LAYER_TOLERANCE`] of the f64 reference. No backend has tolerances of its own.

mod bits;
mod cases;
mod layers;
mod styles;
mod tolerance;

pub use bits::first_difference;
pub use cases::{hard_samples, layered_programs, programs, sample_sets, wild_model, wild_program};
pub use layers::LAYER_TOLERANCE;
pub use styles::{color_bounds, lit_points, weight_probes, wild_style};
pub use tolerance::{TOLERANCES, Tolerance};

use brood_program::Program;

use crate::evaluator::Evaluator;
use bits::check_bits;

/// Runs the whole suite.
///
/// # Panics
/// At the first difference, with the program, the sample and both values.
pub fn check(evaluator: &dyn Evaluator) {
    check_shapes(evaluator);
    if evaluator.is_exact() {
        check_bits(evaluator, &programs(24));
    }
    layers::check(evaluator);
    styles::check(evaluator);
    tolerance::check(evaluator);
}

/// Checks empty batches and sets, many programs at once, and sets of all sizes around a block.
fn check_shapes(evaluator: &dyn Evaluator) {
    let programs = programs(3);
    let batch: Vec<&Program> = programs.iter().collect();
    let mut out = vec![1.0; 7];
    evaluator.eval(&[], &sample_sets()[0], &mut out).expect("an empty batch is evaluated");
    assert!(out.is_empty(), "the result of an empty batch is empty");
    for set in sample_sets() {
        evaluator.eval(&batch, &set, &mut out).expect("the batch is evaluated");
        assert_eq!(out.len(), batch.len() * 3 * set.len(), "one f per program, channel, sample");
        let bad = out.iter().position(|f| !f.is_finite() || *f < 0.0);
        assert!(
            bad.is_none(),
            "f must be finite and not negative, got {:?}",
            bad.map(|at| out[at])
        );
    }
}
