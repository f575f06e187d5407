use brood_genome::Functions;
use brood_program::Program;
use brood_scene::SampleSet;
use proptest::prelude::*;

use super::*;
use crate::conformance::{hard_samples, layered_programs, programs};
use crate::{CanonicalEvaluator, Evaluator, Level};

/// Returns a target that one of the programs meets exactly.
fn target(set: &SampleSet, source: &Program, loss: Loss) -> FitnessTarget {
    let mut f = Vec::new();
    CanonicalEvaluator::default().eval(&[source], set, &mut f).unwrap();
    let f: Vec<f32> = f.iter().map(|f| f.min(1e9)).collect();
    let rows = [0, 1, 2].map(|channel| &f[channel * set.len()..(channel + 1) * set.len()]);
    let weight: Vec<f32> = (0..set.len()).map(|sample| set.pair(sample).0.cos_i() as f32).collect();
    FitnessTarget::new(set, rows, [&weight; 3], loss, 5).unwrap()
}

/// Computes the sum by its definition, sample by sample.
fn plain(program: &Program, target: &FitnessTarget) -> f64 {
    let mut f = Vec::new();
    CanonicalEvaluator::default().eval(&[program], target.set(), &mut f).unwrap();
    let samples = target.samples();
    let error = |sample: usize| {
        let square = |channel: usize| {
            let weighted = f[channel * samples + sample] * target.weights()[channel][sample];
            let scaled = match target.loss() {
                Loss::Logarithmic => Functions::KNOWN.log2(1.0 + weighted),
                Loss::Squared => weighted,
            };
            let d = scaled - target.values()[channel][sample];
            d * d
        };
        (square(0) + square(1)) + square(2)
    };
    let mut total = 0.0;
    for start in (0..samples).step_by(256) {
        let mut sums = [0.0f32; 16];
        for sample in start..samples.min(start + 256) {
            sums[(sample - start) % 16] += error(sample);
        }
        for half in [8, 4, 2, 1] {
            for at in 0..half {
                sums[at] += sums[at + half];
            }
        }
        total += f64::from(sums[0]);
    }
    total
}

#[test]
fn sum_has_the_bits_of_its_definition_at_every_level() {
    let mut programs = programs(6);
    programs.extend(layered_programs());
    let all: Vec<&Program> = programs.iter().collect();
    for size in [1, 63, 64, 255, 256, 257, 1000] {
        let set = hard_samples(3, size);
        for loss in [Loss::Logarithmic, Loss::Squared] {
            let target = target(&set, &programs[9], loss);
            for level in Level::available() {
                let evaluator = CanonicalEvaluator::with_level(level);
                let sums = evaluator.sums(&all, &target).unwrap();
                for (index, (program, sum)) in programs.iter().zip(&sums).enumerate() {
                    let expected = plain(program, &target);
                    assert_eq!(
                        sum.to_bits(),
                        expected.to_bits(),
                        "program {index}, {size} samples, {loss:?}, {}: {sum}, expected {expected}",
                        level.name(),
                    );
                }
            }
        }
    }
}

#[test]
fn program_has_nearly_no_error_when_it_made_the_target() {
    let programs = programs(6);
    let set = hard_samples(4, 700);
    for source in [7, 12, 20] {
        let target = target(&set, &programs[source], Loss::Logarithmic);
        let sums = CanonicalEvaluator::default().sums(&[&programs[source]], &target).unwrap();
        // The value is rounded from f64; the logarithm of the program has a relative error of 2e-7.
        assert!(sums[0] < 700.0 * 3.0 * 1e-10, "{source}: {}", sums[0]);
    }
}

#[test]
fn selection_is_the_same_with_fewer_blocks_when_evaluation_ends_early() {
    let programs = programs(60);
    let all: Vec<&Program> = programs.iter().collect();
    let target = target(&hard_samples(5, 4096), &programs[40], Loss::Logarithmic).hardest_first();
    let evaluator = CanonicalEvaluator::default();
    let select = |screening| select_best(&evaluator, &all, &target, 10, screening).unwrap();
    let (full, exact) = (select(Screening::None), select(Screening::Exact));
    assert_eq!(full.best, exact.best);
    assert_eq!(full.blocks_evaluated, full.blocks);
    assert!(exact.blocks_evaluated < full.blocks * 3 / 4, "{}", exact.blocks_evaluated);
    assert_eq!(full.best[0].program, 40);
    let one_thread = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    assert_eq!(one_thread.install(|| select(Screening::Exact)), exact);
    let race = select(Screening::Race { share: 0.2 });
    assert!(race.blocks_evaluated < exact.blocks_evaluated + full.blocks / 5);
    assert_eq!(race.best[0], full.best[0]);
}

#[test]
fn layers_are_not_evaluated_beyond_the_bound() {
    let programs = layered_programs();
    let all: Vec<&Program> = programs.iter().collect();
    let target = target(&hard_samples(8, 1500), &programs[0], Loss::Squared);
    let mut population = CanonicalPopulation::new(&all, &target, Level::best());
    let every: Vec<usize> = (0..all.len()).collect();
    population.extend(&every, 0..1, f64::INFINITY).unwrap();
    assert_eq!(population.shared_quarters(), 4, "a block has four quarters");
    population.extend(&every[1..2], 1..target.blocks(), -1.0).unwrap();
    assert_eq!(
        population.shared_quarters(),
        8,
        "every program exceeds the bound after one more block"
    );
    population.extend(&every[..1], 1..target.blocks(), f64::INFINITY).unwrap();
    assert_eq!(population.shared_quarters(), 1500_usize.div_ceil(64));
}

#[test]
fn target_is_rejected_when_its_numbers_are_invalid() {
    let set = hard_samples(1, 3);
    let good = [1.0f32, 0.5, 2.0];
    let make = |values: &[f32], weights: &[f32]| {
        let target = FitnessTarget::new(&set, [values; 3], [weights; 3], Loss::Squared, 0);
        target.map(|target| target.samples())
    };
    assert_eq!(make(&good, &good), Ok(3));
    let value = |value| Err(TargetError::Value { sample: 1, value });
    assert_eq!(make(&[1.0, -0.5, 1.0], &good), value(-0.5));
    assert_eq!(make(&[1.0, 1e30, 1.0], &good), value(1e30));
    assert!(make(&[1.0, f32::NAN, 1.0], &good).is_err());
    assert_eq!(make(&good, &[1.0, 1.0, 1e9]), Err(TargetError::Weight { sample: 2, weight: 1e9 }));
    let length = TargetError::Length { what: "weights", found: 2, samples: 3 };
    assert_eq!(make(&good, &good[..2]), Err(length));
    let empty = FitnessTarget::new(&hard_samples(1, 0), [&[]; 3], [&[]; 3], Loss::Squared, 0);
    assert_eq!(empty.err(), Some(TargetError::Empty));
}

#[test]
fn hardest_samples_follow_the_representative_ones() {
    let programs = programs(6);
    let set = hard_samples(7, 5200);
    let shuffled = target(&set, &programs[9], Loss::Logarithmic);
    let ordered = target(&set, &programs[9], Loss::Logarithmic).hardest_first();
    let representative = 2 * 256;
    assert_eq!(ordered.fair_blocks(), 2);
    assert_eq!(ordered.values()[1][..representative], shuffled.values()[1][..representative]);
    let bits = |target: &FitnessTarget| {
        let place = |k: usize| {
            let numbers = [target.values(), target.weights()].map(|rows| rows.map(|row| row[k]));
            (numbers.as_flattened().iter().map(|x| x.to_bits()).collect::<Vec<_>>(), k)
        };
        let mut all: Vec<_> = (0..target.samples()).map(|k| place(k).0).collect();
        all.sort();
        all
    };
    assert_eq!(bits(&ordered), bits(&shuffled), "the same samples");
    // Programs that are not of the pilot have most of their error in the first half of the ordered
    // samples.
    let all: Vec<&Program> = programs.iter().collect();
    let mut population = CanonicalPopulation::new(&all, &ordered, Level::best());
    let every: Vec<usize> = (0..all.len()).collect();
    population.extend(&every, 0..11, f64::INFINITY).unwrap();
    let half: Vec<f64> = population.fitness().iter().map(|fitness| fitness.sum).collect();
    population.extend(&every, 11..ordered.blocks(), f64::INFINITY).unwrap();
    let larger = population.fitness().iter().zip(&half).filter(|(f, half)| **half > 0.5 * f.sum);
    assert!(larger.count() * 4 > all.len() * 3);
}

proptest! {
    #[test]
    fn shuffling_changes_only_the_order(seed: u64, size in 2usize..600) {
        let set = hard_samples(6, size);
        let values: Vec<f32> = (0..size).map(|k| k as f32).collect();
        let target = FitnessTarget::new(&set, [&values; 3], [&vec![1.0; size]; 3], Loss::Squared, seed);
        let target = target.unwrap();
        let mut seen: Vec<usize> = target.values()[0].iter().map(|value| *value as usize).collect();
        for (place, index) in seen.iter().enumerate() {
            prop_assert_eq!(target.set().pair(place).0, set.pair(*index).0);
        }
        seen.sort_unstable();
        prop_assert!(seen.into_iter().eq(0..size));
    }
}
