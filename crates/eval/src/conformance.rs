//! Conformance suite of evaluators, exported so that each backend runs the same checks.
//!
//! An exact evaluator returns the canonical bits in every case. Any other one stays within the
//! tolerance table on single operations. On layers both stay near the f64 reference. No backend has
//! tolerances of its own.

mod cases;
mod layers;
mod tolerance;

pub use cases::{hard_samples, layered_programs, programs, sample_sets, wild_model, wild_program};
pub use layers::LAYER_TOLERANCE;
pub use tolerance::{TOLERANCES, Tolerance};

use brood_program::{Program, execute_layered};
use brood_scene::SampleSet;

use crate::Evaluator;
use crate::layer::Layers;

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

/// Checks every bit over programs of all dialects and every sample set.
fn check_bits(evaluator: &dyn Evaluator, programs: &[Program]) {
    let batch: Vec<&Program> = programs.iter().collect();
    for set in sample_sets() {
        let mut out = Vec::new();
        evaluator.eval(&batch, &set, &mut out).expect("the batch is evaluated");
        for (index, program) in programs.iter().enumerate() {
            let of_program = &out[index * 3 * set.len()..(index + 1) * 3 * set.len()];
            if let Some((sample, got, expected)) = first_difference(program, &set, of_program) {
                panic!(
                    "{}: program {index} of {} operations, sample {sample} of {}: \
                     {got:?}, expected {expected:?}\n{program:#?}",
                    evaluator.name(),
                    program.operations(),
                    set.len(),
                );
            }
        }
    }
}

/// Returns the first sample on which the output of an evaluator for one program differs in any bit
/// from the canonical value, with both values.
#[must_use]
pub fn first_difference(
    program: &Program,
    set: &SampleSet,
    f: &[f32],
) -> Option<(usize, [f32; 3], [f32; 3])> {
    let layers = Layers::of(program);
    (0..set.len()).find_map(|sample| {
        let expected = canonical(program, layers.as_ref(), set, sample);
        let got = [0, 1, 2].map(|channel| f[channel * set.len() + sample]);
        (got.map(f32::to_bits) != expected.map(f32::to_bits)).then_some((sample, got, expected))
    })
}

fn canonical(
    program: &Program,
    layers: Option<&Layers>,
    set: &SampleSet,
    sample: usize,
) -> [f32; 3] {
    let add = |squares: [f32; 3]| match layers {
        Some(layers) => {
            let added = layers.rounded(&set.pair(sample).0);
            [0, 1, 2].map(|channel| squares[channel] + added[channel])
        }
        None => squares,
    };
    let inputs = |input| set.input(input)[sample];
    execute_layered(program, inputs, |constant| constant.canonical, add)
}
