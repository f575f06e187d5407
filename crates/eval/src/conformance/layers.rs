//! Checks of programs with layers. The evaluator may return [`EvalError::Unsupported`]. Otherwise
//! values must be within one rounding to f32 of the f64 reference, and canonical bits if the
//! evaluator is exact.

use brood_genome::{Genome, ModelKind};
use brood_program::Program;

use super::bits::check_bits;
use super::cases::{layered_programs, sample_sets, wild_model};
use crate::{EvalError, Evaluator, ReferenceEvaluator};

/// Largest relative difference of the reflectance of a model from the f64 reference: half a unit in
/// the last place of f32, plus the error of the functions that blocks use. Values below the least
/// normal f32 are compared relative to that.
pub const LAYER_TOLERANCE: f64 = 5.961e-8;

/// Number of random models of each kind; a quarter of their parameters are at the ends of the
/// ranges.
const RANDOM_MODELS: u64 = 6;

/// Checks programs with layers.
///
/// # Panics
/// At the first difference.
pub(super) fn check(evaluator: &dyn Evaluator) {
    let mut programs = layered_programs();
    match evaluator.eval(&[&programs[0]], &sample_sets()[1], &mut Vec::new()) {
        Err(EvalError::Unsupported(_)) => return,
        Ok(()) => {}
        Err(error) => {
            panic!("{}: layers must be evaluated or unsupported, got: {error}", evaluator.name())
        }
    }
    let wild = ModelKind::ALL.into_iter().flat_map(|kind| {
        // Some kinds compute tables, which takes long.
        let count = if kind == ModelKind::RoughPlastic { 1 } else { RANDOM_MODELS };
        (0..count).map(move |seed| wild_model(kind, seed))
    });
    programs.extend(wild.map(|model| {
        let genome = Genome::of_models(vec![model]).expect("one model is enough");
        Program::lower(&genome)
    }));
    if evaluator.is_exact() {
        check_bits(evaluator, &programs);
    }
    let worst = programs.iter().map(|program| difference(evaluator, program)).fold(0.0, f64::max);
    println!("{}: largest error of layers against the reference: {worst:.4e}", evaluator.name());
}

/// Returns the largest relative error of a program that is only layers. Returns 0 for other
/// programs, because their steps are f32.
fn difference(evaluator: &dyn Evaluator, program: &Program) -> f64 {
    if !program.inputs().is_empty() || !program.steps().is_empty() {
        return 0.0;
    }
    let mut worst: f64 = 0.0;
    let mut out = Vec::new();
    for set in sample_sets() {
        evaluator.eval(&[program], &set, &mut out).expect("layers are evaluated");
        let exact = ReferenceEvaluator::reflectance(program, &set);
        for (sample, exact) in exact.iter().enumerate() {
            for (channel, exact) in exact.iter().enumerate() {
                let f = out[channel * set.len() + sample];
                let error = (f64::from(f) - exact).abs() / exact.max(f64::from(f32::MIN_POSITIVE));
                assert!(
                    error <= LAYER_TOLERANCE,
                    "{}: sample {sample} of {}: {f:e}, expected {exact:e}\n{program:#?}",
                    evaluator.name(),
                    set.len(),
                );
                worst = worst.max(error);
            }
        }
    }
    worst
}
