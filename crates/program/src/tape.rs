//! The tape: a program with registers assigned, as the interpreters run it.

use brood_genome::Input;

use crate::{Constant, Operand, Operation, Program};

/// Source of a value that a step of a tape reads.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum TapeOperand {
    /// A register written by an earlier step.
    Register(u16),
    /// An input of the sample.
    Input(Input),
    /// A constant of the tape.
    Constant(u16),
}

/// One operation, its operands and the register it writes.
///
/// The destination may be the register of an operand: both operands are read before it is written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct TapeStep {
    /// Operation of the step.
    pub operation: Operation,
    /// Register written.
    pub dst: u16,
    /// First operand.
    pub a: TapeOperand,
    /// Second operand; repeats the first for a unary operation.
    pub b: TapeOperand,
}

/// A register-allocated program.
///
/// # Invariants
/// Registers are read only after they were written, and `registers` is one more than the highest
/// one used.
#[derive(Debug, Clone, PartialEq)]
pub struct Tape {
    steps: Vec<TapeStep>,
    constants: Vec<Constant>,
    results: [TapeOperand; 3],
    registers: u16,
}

impl Tape {
    /// Allocates registers by linear scan: each register is free again after its last use.
    #[must_use]
    pub fn new(program: &Program) -> Self {
        let last = last_uses(program);
        let mut allocation =
            Allocation { register: vec![0; program.steps().len()], free: Vec::new(), next: 0 };
        let mut steps = Vec::with_capacity(program.steps().len());
        for (index, step) in program.steps().iter().enumerate() {
            let (a, b) = (allocation.operand(step.a), allocation.operand(step.b));
            allocation.release(step.a, index, &last);
            if step.b != step.a {
                allocation.release(step.b, index, &last);
            }
            let dst = allocation.take();
            allocation.register[index] = dst;
            steps.push(TapeStep { operation: step.operation, dst, a, b });
        }
        let results = program.results().map(|operand| allocation.operand(operand));
        let constants = program.constants().to_vec();
        Self { steps, constants, results, registers: allocation.next }
    }

    /// Returns the steps in order.
    #[must_use]
    pub fn steps(&self) -> &[TapeStep] {
        &self.steps
    }

    /// Returns the constants that operands refer to.
    #[must_use]
    pub fn constants(&self) -> &[Constant] {
        &self.constants
    }

    /// Returns the operands that hold g of red, green and blue after the last step, up to sign.
    #[must_use]
    pub fn results(&self) -> &[TapeOperand; 3] {
        &self.results
    }

    /// Returns the number of registers.
    #[must_use]
    pub fn registers(&self) -> u16 {
        self.registers
    }
}

/// Returns for each step the index of the last step that reads it; `usize::MAX` for results.
fn last_uses(program: &Program) -> Vec<usize> {
    let mut last = vec![0; program.steps().len()];
    for (index, step) in program.steps().iter().enumerate() {
        for operand in [step.a, step.b] {
            if let Operand::Step(read) = operand {
                last[usize::from(read)] = index;
            }
        }
    }
    for operand in program.results() {
        if let Operand::Step(read) = operand {
            last[usize::from(*read)] = usize::MAX;
        }
    }
    last
}

/// State of the linear scan.
struct Allocation {
    /// Register of each step so far.
    register: Vec<u16>,
    /// Registers whose value is not read any more.
    free: Vec<u16>,
    /// Number of registers used.
    next: u16,
}

impl Allocation {
    fn operand(&self, operand: Operand) -> TapeOperand {
        match operand {
            Operand::Step(index) => TapeOperand::Register(self.register[usize::from(index)]),
            Operand::Input(input) => TapeOperand::Input(input),
            Operand::Constant(index) => TapeOperand::Constant(index),
        }
    }

    /// Frees the register of an operand if step `now` is the last that reads it.
    fn release(&mut self, operand: Operand, now: usize, last: &[usize]) {
        if let Operand::Step(index) = operand
            && last[usize::from(index)] == now
        {
            self.free.push(self.register[usize::from(index)]);
        }
    }

    /// Returns the register freed last, which is the likeliest to be in the nearest cache, or a new
    /// one.
    fn take(&mut self) -> u16 {
        self.free.pop().unwrap_or_else(|| {
            self.next += 1;
            self.next - 1
        })
    }
}
