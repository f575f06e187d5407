use brood_genome::{Arithmetic, Genome};
use brood_program::{Operand, Program};
use brood_scene::SampleSet;

use super::*;
use crate::conformance::{hard_samples, programs};
use crate::{CanonicalEvaluator, Evaluator, Loss};

/// Returns a target that a program nearly meets: 1.3 times its own reflectance.
fn target(program: &Program, set: &SampleSet, loss: Loss) -> FitnessTarget {
    let mut f = Vec::new();
    CanonicalEvaluator::default().eval(&[program], set, &mut f).unwrap();
    let f: Vec<f32> = f.iter().map(|f| (1.3 * f).min(1e6)).collect();
    let rows = [0, 1, 2].map(|channel| &f[channel * set.len()..(channel + 1) * set.len()]);
    FitnessTarget::new(set, rows, [&vec![0.7; set.len()]; 3], loss, 1).unwrap()
}

/// Returns the residuals of one sample in f64 for modified constants.
fn residuals(program: &Program, target: &FitnessTarget, sample: usize, c: &[f64]) -> [f64; 3] {
    let mut values: Vec<f64> = Vec::new();
    for step in program.steps() {
        let value = |operand| read(operand, &values, target, sample, c);
        let (a, b) = (value(step.a), value(step.b));
        values.push(step.operation.apply(a, b));
    }
    let squares = program.results().map(|result| read(result, &values, target, sample, c).square());
    let f: [f64; 3] = program.output().apply(squares);
    [0, 1, 2].map(|channel| {
        let weighted = f[channel] * f64::from(target.weights()[channel][sample]);
        let scaled = match target.loss() {
            Loss::Logarithmic => libm::log2(1.0 + weighted),
            Loss::Squared => weighted,
        };
        scaled - f64::from(target.values()[channel][sample])
    })
}

fn read(operand: Operand, values: &[f64], target: &FitnessTarget, sample: usize, c: &[f64]) -> f64 {
    match operand {
        Operand::Step(index) => values[usize::from(index)],
        Operand::Input(input) => f64::from(target.set().input(input)[sample]),
        Operand::Constant(index) => c[usize::from(index)],
    }
}

/// Computes J^T J and J^T r by central differences in f64.
fn by_differences(program: &Program, target: &FitnessTarget) -> NormalEquations {
    let c: Vec<f64> =
        program.constants().iter().map(|constant| f64::from(constant.canonical)).collect();
    let mut equations = NormalEquations::zero(c.len());
    for sample in 0..target.samples() {
        let r = residuals(program, target, sample, &c);
        let columns: Vec<[f64; 3]> = (0..c.len())
            .map(|k| {
                let step = 1e-6 * c[k].abs().max(1e-3);
                let moved = |by: f64| {
                    let mut c = c.clone();
                    c[k] += by;
                    residuals(program, target, sample, &c)
                };
                let (more, less) = (moved(step), moved(-step));
                [0, 1, 2].map(|channel| (more[channel] - less[channel]) / (2.0 * step))
            })
            .collect();
        for channel in 0..3 {
            equations.sum += r[channel] * r[channel];
            for (first, a) in columns.iter().enumerate() {
                equations.gradient[first] += a[channel] * r[channel];
                for (second, b) in columns.iter().enumerate() {
                    equations.matrix[first * c.len() + second] += a[channel] * b[channel];
                }
            }
        }
    }
    equations
}

fn largest(values: &[f64]) -> f64 {
    values.iter().fold(0.0, |largest, value| value.abs().max(largest))
}

fn assert_close(got: &[f64], expected: &[f64], bound: f64, what: &str) {
    let scale = largest(expected).max(1e-9);
    for (k, (got, expected)) in got.iter().zip(expected).enumerate() {
        let error = (got - expected).abs() / scale;
        assert!(error <= bound, "{what} {k}: {got}, expected {expected}, error {error:e}");
    }
}

/// Returns smooth programs that cover every operation, far from clamps.
fn smooth() -> Vec<Program> {
    let head = "brood 1\n.dialect extended smooth registers 10\n.const C0 0.5 -0.25 0.7 0.3\n\
                .const C1 0.2 0.4 -0.6 0.8\n";
    let bodies = [
        "MUL R1, R0, C0\nADD R0, R1, C1",
        "MAD R1, R0, C0, R1\nSIN R2, R1.x\nCOS R3, R1.y\nMAD R0, R2, C1, R3",
        "MUL R1, R0, C0\nEX2 R2, R1.x\nEX2 R3, -R1.y\nLRP R0, R2, R3, C1",
        "ADD R1, R0, C0\nLG2 R2, R1.x\nRCP R3, R1.x\nMAD R0, R2, C1, R3",
        "ADD R1, R0, C0\nRSQ R2, R1.x\nSPL R3, R1.y\nSPL R4, -R1.z\nMAD R0, R2, C1, R3\nADD R0, R0, R4",
        ".matrix 0.5 0.25 0.25 0 2 0 0.125 0 1\n.scale 1 0.5 3\n.offset 0.25 0 1\nMUL R1, R0, C0\nADD R0, R1, C1",
    ];
    let lower = |body: &&str| {
        let genome: Genome = format!("{head}{body}\n").parse().expect("valid text");
        Program::lower(&genome)
    };
    bodies.iter().map(lower).collect()
}

/// Returns 300 ordinary directions, so that the last block is not full.
fn ordinary() -> SampleSet {
    let all = hard_samples(8, 2000);
    let ordinary = |k: &u32| {
        let (pair, uv) = all.pair(*k as usize);
        pair.cos_i() > 0.05 && pair.cos_o() > 0.05 && uv.abs().max_element() < 2.0
    };
    let picked: Vec<u32> = (0..2000).filter(ordinary).take(300).collect();
    assert_eq!(picked.len(), 300, "there are enough ordinary directions");
    all.select(&picked)
}

#[test]
fn derivatives_agree_with_those_in_f64() {
    let set = ordinary();
    for (index, program) in smooth().iter().enumerate() {
        for loss in [Loss::Logarithmic, Loss::Squared] {
            let target = target(program, &set, loss);
            let expected = by_differences(program, &target);
            for direction in [Direction::Forward, Direction::Reverse] {
                let got = normal_equations(program, &target, direction);
                let what = format!("program {index}, {loss:?}, {direction:?}");
                assert_close(&got.matrix, &expected.matrix, 1e-4, &format!("{what}: matrix"));
                assert_close(&got.gradient, &expected.gradient, 1e-4, &format!("{what}: gradient"));
                assert!((got.sum - expected.sum).abs() <= 1e-4 * expected.sum.max(1e-9), "{what}");
            }
        }
    }
}

#[test]
fn forward_and_reverse_agree_on_random_programs() {
    let set = ordinary();
    for (index, program) in programs(6).iter().enumerate() {
        let target = target(program, &set, Loss::Logarithmic);
        let forward = normal_equations(program, &target, Direction::Forward);
        let reverse = normal_equations(program, &target, Direction::Reverse);
        assert_eq!(forward.sum.to_bits(), reverse.sum.to_bits(), "program {index}");
        assert_close(&forward.matrix, &reverse.matrix, 1e-3, &format!("program {index}: matrix"));
    }
}

#[test]
fn equations_have_the_same_bits_when_the_number_of_threads_differs() {
    let set = hard_samples(2, 1500);
    let program = &programs(4)[12];
    let target = target(program, &set, Loss::Logarithmic);
    let on = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| normal_equations(program, &target, Direction::Reverse))
    };
    let (one, four) = (on(1), on(4));
    let bits = |values: &[f64]| values.iter().map(|v| v.to_bits()).collect::<Vec<_>>();
    assert_eq!(bits(&one.matrix), bits(&four.matrix));
    assert_eq!(bits(&one.gradient), bits(&four.gradient));
}

#[test]
fn clamped_value_has_no_derivative() {
    let text = "brood 1\n.dialect paper smooth registers 7\n.const C0 65504 2 1 1\nMUL R1, C0.x, C0.y\n\
                MAD R0, R0, C0.x, R1\nADD R0, R0, C0.x\n";
    let genome: Genome = text.parse().unwrap();
    let program = Program::lower(&genome);
    let set = ordinary();
    let rows = vec![1.0; set.len()];
    let target = FitnessTarget::new(&set, [&rows; 3], [&rows; 3], Loss::Squared, 1).unwrap();
    let equations = normal_equations(&program, &target, Direction::Reverse);
    let p1 = set.input(brood_genome::Input::P1);
    assert!(p1.iter().all(|p1| *p1 >= 0.0), "the sum is clamped everywhere");
    assert_eq!(largest(&equations.gradient), 0.0, "{equations:?}");
}
