//! Translation: a program as instructions for blocks, bound to one sample set.
//!
//! Three things happen here: clamps that cannot act on this set are left out, a value that is read once and at once is
//! fused with what reads it, and values get registers by one scan over their lives.

use std::cell::RefCell;

use brood_brdf::{Input, InputMask};
use brood_program::{Operand, Operation, Program, Range, Step, StepRange, find_step_ranges};
use brood_scene::SampleSet;

use super::kernel::{Clamping, Kernel, Pass, Second};
use crate::Level;

/// Slots from here on are inputs and constants, until the registers are counted.
const FIRST_INPUT: u16 = 1 << 15;

/// One pass over a block.
#[derive(Debug, Clone, Copy)]
pub(super) struct Instruction {
    pub(super) pass: Pass,
    /// The register written, which is none of the operands.
    pub(super) dst: u16,
    /// Slots: registers, then inputs, then constants. What the kernel does not read repeats the first.
    pub(super) operands: [u16; 3],
}

/// A program bound to a sample set.
#[derive(Debug)]
pub(crate) struct Code<'a> {
    program: &'a Program,
    pub(super) instructions: Vec<Instruction>,
    /// Slots.
    pub(super) results: [u16; 3],
    pub(super) registers: usize,
    pub(super) inputs: InputMask,
    pub(super) set: &'a SampleSet,
}

thread_local! {
    static TRANSLATION: RefCell<Translation> = RefCell::default();
}

impl<'a> Code<'a> {
    #[inline(always)]
    pub(crate) fn program(&self) -> &'a Program {
        self.program
    }

    pub(crate) fn new(program: &'a Program, set: &'a SampleSet, level: Level) -> Self {
        TRANSLATION.with_borrow_mut(|translation| translation.run(program, set, level))
    }
}

/// What a translation writes to. Used again for the next program: asking for memory takes as long as translating.
#[derive(Default)]
struct Translation {
    ranges: Vec<StepRange>,
    instructions: Vec<Instruction>,
    /// For each step how often it is still to be read.
    reads: Vec<u32>,
    /// Where the result of each step is; [`NOWHERE`] until it has been stored.
    register: Vec<u16>,
    free: Vec<u16>,
    registers: u16,
    inputs: InputMask,
    positions: [u16; Input::ALL.len()],
    read_inputs: u16,
}

/// No register.
const NOWHERE: u16 = u16::MAX;

impl Translation {
    fn run<'a>(&mut self, program: &'a Program, set: &'a SampleSet, level: Level) -> Code<'a> {
        let input_range = |input| {
            let (low, high) = set.input_range(input);
            Range { low, high }
        };
        find_step_ranges(program, input_range, &mut self.ranges);
        self.begin(program);
        let steps = program.steps();
        let mut index = 0;
        while index < steps.len() {
            index += match self.fuse(steps, index, level) {
                true => 2,
                false => {
                    self.single(steps, index, level);
                    1
                }
            };
        }
        let results = program.results().map(|operand| self.place(operand));
        // The registers are counted only now: what comes after them moves up.
        let registers = self.registers;
        let moved =
            |slot: u16| if slot < FIRST_INPUT { slot } else { slot - FIRST_INPUT + registers };
        let instructions = self.instructions.iter().map(|instruction| {
            let [a, b, c] = instruction.operands;
            let dst = instruction.dst;
            assert!((a != dst) & (b != dst) & (c != dst), "a destination is never an operand");
            Instruction { operands: [moved(a), moved(b), moved(c)], ..*instruction }
        });
        Code {
            program,
            instructions: instructions.collect(),
            results: results.map(moved),
            registers: usize::from(registers),
            inputs: self.inputs,
            set,
        }
    }

    fn begin(&mut self, program: &Program) {
        let steps = program.steps();
        self.instructions.clear();
        self.reads.clear();
        self.reads.resize(steps.len(), 0);
        self.register.clear();
        self.register.resize(steps.len(), NOWHERE);
        self.free.clear();
        self.registers = 0;
        self.inputs = InputMask::EMPTY;
        for step in steps {
            self.count(step.a);
            if step.b != step.a {
                self.count(step.b);
            }
        }
        program.results().iter().for_each(|result| self.count(*result));
        self.read_inputs = 0;
        for input in self.inputs.iter() {
            self.positions[input.index()] = self.read_inputs;
            self.read_inputs += 1;
        }
    }

    fn count(&mut self, operand: Operand) {
        match operand {
            Operand::Step(index) => self.reads[usize::from(index)] += 1,
            Operand::Input(input) => self.inputs.insert(input),
            Operand::Constant(_) => {}
        }
    }

    /// Two steps as one instruction, if the second reads the first, once, and nothing else does.
    fn fuse(&mut self, steps: &[Step], index: usize, level: Level) -> bool {
        let (Some(next), true) = (steps.get(index + 1), self.reads[index] == 1) else {
            return false;
        };
        let Some((second, other)) = reads_once(next, index) else { return false };
        let step = steps[index];
        let clamps = [self.ranges[index].clamps, self.ranges[index + 1].clamps];
        let Some(kernel) = Kernel::fused(step.operation, second, clamps) else { return false };
        let pass = kernel.pass(level);
        self.emit(pass, [step.a, step.b, other], index + 1, &steps[index..index + 2]);
        true
    }

    fn single(&mut self, steps: &[Step], index: usize, level: Level) {
        let (step, range) = (&steps[index], self.ranges[index]);
        let Step { operation, a, b } = *step;
        let clamping = match range.clamps || range.clamps_argument {
            true => Clamping::Needed,
            false => Clamping::Idle,
        };
        let pass = Kernel::single(operation, clamping).pass(level);
        self.emit(pass, [a, b, a], index, std::slice::from_ref(step));
    }

    /// Adds an instruction that stands for one or two steps and writes the result of `result`.
    fn emit(&mut self, pass: Pass, read: [Operand; 3], result: usize, steps: &[Step]) {
        let [a, b, c] = read;
        let operands = [self.place(a), self.place(b), self.place(c)];
        // Taken before the operands are released: a loop never writes what it reads.
        let dst = self.free.pop().unwrap_or_else(|| {
            self.registers += 1;
            self.registers - 1
        });
        for step in steps {
            self.release(step.a);
            if step.b != step.a {
                self.release(step.b);
            }
        }
        self.register[result] = dst;
        self.instructions.push(Instruction { pass, dst, operands });
    }

    /// One read less of a value; after the last its register is free.
    fn release(&mut self, operand: Operand) {
        let Operand::Step(index) = operand else { return };
        let index = usize::from(index);
        self.reads[index] -= 1;
        // The first of a pair has no register: its value is never stored.
        let register = self.register[index];
        if self.reads[index] == 0 && register != NOWHERE {
            self.free.push(register);
        }
    }

    /// The slot of an operand, inputs and constants counted from [`FIRST_INPUT`].
    fn place(&self, operand: Operand) -> u16 {
        match operand {
            Operand::Step(index) => {
                let register = self.register[usize::from(index)];
                assert!(register != NOWHERE, "steps read only what was stored before");
                register
            }
            Operand::Input(input) => FIRST_INPUT + self.positions[input.index()],
            Operand::Constant(index) => FIRST_INPUT + self.read_inputs + index,
        }
    }
}

/// How a step goes on from the result of the one before it, and its other operand.
fn reads_once(step: &Step, before: usize) -> Option<(Second, Operand)> {
    let is_it = |operand| matches!(operand, Operand::Step(index) if usize::from(index) == before);
    let (on_the_left, other) = match (is_it(step.a), is_it(step.b)) {
        (true, false) => (true, step.b),
        (false, true) => (false, step.a),
        _ => return None,
    };
    let second = match step.operation {
        Operation::Add => Second::Add,
        Operation::Sub if on_the_left => Second::Sub,
        Operation::Sub => Second::SubFrom,
        Operation::Mul => Second::Mul,
        Operation::Sin | Operation::Cos | Operation::Ex2 | Operation::Ex2Neg => return None,
        Operation::Lg2 | Operation::Rcp | Operation::Rsq => return None,
        Operation::Spl | Operation::SplNeg => return None,
    };
    Some((second, other))
}
