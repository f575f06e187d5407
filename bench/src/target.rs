//! Fitness targets for the benchmarks: the reflectance of a program on random direction pairs.

use anyhow::{Context, Result};
use brood_brdf::DirectionPair;
use brood_eval::{CanonicalEvaluator, Evaluator, FitnessTarget, Loss};
use brood_genome::{BirthKey, Operator, Stream};
use brood_program::Program;
use brood_scene::SampleSet;
use glam::DVec3;

/// Reflectance of a program on `samples` pairs, with logarithmic loss and equal weights, hardest
/// samples first as in a search.
pub fn of(program: &Program, samples: usize, seed: u64) -> Result<FitnessTarget> {
    Ok(shuffled(program, samples, seed)?.hardest_first())
}

/// The same target with its samples in random order, so that every prefix is representative.
pub fn shuffled(program: &Program, samples: usize, seed: u64) -> Result<FitnessTarget> {
    let set = SampleSet::from_pairs(&random_pairs(seed, samples), &[]);
    let mut f = Vec::new();
    CanonicalEvaluator::default().eval(&[program], &set, &mut f)?;
    let channel = |k: usize| &f[k * samples..(k + 1) * samples];
    let ones = vec![1.0; samples];
    let reflectance = [channel(0), channel(1), channel(2)];
    FitnessTarget::new(&set, reflectance, [&ones, &ones, &ones], Loss::Logarithmic, seed)
        .context("create the target")
}

/// Pairs of independent directions, each uniform over the hemisphere.
pub fn random_pairs(seed: u64, count: usize) -> Vec<DirectionPair> {
    let key = BirthKey { seed, slot: 0, attempt: 0 };
    let mut stream = Stream::new(key, Operator::RandomConstants);
    let mut direction = || loop {
        let mut component = || f64::from(2.0 * stream.unit() - 1.0);
        let w = DVec3::new(component(), component(), component().abs());
        if (0.01..=1.0).contains(&w.length_squared()) {
            return w.normalize();
        }
    };
    let mut pair = || DirectionPair::new(direction(), direction()).expect("directions are unit");
    (0..count).map(|_| pair()).collect()
}
