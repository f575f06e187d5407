//! Translation of a program to instructions that run on whole blocks, for one sample set.
//!
//! Translation leaves out clamps that cannot act on this set, fuses pairs of steps into one
//! instruction, and assigns registers by linear scan.
//!
//! Within a translation, every value has a number: inputs, then constants, then steps. A stored
//! value also has a slot: the index of the view that instructions read it through.

use std::cell::RefCell;

use brood_brdf::{Input, InputMask, Level};
use brood_program::{Binary, Operand, Operation, Program, Range, StepRange};
use brood_scene::SampleSet;

use super::kernel::{Clamping, Kernel, Pass, Second};
use crate::layer::Layers;

/// First slot of inputs and constants during a translation, when the number of registers is not
/// known yet.
const FIRST_INPUT: u16 = 1 << 15;

/// One pass over a block: one step, or a fused pair.
#[derive(Debug, Clone, Copy)]
pub(super) struct Instruction {
    /// Loop over the block.
    pub(super) pass: Pass,
    /// Register written, which is none of the operands.
    pub(super) dst: u16,
    /// Slots of the operands; registers come first, then inputs, then constants. Operands that the
    /// kernel does not read repeat the first.
    pub(super) operands: [u16; 3],
}

/// A program translated for a sample set.
#[derive(Debug)]
pub(crate) struct Code<'a> {
    program: &'a Program,
    pub(super) instructions: Vec<Instruction>,
    /// Slots of the results.
    pub(super) results: [u16; 3],
    /// Number of registers.
    pub(super) registers: usize,
    /// Inputs that the steps or results read.
    pub(super) inputs: InputMask,
    pub(super) set: &'a SampleSet,
    /// Layers, which are evaluated by `layer.rs`.
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

    /// Returns the layers, which are evaluated separately.
    pub(crate) fn layers(&self) -> Option<&Layers> {
        self.layers.as_ref()
    }

    /// Translates a program for the samples of a set and an instruction set.
    pub(crate) fn new(program: &'a Program, set: &'a SampleSet, level: Level) -> Self {
        let layers = Layers::of(program);
        // Not inside the borrow: computing an input is a parallel loop, and while this thread waits
        // for it rayon may run another task on it that translates.
        let inputs = program.inputs();
        inputs.iter().for_each(|input| _ = set.input(input));
        let code = TRANSLATION
            .with_borrow_mut(|translation| translation.run((program, inputs), set, level));
        Self { layers, ..code }
    }
}

/// Buffers of a translation, reused for the next program because allocating them takes as long as
/// translating.
///
/// The tables are indexed by the number of a value. Reading an operand therefore needs no branch on
/// the kind of the value; such a branch would be unpredictable.
#[derive(Default)]
struct Translation {
    instructions: Vec<Instruction>,
    /// Operation of each step and the numbers of its operands.
    steps: Vec<(Operation, [u32; 2])>,
    /// Range of each value on the sample set.
    ranges: Vec<Range>,
    /// For each step, whether the clamp of its result can act, and that of its argument.
    clamps: Vec<[bool; 2]>,
    /// Number of remaining reads of each value, by steps and as results; [`PINNED`] is added for
    /// inputs and constants.
    reads: Vec<u32>,
    /// Slot of each value, inputs and constants counted from [`FIRST_INPUT`]; [`NO_SLOT`] until it
    /// has been stored.
    slots: Vec<u16>,
    /// Number of the first step.
    first_step: u32,
    /// Registers that hold no value that is still read.
    free: Vec<u16>,
    /// Number of registers assigned so far.
    registers: u16,
}

/// Slot of a value that is not stored yet.
const NO_SLOT: u16 = u16::MAX;
/// More reads than any value can have: the slot of such a value is never freed.
const PINNED: u32 = 1 << 30;
/// Number of the first constant.
const FIRST_CONSTANT: usize = Input::ALL.len();

impl Translation {
    /// Translates a program, which reads these inputs, without its layers.
    fn run<'a>(
        &mut self,
        (program, inputs): (&'a Program, InputMask),
        set: &'a SampleSet,
        level: Level,
    ) -> Code<'a> {
        self.begin(program, inputs);
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
        // The number of registers is known only now: the slots after them are moved up.
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

    /// Counts the reads of each value, and assigns slots to inputs and constants.
    fn begin(&mut self, program: &Program, inputs: InputMask) {
        let (constants, count) = (program.constants().len(), program.steps().len());
        let first_step = FIRST_CONSTANT + constants;
        self.first_step = u32::try_from(first_step).expect("constants are numbered in 16 bits");
        self.instructions.clear();
        self.free.clear();
        self.registers = 0;
        self.reads.clear();
        self.reads.resize(first_step, PINNED);
        self.reads.resize(first_step + count, 0);
        self.steps.clear();
        for step in program.steps() {
            let [a, b] = [number(step.a, self.first_step), number(step.b, self.first_step)];
            self.reads[a as usize] += 1;
            // A step that reads a value twice counts once, because it also releases it once.
            self.reads[b as usize] += u32::from(a != b);
            self.steps.push((step.operation, [a, b]));
        }
        for result in program.results() {
            self.reads[number(*result, self.first_step) as usize] += 1;
        }
        self.slots.clear();
        self.slots.resize(first_step + count, NO_SLOT);
        let mut slot = FIRST_INPUT;
        for input in inputs.iter() {
            self.slots[input.index()] = slot;
            slot += 1;
        }
        for (constant, slot) in self.slots[FIRST_CONSTANT..][..constants].iter_mut().zip(slot..) {
            *constant = slot;
        }
    }

    /// Finds the range of every value by interval arithmetic, and the clamps that can act.
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

    /// Emits two steps as one instruction if both are sums, differences or products, and the only
    /// read of the first value is one operand of the second step.
    fn fuse(&mut self, index: usize, level: Level) -> bool {
        let value = self.first_step as usize + index;
        let (Some((next, [left, right])), 1) = (self.steps.get(index + 1), self.reads[value])
        else {
            return false;
        };
        let is_first = |number: u32| number as usize == value;
        let (is_left, is_right) = (is_first(*left), is_first(*right));
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
        // The value of the first step needs no register: it is never stored.
        self.release(other);
        self.slots[value + 1] = dst;
        true
    }

    /// Emits one step as an instruction.
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
        // Allocated before the operands are released: a loop never writes a row that it reads.
        let dst = self.free.pop().unwrap_or_else(|| {
            self.registers += 1;
            self.registers - 1
        });
        self.instructions.push(Instruction { pass, dst, operands });
        dst
    }

    /// Counts one read of a value; after the last one its register is free.
    #[inline(always)]
    fn release(&mut self, number: u32) {
        let reads = &mut self.reads[number as usize];
        *reads -= 1;
        if *reads == 0 {
            self.free.push(self.slots[number as usize]);
        }
    }

    /// Returns the slot of a value by its number.
    #[inline(always)]
    fn slot(&self, number: u32) -> u16 {
        let slot = self.slots[number as usize];
        assert!(slot != NO_SLOT, "a step reads only values that were stored before");
        slot
    }
}

/// Returns the number of a value, given the number of the first step.
#[inline(always)]
fn number(operand: Operand, first_step: u32) -> u32 {
    let (first, index) = match operand {
        Operand::Input(input) => (0, input as u32),
        Operand::Constant(index) => (FIRST_CONSTANT as u32, u32::from(index)),
        Operand::Step(index) => (first_step, u32::from(index)),
    };
    first + index
}

/// Returns the operation as the second of a fused pair, or `None` if it cannot be fused. `is_left`
/// is true if its left operand is the value of the first.
fn second(operation: Operation, is_left: bool) -> Option<Second> {
    Some(match operation.binary()? {
        Binary::Add => Second::Add,
        Binary::Sub if is_left => Second::Sub,
        Binary::Sub => Second::SubFrom,
        Binary::Mul => Second::Mul,
    })
}
