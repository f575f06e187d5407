//! Targets for measuring fitness: the reflectance of a program on random pairs of directions.

use anyhow::{Context, Result};
use brood_brdf::DirectionPair;
use brood_eval::{CanonicalEvaluator, Evaluator, FitnessTarget, Loss};
use brood_genome::{BirthKey, Operator, Stream};
use brood_program::Program;
use brood_scene::SampleSet;
use glam::DVec3;

/// What a program reflects on that many pairs, under the logarithmic loss, every sample counting the same; the hardest
/// samples first, as a search has them.
pub fn of(wanted: &Program, samples: usize, seed: u64) -> Result<FitnessTarget> {
    Ok(shuffled(wanted, samples, seed)?.hardest_first())
}

/// The same in a random order, in which every prefix is a fair part.
pub fn shuffled(wanted: &Program, samples: usize, seed: u64) -> Result<FitnessTarget> {
    let set = SampleSet::from_pairs(&random_pairs(seed, samples), &[]);
    let mut f = Vec::new();
    CanonicalEvaluator::default().eval(&[wanted], &set, &mut f)?;
    let channel = |k: usize| &f[k * samples..(k + 1) * samples];
    let ones = vec![1.0; samples];
    let reflectance = [channel(0), channel(1), channel(2)];
    FitnessTarget::new(&set, reflectance, [&ones, &ones, &ones], Loss::Logarithmic, seed)
        .context("make a target")
}

/// Pairs of directions, each uniform over the hemisphere and independent of the other.
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
