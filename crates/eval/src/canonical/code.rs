//! Translation: a program as instructions for blocks, bound to one sample set.
//!
//! Three things happen here: clamps that cannot act on this set are left out, a value that is read once and at once is
//! fused with what reads it, and values get registers by one scan over their lives.

use brood_brdf::Input;
use brood_program::{Operand, Operation, Program, Range, Step, StepRange, step_ranges};
use brood_scene::SampleSet;

use super::kernel::{Clamping, Kernel, LANES, Pass, Quarter, Second};
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
    pub(super) constants: Vec<Quarter>,
    pub(super) inputs: Vec<&'a [f32]>,
}

impl<'a> Code<'a> {
    #[inline(always)]
    pub(crate) fn program(&self) -> &'a Program {
        self.program
    }

    pub(crate) fn new(program: &'a Program, set: &'a SampleSet, level: Level) -> Self {
        let ranges = step_ranges(program, |input| {
            let (low, high) = set.input_range(input);
            Range { low, high }
        });
        let mut translation = Translation::new(program, level);
        let steps = program.steps();
        let mut index = 0;
        while index < steps.len() {
            index += match translation.fuse(index, &ranges) {
                true => 2,
                false => {
                    translation.single(index, ranges[index]);
                    1
                }
            };
        }
        let results = program.results().map(|operand| translation.place(operand));
        let mut instructions = translation.instructions;
        // The registers are counted only now: what comes after them moves up.
        let registers = translation.registers;
        let moved =
            |slot: u16| if slot < FIRST_INPUT { slot } else { slot - FIRST_INPUT + registers };
        for instruction in &mut instructions {
            let [a, b, c] = instruction.operands;
            assert!(![a, b, c].contains(&instruction.dst), "a destination is never an operand");
            instruction.operands = [moved(a), moved(b), moved(c)];
        }
        let [red, green, blue] = results;
        let constants = program.constants().iter();
        Self {
            program,
            instructions,
            results: [moved(red), moved(green), moved(blue)],
            registers: usize::from(registers),
            constants: constants.map(|constant| Quarter([constant.canonical; LANES])).collect(),
            inputs: program.inputs().iter().map(|input| set.input(input)).collect(),
        }
    }
}

struct Translation<'a> {
    program: &'a Program,
    level: Level,
    instructions: Vec<Instruction>,
    /// For each step how often it is still to be read.
    reads: Vec<u32>,
    /// Where the result of each step is, once it has been stored.
    register: Vec<Option<u16>>,
    free: Vec<u16>,
    registers: u16,
    positions: [u16; Input::ALL.len()],
    read_inputs: u16,
}

impl<'a> Translation<'a> {
    fn new(program: &'a Program, level: Level) -> Self {
        let steps = program.steps();
        let mut reads = vec![0; steps.len()];
        let read =
            steps.iter().flat_map(|step| [Some(step.a), (step.b != step.a).then_some(step.b)]);
        for operand in read.flatten().chain(*program.results()) {
            if let Operand::Step(index) = operand {
                reads[usize::from(index)] += 1;
            }
        }
        let (mut positions, mut read_inputs) = ([0; Input::ALL.len()], 0);
        for input in program.inputs().iter() {
            positions[input.index()] = read_inputs;
            read_inputs += 1;
        }
        Self {
            program,
            level,
            instructions: Vec::with_capacity(steps.len()),
            reads,
            register: vec![None; steps.len()],
            free: Vec::new(),
            registers: 0,
            positions,
            read_inputs,
        }
    }

    /// Two steps as one instruction, if the second reads the first, once, and nothing else does.
    fn fuse(&mut self, index: usize, ranges: &[StepRange]) -> bool {
        let steps = self.program.steps();
        let (Some(next), true) = (steps.get(index + 1), self.reads[index] == 1) else {
            return false;
        };
        let Some((second, other)) = reads_once(next, index) else { return false };
        let step = steps[index];
        let clamps = [ranges[index].clamps, ranges[index + 1].clamps];
        let Some(kernel) = Kernel::fused(step.operation, second, clamps) else { return false };
        self.emit(kernel, [step.a, step.b, other], index + 1, &steps[index..index + 2]);
        true
    }

    fn single(&mut self, index: usize, range: StepRange) {
        let step = &self.program.steps()[index];
        let Step { operation, a, b } = *step;
        let clamping = match range.clamps || range.clamps_argument {
            true => Clamping::Needed,
            false => Clamping::Idle,
        };
        let kernel = Kernel::single(operation, clamping);
        self.emit(kernel, [a, b, a], index, std::slice::from_ref(step));
    }

    /// Adds an instruction that stands for one or two steps and writes the result of `result`.
    fn emit(&mut self, kernel: Kernel, read: [Operand; 3], result: usize, steps: &[Step]) {
        let operands = read.map(|operand| self.place(operand));
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
        self.register[result] = Some(dst);
        let pass = kernel.pass(self.level);
        self.instructions.push(Instruction { pass, dst, operands });
    }

    /// One read less of a value; after the last its register is free.
    fn release(&mut self, operand: Operand) {
        let Operand::Step(index) = operand else { return };
        let index = usize::from(index);
        self.reads[index] -= 1;
        // The first of a pair has no register: its value is never stored.
        if self.reads[index] == 0
            && let Some(register) = self.register[index]
        {
            self.free.push(register);
        }
    }

    /// The slot of an operand, inputs and constants counted from [`FIRST_INPUT`].
    fn place(&self, operand: Operand) -> u16 {
        match operand {
            Operand::Step(index) => {
                let register = self.register[usize::from(index)];
                register.expect("steps read only what was stored before")
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
