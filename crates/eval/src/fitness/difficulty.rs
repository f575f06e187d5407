//! Difficulty of each sample of a target, measured with programs that do not depend on the target.

use brood_genome::{BirthKey, Dialect, Functions, Variation};
use brood_program::Program;
use rayon::prelude::*;

use super::{FitnessTarget, Loss};
use crate::{CanonicalEvaluator, Evaluator};

/// Number of random programs.
const PILOT_PROGRAMS: u32 = 64;
/// Arbitrary seed of these programs.
const PILOT_SEED: u64 = 0x70_69_6c_6f_74;

/// Returns for each sample the sum over the pilot programs of its share of the error of the
/// program. The same on every machine.
pub(super) fn difficulty(target: &FitnessTarget) -> Vec<f64> {
    let random = Variation::random(Dialect::default());
    let key = |slot| BirthKey { seed: PILOT_SEED, slot, attempt: 0 };
    let programs = (0..PILOT_PROGRAMS).map(|slot| Program::lower(&random.birth(key(slot))));
    let programs: Vec<Program> = programs.collect();
    let errors: Vec<Vec<f32>> =
        programs.par_iter().map(|program| errors(program, target)).collect();
    let sum = |errors: &Vec<f32>| errors.iter().map(|error| f64::from(*error)).sum::<f64>();
    let sums: Vec<f64> = errors.iter().map(sum).collect();
    let least = sums.iter().copied().fold(f64::INFINITY, f64::min);
    let mut difficulty = vec![0.0; target.samples()];
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

/// Returns the error of a program on each sample: the e of the sum.
fn errors(program: &Program, target: &FitnessTarget) -> Vec<f32> {
    let (samples, mut f) = (target.samples(), Vec::new());
    let evaluated = CanonicalEvaluator::default().eval(&[program], target.set(), &mut f);
    evaluated.expect("the CPU evaluates every program");
    let mut errors = vec![0.0; samples];
    let (values, weights) = (target.values(), target.weights());
    for (channel, f) in f.chunks_exact(samples).enumerate() {
        let compared = values[channel].iter().zip(weights[channel]).zip(f);
        for (error, ((value, weight), f)) in errors.iter_mut().zip(compared) {
            let scaled = match target.loss() {
                Loss::Logarithmic => Functions::KNOWN.log2(1.0 + f * weight),
                Loss::Squared => f * weight,
            };
            *error += (scaled - value) * (scaled - value);
        }
    }
    errors
}
