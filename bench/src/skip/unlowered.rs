//! Scalar code of a genome before any lowering pass, as a program for the same evaluators.
//!
//! Moves and negations are free, as they are after lowering; every other written operation is
//! executed.

use std::collections::HashMap;

use brood_genome::{Genome, InitialValue, Input, Instruction, Opcode, Register};
use brood_program::{Operation, Program, WordsError};

/// A value, possibly negated.
#[derive(Debug, Clone, Copy)]
struct Signed {
    value: Value,
    negate: bool,
}

/// Result of a step, input or constant.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
enum Value {
    Step(usize),
    Input(Input),
    /// An f32 as bits.
    Constant(u32),
}

/// Operation and its operands; those of a unary operation are equal.
type Step = (Operation, Value, Value);

/// Scalar steps in the order of the genome, with the values of g for the three channels, up to
/// sign.
#[derive(Debug, Clone)]
pub struct Unlowered {
    steps: Vec<Step>,
    results: [Value; 3],
}

impl Unlowered {
    /// Translates every written component.
    pub fn as_written(genome: &Genome) -> Self {
        let dialect = genome.dialect();
        let source = |register, component| match dialect.initial(register, component) {
            InitialValue::Zero => constant(0.0),
            InitialValue::One => constant(1.0),
            InitialValue::Input(input) => Signed { value: Value::Input(input), negate: false },
        };
        let registers = (0..dialect.registers).map(|r| std::array::from_fn(|c| source(r, c)));
        let mut writer = Writer { genome, registers: registers.collect(), steps: Vec::new() };
        for instruction in genome.instructions() {
            let result = writer.execute(instruction);
            let dst = &mut writer.registers[usize::from(instruction.dst())];
            for component in (0..4).filter(|c| instruction.write_mask().contains(*c)) {
                dst[component] = result[component].expect("every written component is computed");
            }
        }
        let [r, g, b, _] = writer.registers[0];
        Self { steps: writer.steps, results: [r, g, b].map(|signed| signed.value) }
    }

    /// Keeps only the steps that can reach a result.
    pub fn live(&self) -> Self {
        let mut live = vec![false; self.steps.len()];
        let mark = |live: &mut Vec<bool>, value: Value| {
            if let Value::Step(index) = value {
                live[index] = true;
            }
        };
        for result in self.results {
            mark(&mut live, result);
        }
        for (index, (_, a, b)) in self.steps.iter().enumerate().rev() {
            if live[index] {
                mark(&mut live, *a);
                mark(&mut live, *b);
            }
        }
        self.rewritten(|index, _, _| live[index].then_some(None))
    }

    /// Keeps one copy of each operation on the same values.
    pub fn numbered(&self) -> Self {
        let mut known: HashMap<Step, usize> = HashMap::new();
        self.rewritten(|_, step, next| match known.get(&step) {
            Some(earlier) => Some(Some(*earlier)),
            None => {
                known.insert(step, next);
                Some(None)
            }
        })
    }

    /// Number of scalar operations per sample.
    pub fn operations(&self) -> usize {
        self.steps.len()
    }

    /// Program for the evaluators, with the output stage of `lowered`, which comes from the same
    /// genome.
    pub fn program(&self, lowered: &Program) -> Result<Program, WordsError> {
        const HEADER: usize = 6;
        const OUTPUT: usize = 15;
        let template = lowered.to_words();
        let mut pool = Pool::default();
        let mut body = Vec::new();
        for (operation, a, b) in &self.steps {
            body.push(u32::from(operation.number()) << 24 | pool.operand(*a));
            body.push(pool.operand(*b));
        }
        let results = self.results.map(|value| pool.operand(value));
        let mut words = vec![template[0], count(pool.constants.len()), count(self.steps.len())];
        words.extend(results);
        words.extend_from_slice(&template[HEADER..HEADER + OUTPUT]);
        for bits in pool.constants {
            let wide = f64::from(f32::from_bits(bits)).to_bits();
            let half = |bits: u64| u32::try_from(bits).expect("half of 64 bits");
            words.extend([bits, half(wide & u64::from(u32::MAX)), half(wide >> 32)]);
        }
        words.extend(body);
        Program::from_words(&words)
    }

    /// Rewrites the steps. `keep` takes the index of a step, the step with operands among the kept
    /// ones, and the index that it would get. It returns `None` to drop the step, `Some(None)` to
    /// keep it and `Some(Some(k))` to replace it by the kept step k.
    fn rewritten(&self, mut keep: impl FnMut(usize, Step, usize) -> Option<Option<usize>>) -> Self {
        let mut moved: Vec<usize> = Vec::with_capacity(self.steps.len());
        let mut steps: Vec<Step> = Vec::new();
        for (index, (operation, a, b)) in self.steps.iter().enumerate() {
            let at = |value: &Value| match value {
                Value::Step(index) => Value::Step(moved[*index]),
                Value::Input(_) | Value::Constant(_) => *value,
            };
            let step = (*operation, at(a), at(b));
            match keep(index, step, steps.len()) {
                // No kept step reads it.
                None => moved.push(usize::MAX),
                Some(Some(earlier)) => moved.push(earlier),
                Some(None) => {
                    moved.push(steps.len());
                    steps.push(step);
                }
            }
        }
        let results = self.results.map(|value| match value {
            Value::Step(index) => Value::Step(moved[index]),
            Value::Input(_) | Value::Constant(_) => value,
        });
        Self { steps, results }
    }
}

/// Constants of the packed words, without duplicates.
#[derive(Default)]
struct Pool {
    constants: Vec<u32>,
    places: HashMap<u32, usize>,
}

impl Pool {
    /// Packed operand: kind in bits 22..24, index below.
    fn operand(&mut self, value: Value) -> u32 {
        match value {
            Value::Step(index) => count(index),
            Value::Input(input) => 1 << 22 | count(input.index()),
            Value::Constant(bits) => {
                let next = self.constants.len();
                let place = *self.places.entry(bits).or_insert(next);
                if place == next {
                    self.constants.push(bits);
                }
                2 << 22 | count(place)
            }
        }
    }
}

fn count(n: usize) -> u32 {
    u32::try_from(n).expect("a genome has fewer than 65536 scalar operations")
}

fn constant(value: f32) -> Signed {
    Signed { value: Value::Constant(value.to_bits()), negate: false }
}

/// Scalar steps so far, and the value of each component of each register.
struct Writer<'a> {
    genome: &'a Genome,
    registers: Vec<[Signed; 4]>,
    steps: Vec<Step>,
}

impl Writer<'_> {
    /// Results of an instruction by component; components that it does not write may be `None`.
    fn execute(&mut self, instruction: &Instruction) -> [Option<Signed>; 4] {
        let mask = instruction.write_mask();
        let written = |k: usize| mask.contains(k);
        let read = |writer: &Self, position, k| writer.read(instruction, position, k);
        match instruction.opcode() {
            Opcode::Add => self.each(written, |w, k| {
                let (a, b) = (read(w, 0, k), read(w, 1, k));
                w.add(a, b)
            }),
            Opcode::Sub => self.each(written, |w, k| {
                let (a, b) = (read(w, 0, k), read(w, 1, k));
                w.add(a, b.negated())
            }),
            Opcode::Mul => self.each(written, |w, k| {
                let (a, b) = (read(w, 0, k), read(w, 1, k));
                w.mul(a, b)
            }),
            Opcode::Mov => self.each(written, |w, k| read(w, 0, k)),
            Opcode::Mad => self.each(written, |w, k| {
                let (a, b, c) = (read(w, 0, k), read(w, 1, k), read(w, 2, k));
                let product = w.mul(a, b);
                w.add(product, c)
            }),
            Opcode::Lrp => self.each(written, |w, k| {
                let (a, b, c) = (read(w, 0, k), read(w, 1, k), read(w, 2, k));
                let difference = w.add(b, c.negated());
                let product = w.mul(a, difference);
                w.add(product, c)
            }),
            Opcode::Dp3 => [Some(self.dot(instruction, 3)); 4],
            Opcode::Dp4 => [Some(self.dot(instruction, 4)); 4],
            Opcode::Dst => self.each(written, |w, k| match k {
                0 => constant(1.0),
                1 => {
                    let (a, b) = (read(w, 0, 1), read(w, 1, 1));
                    w.mul(a, b)
                }
                2 => read(w, 0, 2),
                _ => read(w, 1, 3),
            }),
            Opcode::X2d => {
                let upper = (written(0) || written(2)).then(|| self.row(instruction, 0));
                let lower = (written(1) || written(3)).then(|| self.row(instruction, 1));
                [upper, lower, upper, lower]
            }
            Opcode::Sin => self.function(instruction, Operation::Sin, Operation::Sin, true),
            Opcode::Cos => self.function(instruction, Operation::Cos, Operation::Cos, false),
            Opcode::Ex2 => self.function(instruction, Operation::Ex2, Operation::Ex2Neg, false),
            Opcode::Lg2 => self.function(instruction, Operation::Lg2, Operation::Lg2, false),
            Opcode::Rcp => self.function(instruction, Operation::Rcp, Operation::Rcp, true),
            Opcode::Rsq => self.function(instruction, Operation::Rsq, Operation::Rsq, false),
            Opcode::Spl => self.function(instruction, Operation::Spl, Operation::SplNeg, false),
        }
    }

    /// Computes each written component.
    fn each(
        &mut self,
        written: impl Fn(usize) -> bool,
        mut f: impl FnMut(&mut Self, usize) -> Signed,
    ) -> [Option<Signed>; 4] {
        std::array::from_fn(|k| written(k).then(|| f(self, k)))
    }

    /// Scalar function. `of_negative` is the operation for a negated operand; an `odd` function
    /// moves the sign to the result instead.
    fn function(
        &mut self,
        instruction: &Instruction,
        operation: Operation,
        of_negative: Operation,
        odd: bool,
    ) -> [Option<Signed>; 4] {
        let a = self.read(instruction, 0, 0);
        let operation = if a.negate { of_negative } else { operation };
        let value = self.step(operation, a.value, a.value);
        [Some(Signed { value, negate: odd && a.negate }); 4]
    }

    /// Dot product of the first components of both operands.
    fn dot(&mut self, instruction: &Instruction, components: usize) -> Signed {
        let product = |w: &mut Self, k| {
            let (a, b) = (w.read(instruction, 0, k), w.read(instruction, 1, k));
            w.mul(a, b)
        };
        let mut sum = product(self, 0);
        for k in 1..components {
            let next = product(self, k);
            sum = self.add(sum, next);
        }
        sum
    }

    /// One row of X2D: a component of a, plus the product of a row of c with b.
    fn row(&mut self, instruction: &Instruction, row: usize) -> Signed {
        let mut sum = self.read(instruction, 0, row);
        for k in 0..2 {
            let (b, c) = (self.read(instruction, 1, k), self.read(instruction, 2, 2 * row + k));
            let product = self.mul(b, c);
            sum = self.add(sum, product);
        }
        sum
    }

    /// Value of an operand for a written component: swizzle and sign applied.
    fn read(&self, instruction: &Instruction, position: usize, place: usize) -> Signed {
        let operand = instruction.operand(position);
        let component = operand.swizzle.component(place);
        let value = match operand.register {
            Register::Temporary(register) => self.registers[usize::from(register)][component],
            Register::Constant(register) => {
                constant(self.genome.constants()[usize::from(register)][component])
            }
        };
        if operand.negate { value.negated() } else { value }
    }

    /// Adds without a negation: the sign of a is moved to the result.
    fn add(&mut self, a: Signed, b: Signed) -> Signed {
        let operation = if a.negate == b.negate { Operation::Add } else { Operation::Sub };
        Signed { value: self.step(operation, a.value, b.value), negate: a.negate }
    }

    fn mul(&mut self, a: Signed, b: Signed) -> Signed {
        let value = self.step(Operation::Mul, a.value, b.value);
        Signed { value, negate: a.negate ^ b.negate }
    }

    /// Adds a step and returns its value.
    fn step(&mut self, operation: Operation, a: Value, b: Value) -> Value {
        self.steps.push((operation, a, b));
        Value::Step(self.steps.len() - 1)
    }
}

impl Signed {
    fn negated(self) -> Self {
        Self { negate: !self.negate, ..self }
    }
}

#[cfg(test)]
mod tests {
    use brood_eval::conformance::hard_samples;
    use brood_eval::{CanonicalEvaluator, Evaluator};
    use brood_genome::{BirthKey, Dialect, OpcodeSet, Variation};
    use brood_program::Counts;

    use super::*;

    #[test]
    fn unlowered_code_has_the_counts_and_bits_of_the_genome() {
        let set = hard_samples(3, 300);
        let extended =
            Dialect { opcodes: OpcodeSet::Extended, registers: 10, ..Dialect::default() };
        for (dialect, slot) in [Dialect::default(), extended].into_iter().zip([0, 40]) {
            for slot in slot..slot + 20 {
                let key = BirthKey { seed: 11, slot, attempt: 0 };
                let genome = Variation::random(dialect).birth(key);
                let (counts, lowered) = (Counts::of(&genome), Program::lower(&genome));
                let written = Unlowered::as_written(&genome);
                let live = written.live();
                assert_eq!(written.operations(), counts.scalar_operations as usize, "{slot}");
                assert_eq!(live.operations(), counts.live_scalar_operations as usize, "{slot}");
                assert!(live.numbered().operations() <= live.operations());
                let (mut expected, mut got) = (Vec::new(), Vec::new());
                let evaluator = CanonicalEvaluator::default();
                evaluator.eval(&[&lowered], &set, &mut expected).unwrap();
                for code in [&written, &live, &live.numbered()] {
                    let program = code.program(&lowered).unwrap();
                    evaluator.eval(&[&program], &set, &mut got).unwrap();
                    let bits = |f: &[f32]| f.iter().map(|f| f.to_bits()).collect::<Vec<_>>();
                    assert_eq!(bits(&got), bits(&expected), "slot {slot}\n{genome}");
                }
            }
        }
    }
}
