//! The tape: a program with its values in registers, which is what evaluators execute.

use brood_genome::Input;

use crate::{Constant, Operand, Operation, Program};

/// Where a step of a tape reads.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum TapeOperand {
    /// A register written before.
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
    /// What is done.
    pub operation: Operation,
    /// The register written.
    pub dst: u16,
    /// First operand.
    pub a: TapeOperand,
    /// Second operand; repeats the first where the operation takes one.
    pub b: TapeOperand,
}

/// A register-allocated program.
///
/// # Invariants
/// Registers are read only after they were written, and `registers` is one more than the highest named.
#[derive(Debug, Clone, PartialEq)]
pub struct Tape {
    steps: Vec<TapeStep>,
    constants: Vec<Constant>,
    results: [TapeOperand; 3],
    registers: u16,
}

impl Tape {
    /// Allocates registers by one scan over the steps, each register free again after its last use.
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

    /// The steps in order.
    #[must_use]
    pub fn steps(&self) -> &[TapeStep] {
        &self.steps
    }

    /// The constants that operands name.
    #[must_use]
    pub fn constants(&self) -> &[Constant] {
        &self.constants
    }

    /// Where g of red, green and blue is found after the last step, up to sign.
    #[must_use]
    pub fn results(&self) -> &[TapeOperand; 3] {
        &self.results
    }

    /// How many registers it needs.
    #[must_use]
    pub fn registers(&self) -> u16 {
        self.registers
    }
}

/// For each step the index of the last step that reads it; results are read after the end.
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

struct Allocation {
    register: Vec<u16>,
    free: Vec<u16>,
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

    fn release(&mut self, operand: Operand, now: usize, last: &[usize]) {
        if let Operand::Step(index) = operand
            && last[usize::from(index)] == now
        {
            self.free.push(self.register[usize::from(index)]);
        }
    }

    /// The register freed last: it is the likeliest to be in the nearest cache.
    fn take(&mut self) -> u16 {
        self.free.pop().unwrap_or_else(|| {
            self.next += 1;
            self.next - 1
        })
    }
}
