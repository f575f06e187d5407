//! Translation: a program as instructions for blocks, bound to one sample set.
//!
//! Three things happen here: clamps that cannot act on this set are left out, a value that is read once and at once is
//! fused with what reads it, and values get registers by one scan over their lives.

use std::cell::RefCell;

use brood_brdf::{Input, InputMask};
use brood_program::{Operand, Operation, Program, Range, StepRange};
use brood_scene::SampleSet;

use super::kernel::{Clamping, Kernel, Pass, Second};
use crate::Level;
use crate::layer::Layers;

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
    layers: Option<Layers>,
}

thread_local! {
    static TRANSLATION: RefCell<Translation> = RefCell::default();
}

impl<'a> Code<'a> {
    #[inline(always)]
    pub(crate) fn program(&self) -> &'a Program {
        self.program
    }

    /// The layers, which are evaluated apart.
    pub(crate) fn layers(&self) -> Option<&Layers> {
        self.layers.as_ref()
    }

    pub(crate) fn new(program: &'a Program, set: &'a SampleSet, level: Level) -> Self {
        let layers = Layers::of(program);
        let code = TRANSLATION.with_borrow_mut(|translation| translation.run(program, set, level));
        Self { layers, ..code }
    }
}

/// What a translation writes to. Used again for the next program: asking for memory takes as long as translating.
///
/// Values stand in tables by their number: inputs, constants, steps. So nothing depends on what kind of operand is read,
/// which no processor could foretell.
#[derive(Default)]
struct Translation {
    instructions: Vec<Instruction>,
    /// For each step its operation and the numbers of its operands.
    steps: Vec<(Operation, [u32; 2])>,
    ranges: Vec<Range>,
    /// For each step which clamps can act: of the result, of the argument.
    clamps: Vec<[bool; 2]>,
    /// For each value how often it is still to be read; [`KEPT`] and more for inputs and constants.
    reads: Vec<u32>,
    /// For each value its slot, inputs and constants counted from [`FIRST_INPUT`]; [`NOWHERE`] until it has been stored.
    slots: Vec<u16>,
    /// Number of the first step.
    first_step: u32,
    free: Vec<u16>,
    registers: u16,
}

/// No slot.
const NOWHERE: u16 = u16::MAX;
/// More often than anything is read: what has as many reads left is never let go.
const KEPT: u32 = 1 << 30;
/// Number of the first constant.
const FIRST_CONSTANT: usize = Input::ALL.len();

impl Translation {
    fn run<'a>(&mut self, program: &'a Program, set: &'a SampleSet, level: Level) -> Code<'a> {
        let inputs = self.begin(program);
        self.find_ranges(program, set, inputs);
        let mut index = 0;
        while index < self.steps.len() {
            index += match self.fuse(index, level) {
                true => 2,
                false => {
                    self.single(index, level);
                    1
                }
            };
        }
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
        let [red, green, blue] = *program.results();
        let result = |operand| moved(self.slot(number(operand, self.first_step)));
        Code {
            program,
            instructions: instructions.collect(),
            results: [result(red), result(green), result(blue)],
            registers: usize::from(registers),
            inputs,
            set,
            layers: None,
        }
    }

    /// Counts who reads what, gives inputs and constants their slots, and returns the inputs that are read.
    fn begin(&mut self, program: &Program) -> InputMask {
        let (constants, count) = (program.constants().len(), program.steps().len());
        let first_step = FIRST_CONSTANT + constants;
        self.first_step = u32::try_from(first_step).expect("constants are numbered in 16 bits");
        self.instructions.clear();
        self.free.clear();
        self.registers = 0;
        self.reads.clear();
        self.reads.resize(first_step, KEPT);
        self.reads.resize(first_step + count, 0);
        self.steps.clear();
        for step in program.steps() {
            let [a, b] = [number(step.a, self.first_step), number(step.b, self.first_step)];
            self.reads[a as usize] += 1;
            self.reads[b as usize] += u32::from(a != b);
            self.steps.push((step.operation, [a, b]));
        }
        for result in program.results() {
            self.reads[number(*result, self.first_step) as usize] += 1;
        }
        self.slots.clear();
        self.slots.resize(first_step + count, NOWHERE);
        let (mut inputs, mut slot) = (InputMask::EMPTY, FIRST_INPUT);
        for input in Input::ALL {
            if self.reads[input.index()] != KEPT {
                inputs.insert(input);
                self.slots[input.index()] = slot;
                slot += 1;
            }
        }
        for (constant, slot) in self.slots[FIRST_CONSTANT..][..constants].iter_mut().zip(slot..) {
            *constant = slot;
        }
        inputs
    }

    fn find_ranges(&mut self, program: &Program, set: &SampleSet, inputs: InputMask) {
        self.ranges.clear();
        self.ranges.resize(FIRST_CONSTANT, Range::ALL);
        for input in inputs.iter() {
            let (low, high) = set.input_range(input);
            self.ranges[input.index()] = Range { low, high };
        }
        let constants = program.constants().iter();
        self.ranges.extend(constants.map(|constant| Range::point(constant.canonical)));
        self.clamps.clear();
        for (operation, [a, b]) in &self.steps {
            let (first, second) = (self.ranges[*a as usize], self.ranges[*b as usize]);
            let range = StepRange::of(*operation, first, second, a == b);
            self.ranges.push(range.result);
            self.clamps.push([range.clamps, range.clamps_argument]);
        }
    }

    /// Two steps as one instruction, if the second reads the first, once, and nothing else does.
    fn fuse(&mut self, index: usize, level: Level) -> bool {
        let value = self.first_step as usize + index;
        let (Some((next, [left, right])), 1) = (self.steps.get(index + 1), self.reads[value])
        else {
            return false;
        };
        let is_it = |number: u32| number as usize == value;
        let (is_left, is_right) = (is_it(*left), is_it(*right));
        if is_left == is_right {
            return false;
        }
        let Some(second) = second(*next, is_left) else { return false };
        let (operation, [a, b]) = self.steps[index];
        let clamps = [self.clamps[index][0], self.clamps[index + 1][0]];
        let Some(kernel) = Kernel::fused(operation, second, clamps) else { return false };
        let other = if is_left { *right } else { *left };
        let dst = self.emit(kernel.pass(level), [a, b, other]);
        self.release(a);
        if b != a {
            self.release(b);
        }
        // The first of the pair has no register: its value is never stored.
        self.release(other);
        self.slots[value + 1] = dst;
        true
    }

    fn single(&mut self, index: usize, level: Level) {
        let (operation, [a, b]) = self.steps[index];
        let clamping = match self.clamps[index] {
            [false, false] => Clamping::Idle,
            _ => Clamping::Needed,
        };
        let dst = self.emit(Kernel::single(operation, clamping).pass(level), [a, b, a]);
        self.release(a);
        if b != a {
            self.release(b);
        }
        self.slots[self.first_step as usize + index] = dst;
    }

    /// Adds an instruction and returns the register that it writes.
    fn emit(&mut self, pass: Pass, [a, b, c]: [u32; 3]) -> u16 {
        let operands = [self.slot(a), self.slot(b), self.slot(c)];
        // Taken before the operands are released: a loop never writes what it reads.
        let dst = self.free.pop().unwrap_or_else(|| {
            self.registers += 1;
            self.registers - 1
        });
        self.instructions.push(Instruction { pass, dst, operands });
        dst
    }

    /// One read less of a value; after the last its register is free.
    #[inline(always)]
    fn release(&mut self, number: u32) {
        let reads = &mut self.reads[number as usize];
        *reads -= 1;
        if *reads == 0 {
            self.free.push(self.slots[number as usize]);
        }
    }

    #[inline(always)]
    fn slot(&self, number: u32) -> u16 {
        let slot = self.slots[number as usize];
        assert!(slot != NOWHERE, "steps read only what was stored before");
        slot
    }
}

/// The number of a value where steps are counted from this one.
#[inline(always)]
fn number(operand: Operand, first_step: u32) -> u32 {
    let (first, index) = match operand {
        Operand::Input(input) => (0, input as u32),
        Operand::Constant(index) => (FIRST_CONSTANT as u32, u32::from(index)),
        Operand::Step(index) => (first_step, u32::from(index)),
    };
    first + index
}

/// How an operation goes on from a value that is its left operand, or its right.
fn second(operation: Operation, is_left: bool) -> Option<Second> {
    match operation {
        Operation::Add => Some(Second::Add),
        Operation::Sub if is_left => Some(Second::Sub),
        Operation::Sub => Some(Second::SubFrom),
        Operation::Mul => Some(Second::Mul),
        Operation::Sin | Operation::Cos | Operation::Ex2 | Operation::Ex2Neg => None,
        Operation::Lg2 | Operation::Rcp | Operation::Rsq => None,
        Operation::Spl | Operation::SplNeg => None,
    }
}
