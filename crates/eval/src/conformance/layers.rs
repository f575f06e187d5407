//! Programs with layers: the canonical bits where an evaluator is exact, and f64 models within one rounding to f32 of their
//! reference; or a plain refusal.

use brood_genome::{Genome, ModelKind};
use brood_program::Program;

use super::{check_bits, layered_programs, sample_sets, wild_model};
use crate::{EvalError, Evaluator, ReferenceEvaluator};

/// How far the reflectance of a model may be from the reference in f64, relative: half a unit of the last place of f32, and
/// the error of the functions that blocks are made of. Below the least normal f32, it is relative to that.
pub const LAYER_TOLERANCE: f64 = 5.961e-8;

/// Random models of each kind, half of their parameters at the ends of the ranges.
const WILD: u64 = 6;

/// # Panics
/// At the first difference.
pub(super) fn check(evaluator: &dyn Evaluator) {
    let mut programs = layered_programs();
    match evaluator.eval(&[&programs[0]], &sample_sets()[1], &mut Vec::new()) {
        Err(EvalError::Unsupported(_)) => return,
        Ok(()) => {}
        Err(error) => panic!("{}: layers are refused as a failure: {error}", evaluator.name()),
    }
    let wild = ModelKind::ALL.into_iter().flat_map(|kind| {
        // Tables of some kinds take long to prepare.
        let count = if kind == ModelKind::RoughPlastic { 1 } else { WILD };
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
    println!("{}: layers are off the reference by {worst:.4e}", evaluator.name());
}

/// The largest one of a program that is nothing but layers; 0 of others, whose own operations are f32.
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
                let off = (f64::from(f) - exact).abs() / exact.max(f64::from(f32::MIN_POSITIVE));
                assert!(
                    off <= LAYER_TOLERANCE,
                    "{}: sample {sample} of {}: {f:e} instead of {exact:e}\n{program:#?}",
                    evaluator.name(),
                    set.len(),
                );
                worst = worst.max(off);
            }
        }
    }
    worst
}
