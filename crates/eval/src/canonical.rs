//! The canonical evaluator: f32 over blocks of samples, one operation at a time over a whole block.
//!
//! The loops are plain code that the compiler vectorises; every lane does exactly what
//! [`brood_program::execute`] does for one sample, so results do not depend on block borders, threads or the width of
//! the machine's vectors.

use brood_genome::{Arithmetic, Output};
use brood_program::{Operation, Program, Tape, TapeOperand};
use brood_scene::SampleSet;
use rayon::prelude::*;

use crate::{EvalError, Evaluator, Level};

/// Samples in a block: long enough that decoding costs little, short enough that registers stay in the nearest cache.
const BLOCK: usize = 256;
/// Samples that one task takes.
const TASK: usize = 16 * BLOCK;

/// Plain f32 on the CPU: the bits that all exact evaluators share.
#[derive(Debug, Clone, Copy)]
pub struct CanonicalEvaluator {
    level: Level,
}

impl Default for CanonicalEvaluator {
    fn default() -> Self {
        Self::with_level(Level::best())
    }
}

impl CanonicalEvaluator {
    /// Uses one instruction set; [`Level::best`] by default. All give the same bits.
    #[must_use]
    pub fn with_level(level: Level) -> Self {
        Self { level }
    }

    /// The instruction set in use.
    #[must_use]
    pub fn level(&self) -> Level {
        self.level
    }
}

impl Evaluator for CanonicalEvaluator {
    fn name(&self) -> &str {
        "cpu"
    }

    fn is_exact(&self) -> bool {
        true
    }

    fn eval(
        &self,
        programs: &[&Program],
        set: &SampleSet,
        out: &mut Vec<f32>,
    ) -> Result<(), EvalError> {
        let samples = set.len();
        out.clear();
        out.resize(programs.len() * 3 * samples, 0.0);
        if samples == 0 {
            return Ok(());
        }
        programs.par_iter().zip(out.par_chunks_mut(3 * samples)).for_each(|(program, out)| {
            let code = Code::new(program, set);
            let (red, rest) = out.split_at_mut(samples);
            let (green, blue) = rest.split_at_mut(samples);
            let tasks = red.par_chunks_mut(TASK).zip(green.par_chunks_mut(TASK));
            let tasks = tasks.zip(blue.par_chunks_mut(TASK));
            tasks.enumerate().for_each(|(task, ((red, green), blue))| {
                code.run(self.level, task * TASK, [red, green, blue]);
            });
        });
        Ok(())
    }
}

/// Where a value of a block is.
#[derive(Clone, Copy)]
enum Place {
    /// A row of the workspace.
    Row(usize),
    /// The same value in every lane.
    Value(f32),
}

struct Instruction {
    operation: Operation,
    dst: usize,
    a: Place,
    b: Place,
}

/// A program bound to a sample set: rows of the workspace are the tape's registers, then the inputs it reads.
pub(crate) struct Code<'a> {
    program: &'a Program,
    instructions: Vec<Instruction>,
    results: [Place; 3],
    first_input_row: usize,
    inputs: Vec<&'a [f32]>,
}

impl<'a> Code<'a> {
    fn new(program: &'a Program, set: &'a SampleSet) -> Self {
        let tape = Tape::new(program);
        let first_input_row = usize::from(tape.registers());
        let read: Vec<_> = program.inputs().iter().collect();
        let place = |operand: TapeOperand| match operand {
            TapeOperand::Register(register) => Place::Row(usize::from(register)),
            TapeOperand::Constant(index) => {
                Place::Value(tape.constants()[usize::from(index)].canonical)
            }
            TapeOperand::Input(input) => {
                let position = read.iter().position(|other| *other == input);
                Place::Row(first_input_row + position.expect("the mask names every input read"))
            }
        };
        let instructions = tape.steps().iter().map(|step| Instruction {
            operation: step.operation,
            dst: usize::from(step.dst),
            a: place(step.a),
            b: place(step.b),
        });
        Self {
            program,
            instructions: instructions.collect(),
            results: tape.results().map(place),
            first_input_row,
            inputs: read.iter().map(|input| set.input(*input)).collect(),
        }
    }

    fn run(&self, level: Level, start: usize, mut out: [&mut [f32]; 3]) {
        let mut workspace = Workspace::new(self.first_input_row + self.inputs.len());
        let samples = out[0].len();
        for offset in (0..samples).step_by(BLOCK) {
            let length = BLOCK.min(samples - offset);
            for (index, input) in self.inputs.iter().enumerate() {
                let values = &input[start + offset..start + offset + length];
                workspace.rows[self.first_input_row + index][..length].copy_from_slice(values);
            }
            level.run(self, &mut workspace);
            for (out, values) in out.iter_mut().zip(&workspace.out) {
                out[offset..offset + length].copy_from_slice(&values[..length]);
            }
        }
    }

    /// One block, from the inputs in the workspace to the reflectance in it. Inlined into a function of each level.
    #[inline(always)]
    pub(crate) fn block(&self, workspace: &mut Workspace) {
        for instruction in &self.instructions {
            instruction.run(workspace);
        }
        let squares = self.results.map(|place| workspace.values(place).map(f32::square));
        let output = self.program.output();
        if *output == Output::IDENTITY {
            // Multiplying by 1 and adding 0 to what is not negative changes no bit.
            workspace.out = squares;
            return;
        }
        let [r, g, b] = &squares;
        for (channel, out) in workspace.out.iter_mut().enumerate() {
            for lane in 0..BLOCK {
                out[lane] = output.channel(channel, [r[lane], g[lane], b[lane]]);
            }
        }
    }
}

type Row = Box<[f32; BLOCK]>;

/// The values of one block. Results are written to the spare row, which then changes places with the destination: so
/// no loop reads what it writes, and a destination may be the register of an operand.
pub(crate) struct Workspace {
    rows: Vec<Row>,
    spare: Row,
    out: [[f32; BLOCK]; 3],
}

impl Workspace {
    fn new(rows: usize) -> Self {
        let row = || Box::new([0.0; BLOCK]);
        Self { rows: (0..rows).map(|_| row()).collect(), spare: row(), out: [[0.0; BLOCK]; 3] }
    }

    #[inline(always)]
    fn values(&self, place: Place) -> [f32; BLOCK] {
        match place {
            Place::Row(row) => *self.rows[row],
            Place::Value(value) => [value; BLOCK],
        }
    }
}

impl Instruction {
    #[inline(always)]
    fn run(&self, workspace: &mut Workspace) {
        match self.operation {
            Operation::Add => self.binary(workspace, |a, b| Operation::Add.apply(a, b)),
            Operation::Sub => self.binary(workspace, |a, b| Operation::Sub.apply(a, b)),
            Operation::Mul => self.binary(workspace, |a, b| Operation::Mul.apply(a, b)),
            Operation::Sin => self.unary(workspace, |a| Operation::Sin.apply(a, a)),
            Operation::Cos => self.unary(workspace, |a| Operation::Cos.apply(a, a)),
            Operation::Ex2 => self.unary(workspace, |a| Operation::Ex2.apply(a, a)),
            Operation::Ex2Neg => self.unary(workspace, |a| Operation::Ex2Neg.apply(a, a)),
            Operation::Lg2 => self.unary(workspace, |a| Operation::Lg2.apply(a, a)),
            Operation::Rcp => self.unary(workspace, |a| Operation::Rcp.apply(a, a)),
            Operation::Rsq => self.unary(workspace, |a| Operation::Rsq.apply(a, a)),
            Operation::Spl => self.unary(workspace, |a| Operation::Spl.apply(a, a)),
            Operation::SplNeg => self.unary(workspace, |a| Operation::SplNeg.apply(a, a)),
        }
    }

    #[inline(always)]
    fn binary(&self, workspace: &mut Workspace, f: impl Fn(f32, f32) -> f32) {
        let Workspace { rows, spare, .. } = workspace;
        match (self.a, self.b) {
            (Place::Row(a), Place::Row(b)) => each_pair(spare, &rows[a], &rows[b], f),
            (Place::Row(a), Place::Value(b)) => each(spare, &rows[a], |a| f(a, b)),
            (Place::Value(a), Place::Row(b)) => each(spare, &rows[b], |b| f(a, b)),
            (Place::Value(a), Place::Value(b)) => **spare = [f(a, b); BLOCK],
        }
        std::mem::swap(&mut rows[self.dst], spare);
    }

    #[inline(always)]
    fn unary(&self, workspace: &mut Workspace, f: impl Fn(f32) -> f32) {
        let Workspace { rows, spare, .. } = workspace;
        match self.a {
            Place::Row(a) => each(spare, &rows[a], f),
            Place::Value(a) => **spare = [f(a); BLOCK],
        }
        std::mem::swap(&mut rows[self.dst], spare);
    }
}

// The two loops below take plain arrays, so that the compiler sees that nothing overlaps.

#[inline(always)]
fn each(out: &mut [f32; BLOCK], values: &[f32; BLOCK], f: impl Fn(f32) -> f32) {
    for (out, value) in out.iter_mut().zip(values) {
        *out = f(*value);
    }
}

#[inline(always)]
fn each_pair(
    out: &mut [f32; BLOCK],
    a: &[f32; BLOCK],
    b: &[f32; BLOCK],
    f: impl Fn(f32, f32) -> f32,
) {
    for ((out, a), b) in out.iter_mut().zip(a).zip(b) {
        *out = f(*a, *b);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn canonical_evaluator_passes_the_conformance_suite_at_every_level() {
        for level in Level::available() {
            println!("{}", level.name());
            crate::conformance::check(&CanonicalEvaluator::with_level(level));
        }
    }
}
