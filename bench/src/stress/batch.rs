//! Evaluations of programs on samples: every level against the scalar evaluator, in parallel over
//! batches.

use anyhow::{Context, Result};
use brood_brdf::DirectionPair;
use brood_eval::conformance::{first_difference, hard_samples};
use brood_eval::{CanonicalEvaluator, Evaluator, Level};
use brood_program::Program;
use brood_protocol::Backend;
use brood_scene::SampleSet;
use brood_worker::Renderer;
use rayon::prelude::*;
use serde::Serialize;

use super::counts::counts;
use super::program::{StressProgram, candidate};
use super::scalar::Scalar;
use crate::output;

/// Number of programs of a batch.
const PROGRAMS: u64 = 64;
/// Number of samples of a batch.
pub const SAMPLES: usize = 4096;
/// One batch in this many also runs on the GPU.
const GPU_SHARE: u64 = 16;
/// Cosines below this count as grazing.
const GRAZING_COS: f64 = 1e-3;

counts! {
    /// Counts over all batches. Kinds of directions are counted once per program that runs on them.
    #[derive(Debug, Clone, Copy, Default, Serialize)]
    pub struct Batches {
        pub evaluations_per_level: u64,
        pub evaluations_with_large_constants: u64,
        /// At least one direction has a cosine below [`GRAZING_COS`].
        pub grazing: u64,
        /// At least one direction is the normal.
        pub at_the_pole: u64,
        /// The tangential parts of both directions cancel.
        pub antipodal: u64,
        /// Both directions are equal, but not the normal.
        pub equal: u64,
        /// Number of NaN and infinite values, of the scalar evaluator and of all levels.
        pub not_finite: u64,
        pub negative: u64,
        /// Values of any level whose bits differ from the scalar evaluator's.
        pub differing_from_scalar: u64,
        /// Evaluations in which the scalar evaluator was compared with the definition of the steps.
        pub scalar_checked: u64,
        /// Programs for which it differed.
        pub scalar_differing: u64,
        pub gpu_evaluations: u64,
        /// Values whose bits differ, without subnormal ones flushed to zero.
        pub gpu_differing: u64,
        /// Values that are 0 or subnormal on both sides with differing bits.
        pub gpu_subnormal_differing: u64,
    }
}

/// Runs all batches; the result does not depend on the number of threads.
pub fn run(seed: u64, evaluations: u64, gpu: &Renderer) -> Result<Batches> {
    let batches = evaluations.div_ceil(PROGRAMS * SAMPLES as u64);
    let bar = output::bar(batches, "evaluating");
    let has_gpu = gpu.worker_report().gpu;
    let one = |index: u64| {
        let on_gpu = has_gpu && index.is_multiple_of(GPU_SHARE);
        let found = batch(seed.wrapping_add(index), on_gpu.then_some(gpu));
        bar.inc(1);
        found
    };
    let total = (0..batches).into_par_iter().map(one);
    let total = total.try_reduce(Batches::default, |a, b| Ok(a.plus(b)));
    bar.finish_and_clear();
    total
}

/// Runs one batch at every level, and on the GPU if one is given.
fn batch(seed: u64, gpu: Option<&Renderer>) -> Result<Batches> {
    let first = seed.wrapping_mul(PROGRAMS);
    let candidates: Vec<StressProgram> =
        (0..PROGRAMS).map(|slot| candidate(first.wrapping_add(slot))).collect();
    let programs: Vec<&Program> = candidates.iter().map(|c| &c.program).collect();
    let set = hard_samples(seed, SAMPLES);
    let samples = set.len() as u64;
    let extreme = candidates.iter().filter(|c| c.is_extreme).count() as u64;
    let mut found = Batches {
        evaluations_per_level: PROGRAMS * samples,
        evaluations_with_large_constants: extreme * samples,
        ..Batches::default()
    };
    found.count_directions(&set);
    let scalar = scalar(&programs, &set);
    // Checks the scalar evaluator itself, on one program of each batch.
    let checked = (seed % PROGRAMS) as usize;
    let of_program = 3 * set.len();
    let own = &scalar[checked * of_program..(checked + 1) * of_program];
    found.scalar_checked = samples;
    found.scalar_differing += u64::from(first_difference(programs[checked], &set, own).is_some());
    found.not_finite += count(&scalar, |value| !value.is_finite());
    found.negative += count(&scalar, |value| value < 0.0);
    let mut out = Vec::new();
    for level in Level::available() {
        CanonicalEvaluator::with_level(level).eval(&programs, &set, &mut out)?;
        found.not_finite += count(&out, |value| !value.is_finite());
        found.negative += count(&out, |value| value < 0.0);
        found.differing_from_scalar += differing(&scalar, &out).0;
    }
    if let Some(gpu) = gpu {
        let out = gpu.reflectance(Backend::Gpu, &programs, &set).context("evaluate on the GPU")?;
        let (all, subnormal) = differing(&scalar, &out);
        found.gpu_evaluations += PROGRAMS * samples;
        found.gpu_differing += all - subnormal;
        found.gpu_subnormal_differing += subnormal;
    }
    Ok(found)
}

impl Batches {
    /// Counts the hard cases among the samples, times the programs that run on them.
    fn count_directions(&mut self, set: &SampleSet) {
        for sample in 0..set.len() {
            let (pair, _) = set.pair(sample);
            let (low, high) = ends(pair.cos_i(), pair.cos_o());
            let (l, v) = (pair.wi().truncate(), pair.wo().truncate());
            self.grazing += PROGRAMS * u64::from(low < GRAZING_COS);
            self.at_the_pole += PROGRAMS * u64::from(high >= 1.0);
            self.antipodal += PROGRAMS * u64::from(is_antipodal(&pair) && l.length() > 0.0);
            self.equal += PROGRAMS * u64::from(pair.wi() == pair.wo() && v.length() > 0.0);
        }
    }
}

fn ends(a: f64, b: f64) -> (f64, f64) {
    (a.min(b), a.max(b))
}

fn is_antipodal(pair: &DirectionPair) -> bool {
    (pair.wi().truncate() + pair.wo().truncate()).length() == 0.0
}

/// Values by program, channel and sample, the layout of the evaluators.
fn scalar(programs: &[&Program], set: &SampleSet) -> Vec<f32> {
    let samples = set.len();
    let mut f = vec![0.0; programs.len() * 3 * samples];
    for (program, out) in programs.iter().zip(f.chunks_exact_mut(3 * samples)) {
        Scalar::new(program, set).run(out);
    }
    f
}

fn count(values: &[f32], is_bad: impl Fn(f32) -> bool) -> u64 {
    values.iter().filter(|value| is_bad(**value)).count() as u64
}

/// Number of values whose bits differ, and number of those that are zero or subnormal on both
/// sides.
fn differing(a: &[f32], b: &[f32]) -> (u64, u64) {
    let tiny = |value: f32| value.abs() < f32::MIN_POSITIVE;
    let differing = || a.iter().zip(b).filter(|(a, b)| a.to_bits() != b.to_bits());
    let all = differing().count() + a.len().abs_diff(b.len());
    (all as u64, differing().filter(|(a, b)| tiny(**a) && tiny(**b)).count() as u64)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn batch_finds_no_difference_and_covers_every_hard_case() {
        let found = batch(3, None).unwrap();
        assert_eq!(found.evaluations_per_level, PROGRAMS * SAMPLES as u64);
        assert_eq!(found.evaluations_with_large_constants * 2, found.evaluations_per_level);
        let bad = [found.not_finite, found.negative, found.differing_from_scalar];
        assert_eq!((bad, found.scalar_differing), ([0; 3], 0), "{found:?}");
        assert!(found.grazing > found.evaluations_per_level / 2, "{found:?}");
        assert!(found.at_the_pole.min(found.antipodal).min(found.equal) > 0, "{found:?}");
    }

    #[test]
    fn differing_separates_flushed_subnormals_from_other_bits() {
        assert_eq!(differing(&[0.0, 1e-40, 1.0, -0.0], &[0.0, 0.0, 1.5, 0.0]), (3, 2));
        assert_eq!(differing(&[1.0], &[1.0, 2.0]), (1, 0));
    }
}
