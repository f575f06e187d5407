//! Scalar code of a genome before any lowering pass, as a program for the same evaluators.
//!
//! Moves and negations are free, as they are after lowering; every other written operation is
//! executed.

use std::collections::HashMap;

use brood_genome::{Function, Genome, Input, Liveness, ScalarMachine, expand};
use brood_program::{Operation, Program, WordsError};

/// A value, possibly negated.
#[derive(Debug, Clone, Copy)]
struct Signed {
    value: Value,
    negate: bool,
}

impl Default for Signed {
    fn default() -> Self {
        Self { value: Value::Constant(0), negate: false }
    }
}

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
        let mut writer = Writer::default();
        let results = expand(genome, &Liveness::written(genome), &mut writer);
        Self { steps: writer.steps, results: results.map(|signed| signed.value) }
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

/// Writes a step for every operation.
#[derive(Default)]
struct Writer {
    steps: Vec<Step>,
}

impl Writer {
    /// Adds a step and returns its value.
    fn step(&mut self, operation: Operation, a: Value, b: Value, negate: bool) -> Signed {
        self.steps.push((operation, a, b));
        Signed { value: Value::Step(self.steps.len() - 1), negate }
    }
}

impl ScalarMachine for Writer {
    type Value = Signed;

    fn constant(&mut self, value: f32) -> Signed {
        Signed { value: Value::Constant(value.to_bits()), negate: false }
    }

    fn input(&mut self, input: Input) -> Signed {
        Signed { value: Value::Input(input), negate: false }
    }

    fn neg(&mut self, a: Signed) -> Signed {
        Signed { negate: !a.negate, ..a }
    }

    /// Adds without a negation: the sign of a is moved to the result.
    fn add(&mut self, a: Signed, b: Signed) -> Signed {
        let operation = if a.negate == b.negate { Operation::Add } else { Operation::Sub };
        self.step(operation, a.value, b.value, a.negate)
    }

    fn mul(&mut self, a: Signed, b: Signed) -> Signed {
        self.step(Operation::Mul, a.value, b.value, a.negate ^ b.negate)
    }

    fn function(&mut self, function: Function, a: Signed) -> Signed {
        let (operation, negate) = Operation::of(function, a.negate);
        self.step(operation, a.value, a.value, negate)
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
