//! Difficulty of each sample of a target, measured with programs that do not depend on the target.

use brood_genome::{BirthKey, Dialect, Variation};
use brood_program::Program;
use brood_scene::SampleSet;
use rayon::prelude::*;

use super::loss::Loss;
use crate::canonical::CanonicalEvaluator;
use crate::evaluator::Evaluator;

/// Number of random programs.
const PILOT_PROGRAMS: u32 = 64;
/// Arbitrary seed of these programs.
const PILOT_SEED: u64 = 0x70_69_6c_6f_74;

/// Returns for each sample the sum over the pilot programs of its share of the error of the
/// program. The same on every machine.
pub(super) fn difficulty(
    set: &SampleSet,
    values: [&[f32]; 3],
    weights: [&[f32]; 3],
    loss: Loss,
) -> Vec<f64> {
    let random = Variation::random(Dialect::default());
    let key = |slot| BirthKey { seed: PILOT_SEED, slot, attempt: 0 };
    let programs = (0..PILOT_PROGRAMS).map(|slot| Program::lower(&random.birth(key(slot))));
    let programs: Vec<Program> = programs.collect();
    let errors = |program| errors(program, set, values, weights, loss);
    let errors: Vec<Vec<f32>> = programs.par_iter().map(errors).collect();
    let sum = |errors: &Vec<f32>| errors.iter().map(|error| f64::from(*error)).sum::<f64>();
    let sums: Vec<f64> = errors.iter().map(sum).collect();
    let least = sums.iter().copied().fold(f64::INFINITY, f64::min);
    let mut difficulty = vec![0.0; set.len()];
    for (errors, sum) in errors.iter().zip(&sums) {
        // A program whose error is infinite or 0 has no shares.
        if sum.is_finite() && *sum > 0.0 {
            for (difficulty, error) in difficulty.iter_mut().zip(errors) {
                *difficulty += f64::from(*error) / (sum + least);
            }
        }
    }
    difficulty
}

/// Returns the error of a program on each sample: e in the definition of the sum.
fn errors(
    program: &Program,
    set: &SampleSet,
    values: [&[f32]; 3],
    weights: [&[f32]; 3],
    loss: Loss,
) -> Vec<f32> {
    let mut f = Vec::new();
    let evaluated = CanonicalEvaluator::default().eval(&[program], set, &mut f);
    evaluated.expect("the CPU evaluates every program");
    let mut errors = vec![0.0; set.len()];
    for (channel, f) in f.chunks_exact(set.len()).enumerate() {
        let compared = values[channel].iter().zip(weights[channel]).zip(f);
        for (error, ((value, weight), f)) in errors.iter_mut().zip(compared) {
            let deviation = loss.scaled(f * weight) - value;
            *error += deviation * deviation;
        }
    }
    errors
}
