//! Random programs, timing and error statistics shared by the benchmarks.

use std::borrow::Borrow;
use std::time::Instant;

use anyhow::{Context, Result};
use brood_eval::{CanonicalEvaluator, Evaluator, Preview};
use brood_genome::{BirthKey, Dialect, Genome, Output, Variation};
use brood_program::Program;
use brood_scene::SampleSet;
use rayon::ThreadPool;

/// Saturation of random programs and models on the page.
pub const SATURATION: f32 = 0.65;

/// Random genomes of the default dialect, drawn like a brood without parents.
pub fn genomes(seed: u64, count: u32) -> Vec<Genome> {
    let random = Variation::random(Dialect::default());
    (0..count).map(|slot| random.birth(BirthKey { seed, slot, attempt: 0 })).collect()
}

/// Endless random genomes with [`SATURATION`], without black ones.
pub fn visible_genomes(seed: u64) -> Result<impl Iterator<Item = Genome>> {
    let random = Variation::random(Dialect::default());
    let random = random.with_output(Some(Output::saturation(SATURATION)?));
    let births = (0..).map(move |slot| random.birth(BirthKey { seed, slot, attempt: 0 }));
    Ok(births.filter(is_visible))
}

/// True if the preview of the genome is not black.
pub fn is_visible(genome: &Genome) -> bool {
    !Preview::of(&Program::lower(genome)).is_black()
}

/// Programs of [`genomes`].
pub fn programs(seed: u64, count: u32) -> Vec<Program> {
    genomes(seed, count).iter().map(Program::lower).collect()
}

/// Thread pool in which parallel loops run on one thread.
pub fn one_thread() -> Result<ThreadPool> {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build();
    pool.context("start a thread pool of one thread")
}

/// Time of the fastest of `repeats` runs in milliseconds, and the result of the last one. The
/// minimum is used because other load on the machine can only add time.
pub fn fastest_ms<T>(repeats: u32, mut run: impl FnMut() -> Result<T>) -> Result<(f64, T)> {
    let (mut least, mut result) = timed_ms(&mut run)?;
    for _ in 1..repeats {
        let (ms, value) = timed_ms(&mut run)?;
        (least, result) = (least.min(ms), value);
    }
    Ok((least, result))
}

/// Fastest run of each closure, in milliseconds. They alternate, so that a slow phase of the
/// machine affects all of them.
pub fn fastest_of_each_ms<const N: usize>(
    repeats: u32,
    mut runs: [&mut dyn FnMut() -> Result<()>; N],
) -> Result<[f64; N]> {
    let mut least = [f64::INFINITY; N];
    for _ in 0..repeats.max(1) {
        for (least, run) in least.iter_mut().zip(&mut runs) {
            *least = least.min(timed_ms(run)?.0);
        }
    }
    Ok(least)
}

/// Seconds of the fastest and of the slowest pass over the programs, evaluated one after another.
pub fn fastest_and_slowest_pass(
    evaluator: &CanonicalEvaluator,
    programs: &[&Program],
    set: &SampleSet,
    passes: u32,
) -> Result<(f64, f64)> {
    let mut out = Vec::new();
    let mut pass = || {
        let evaluate = |program: &&Program| evaluator.eval(&[*program], set, &mut out);
        Ok(programs.iter().try_for_each(evaluate)?)
    };
    // The first pass fills the inputs and is not counted.
    pass()?;
    let (mut fastest, mut slowest) = (f64::INFINITY, 0f64);
    for _ in 0..passes {
        let seconds = timed_ms(&mut pass)?.0 / 1e3;
        (fastest, slowest) = (fastest.min(seconds), slowest.max(seconds));
    }
    Ok((fastest, slowest))
}

fn timed_ms<T>(run: &mut impl FnMut() -> Result<T>) -> Result<(f64, T)> {
    let start = Instant::now();
    let value = run()?;
    Ok((start.elapsed().as_secs_f64() * 1e3, value))
}

/// Value at rank `share` of the sorted values (nearest rank); NaN for no values.
pub fn quantile(values: impl IntoIterator<Item: Borrow<f64>>, share: f64) -> f64 {
    let mut values: Vec<f64> = values.into_iter().map(|value| *value.borrow()).collect();
    values.sort_by(f64::total_cmp);
    let rank = libm::ceil(share * values.len() as f64) as usize;
    values.get(rank.max(1) - 1).copied().unwrap_or(f64::NAN)
}

/// Middle value.
pub fn median(values: impl IntoIterator<Item: Borrow<f64>>) -> f64 {
    quantile(values, 0.5)
}

/// Difference between a picture and a reference.
#[derive(Debug, Clone, Copy)]
pub struct PixelDifference {
    /// Root mean square over all pixels and channels.
    pub rmse: f64,
    /// Absolute difference that one channel in a thousand exceeds.
    pub p999: f64,
    /// Largest absolute difference.
    pub max: f64,
}

/// Difference of two pictures of linear pixels, each clamped to [0, `white`], the range of a
/// display.
///
/// # Panics
/// Panics if the pictures differ in size.
pub fn difference(picture: &[[f64; 3]], reference: &[[f64; 3]], white: f64) -> PixelDifference {
    assert_eq!(picture.len(), reference.len(), "compared pictures must have the same size");
    let clamped = |value: f64| value.clamp(0.0, white);
    let pairs = picture.as_flattened().iter().zip(reference.as_flattened());
    let errors: Vec<f64> = pairs.map(|(a, b)| (clamped(*a) - clamped(*b)).abs()).collect();
    let squares: f64 = errors.iter().map(|d| d * d).sum();
    PixelDifference {
        rmse: (squares / errors.len().max(1) as f64).sqrt(),
        max: errors.iter().copied().fold(0.0, f64::max),
        p999: quantile(&errors, 0.999),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantile_is_taken_by_rank() {
        let values = || (1..=1000).rev().map(f64::from);
        assert_eq!(median(values()), 500.0);
        assert_eq!(quantile(values(), 0.999), 999.0);
        assert_eq!(quantile([7.0], 0.0), 7.0);
        assert!(median([0.0; 0]).is_nan());
    }

    #[test]
    fn difference_ignores_values_above_white() {
        let found = difference(&[[0.5, 3.0, 0.0]], &[[0.25, 9.0, 0.0]], 1.0);
        assert!((found.rmse - 0.25 / 3f64.sqrt()).abs() < 1e-15, "{found:?}");
        assert_eq!((found.max, found.p999), (0.25, 0.25));
        assert_eq!(difference(&[[0.5, 3.0, 0.0]], &[[0.5, 9.0, 0.0]], 10.0).max, 6.0);
    }

    #[test]
    fn fastest_run_counts_and_errors_are_returned() {
        let mut runs = 0;
        let (ms, value) = fastest_ms(3, || {
            runs += 1;
            Ok(runs)
        })
        .unwrap();
        assert!(ms >= 0.0 && value == 3);
        assert!(fastest_ms(2, || anyhow::bail!("no") as Result<()>).is_err());
    }
}
