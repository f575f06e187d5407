//! Tests of fitness on the available adapter, against the CPU.

use brood_eval::{CanonicalEvaluator, Evaluator, Screening, conformance, select_best};
use brood_genome::{BirthKey, Operator, Stream};

use super::*;
use crate::evaluator::tests::evaluator;
use crate::{GpuOptions, InterpreterLayout};

fn target(len: usize, loss: Loss) -> FitnessTarget {
    let set = conformance::hard_samples(7, len);
    let mut stream =
        Stream::new(BirthKey { seed: 5, slot: 0, attempt: 0 }, Operator::RandomConstants);
    let mut row = || (0..len).map(|_| stream.unit() * 3.0).collect::<Vec<f32>>();
    let rows: Vec<Vec<f32>> = (0..6).map(|_| row()).collect();
    let values = [0, 1, 2].map(|k| rows[k].as_slice());
    let weights = [3, 4, 5].map(|k| rows[k].as_slice());
    FitnessTarget::new(&set, values, weights, loss, 3).unwrap()
}

#[test]
fn sums_have_the_bits_of_the_cpu_with_every_layout() {
    let programs = conformance::programs(1);
    let batch: Vec<&Program> = programs.iter().collect();
    for shape in InterpreterLayout::ALL {
        let options = GpuOptions { shape: Some(shape), ..GpuOptions::default() };
        let Some(gpu) = evaluator(&options) else { return };
        for (len, loss) in [1, 255, 256, 257, 1500]
            .into_iter()
            .flat_map(|len| [(len, Loss::Logarithmic), (len, Loss::Squared)])
        {
            let target = target(len, loss);
            let got = gpu.sums(&batch, &target).unwrap();
            let expected = CanonicalEvaluator::default().sums(&batch, &target).unwrap();
            for (index, (got, expected)) in got.iter().zip(&expected).enumerate() {
                assert!(
                    got.to_bits() == expected.to_bits() || !gpu.is_exact(),
                    "program {index}, {len} samples, {loss:?}, {}: {got}, expected {expected}",
                    shape.name()
                );
            }
        }
    }
}

#[test]
fn sums_are_the_same_when_buffers_are_small() {
    let options = GpuOptions { buffer_bytes: 30_000, ..GpuOptions::default() };
    let Some(gpu) = evaluator(&options) else { return };
    let programs = conformance::programs(1);
    let batch: Vec<&Program> = programs.iter().collect();
    let target = target(5000, Loss::Logarithmic);
    let got = gpu.sums(&batch, &target).unwrap();
    let expected = CanonicalEvaluator::default().sums(&batch, &target).unwrap();
    assert!(!gpu.is_exact() || got == expected);
}

#[test]
fn population_has_the_fitness_of_the_cpu_when_programs_end_early() {
    let Some(gpu) = evaluator(&GpuOptions::default()) else { return };
    if !gpu.is_exact() {
        return;
    }
    let programs = conformance::programs(3);
    let batch: Vec<&Program> = programs.iter().collect();
    let all: Vec<usize> = (0..batch.len()).rev().collect();
    let target = target(3000, Loss::Logarithmic);
    let cpu = CanonicalEvaluator::default();
    let mut sums = cpu.sums(&batch, &target).unwrap();
    sums.sort_by(f64::total_cmp);
    let bound = sums[sums.len() / 3];

    let mut expected = cpu.population(&batch, &target);
    let mut got = GpuPopulation::new(&gpu, &batch, &target);
    for (range, bound) in [(0..1, f64::INFINITY), (1..target.blocks(), bound)] {
        expected.extend(&all, range.clone(), bound).unwrap();
        got.extend(&all, range, bound).unwrap();
        assert_eq!(got.fitness(), expected.fitness());
    }
    let ended = got.fitness().iter().filter(|f| f.blocks < target.blocks()).count();
    assert!(ended > 10, "{ended} programs ended early");
    assert_eq!(got.timing().uploaded_bytes, 0, "inputs and targets were cached on the device");
    assert!(got.timing().read_bytes > 0);
}

#[test]
fn selection_equals_that_of_the_cpu() {
    let Some(gpu) = evaluator(&GpuOptions::default()) else { return };
    if !gpu.is_exact() {
        return;
    }
    let programs = conformance::programs(20);
    let batch: Vec<&Program> = programs.iter().collect();
    let target = target(1100, Loss::Squared);
    for screening in [Screening::None, Screening::Exact, Screening::Race { share: 0.4 }] {
        let got = select_best(&gpu, &batch, &target, 5, screening).unwrap();
        let cpu = CanonicalEvaluator::default();
        assert_eq!(got, select_best(&cpu, &batch, &target, 5, screening).unwrap());
    }
}
