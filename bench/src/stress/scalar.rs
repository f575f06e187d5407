//! Scalar evaluator: computes one value at a time with the operations that define every bit.
//!
//! It shares only [`Operation::apply`] with the evaluators under test and uses neither registers
//! nor vectors. It equals `brood_program::execute` with the operands resolved once and each step
//! applied to a few samples in a row, which amortises the choice of the operation; 10^9 evaluations
//! then take minutes. Some of its results are compared with `execute` itself.

use std::hint::black_box;

use brood_genome::Arithmetic;
use brood_program::{Operand, Operation, Program, for_known};
use brood_scene::SampleSet;

/// Number of samples that a step is applied to at once.
const CHUNK: usize = 32;

type Row = [f32; CHUNK];

/// A program with its values in rows: inputs, constants, then one row per step.
pub struct Scalar<'a> {
    program: &'a Program,
    inputs: Vec<&'a [f32]>,
    steps: Vec<(Operation, u32, u32)>,
    results: [u32; 3],
    rows: Vec<Row>,
    first_step: usize,
}

impl<'a> Scalar<'a> {
    /// Resolves every operand to its row.
    pub fn new(program: &'a Program, set: &'a SampleSet) -> Self {
        let read: Vec<_> = program.inputs().iter().collect();
        let first_step = read.len() + program.constants().len();
        let place = |operand: &Operand| {
            let index = match operand {
                Operand::Input(input) => {
                    let position = read.iter().position(|other| other == input);
                    position.expect("the mask contains every input that a step reads")
                }
                Operand::Constant(index) => read.len() + usize::from(*index),
                Operand::Step(index) => first_step + usize::from(*index),
            };
            u32::try_from(index).expect("a program has fewer than 2^32 values")
        };
        let steps = program.steps().iter();
        let steps = steps.map(|step| (step.operation, place(&step.a), place(&step.b))).collect();
        let results = program.results().each_ref().map(place);
        let mut rows = vec![[0.0; CHUNK]; first_step + program.steps().len()];
        for (row, constant) in rows[read.len()..].iter_mut().zip(program.constants()) {
            *row = [constant.canonical; CHUNK];
        }
        let inputs = read.iter().map(|input| set.input(*input)).collect();
        Self { program, inputs, steps, results, rows, first_step }
    }

    /// Computes f of all samples into `f`: red, green, blue, each in sample order.
    pub fn run(&mut self, f: &mut [f32]) {
        let samples = f.len() / 3;
        for start in (0..samples).step_by(CHUNK) {
            let length = CHUNK.min(samples - start);
            for (row, input) in self.rows.iter_mut().zip(&self.inputs) {
                row[..length].copy_from_slice(&input[start..start + length]);
            }
            for (at, (operation, a, b)) in (self.first_step..).zip(&self.steps) {
                let (before, here) = self.rows.split_at_mut(at);
                apply(*operation, &before[*a as usize], &before[*b as usize], &mut here[0]);
            }
            for sample in 0..length {
                let squares = self.results.map(|place| self.rows[place as usize][sample].square());
                let value = self.program.output().apply(squares);
                for (channel, value) in value.into_iter().enumerate() {
                    f[channel * samples + start + sample] = value;
                }
            }
        }
    }
}

/// Applies one step to a few samples; the operation is a constant inside each loop.
fn apply(operation: Operation, a: &Row, b: &Row, out: &mut Row) {
    for_known!(operation, known => each(a, b, out, |a, b| known.apply(a, b)));
}

/// Applies `f` to each value. `black_box` prevents vectorisation, so that the evaluators under test
/// are compared with scalar code.
fn each(a: &Row, b: &Row, out: &mut Row, f: impl Fn(f32, f32) -> f32) {
    for (out, (a, b)) in out.iter_mut().zip(a.iter().zip(b)) {
        *out = f(black_box(*a), *b);
    }
}

#[cfg(test)]
mod tests {
    use brood_eval::conformance::{first_difference, hard_samples, programs};

    use super::*;

    #[test]
    fn scalar_evaluator_equals_the_definition_of_the_steps() {
        for size in [1, CHUNK, 3 * CHUNK + 5] {
            let set = hard_samples(9, size);
            for program in programs(4) {
                let mut f = vec![0.0; 3 * size];
                Scalar::new(&program, &set).run(&mut f);
                assert_eq!(first_difference(&program, &set, &f), None);
            }
        }
    }
}
