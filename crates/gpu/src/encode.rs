//! Encoding of tapes as the words that the shader reads.
//!
//! A batch is a directory of one entry per program, then the constants and steps of all of them. An
//! entry has 22 words: first and end of the steps, first constant, three result operands, fifteen
//! numbers of the output stage (matrix, scale, offset), and 1 if the results are colours. A step
//! has two words: the operation above the destination register, then the second operand above the
//! first, 16 bits each. An operand is a kind above an index.

use brood_brdf::InputMask;
use brood_program::{Program, Tape, TapeOperand};

use crate::GpuError;
use crate::operation::cost;
use crate::threads;

/// Number of words of a directory entry.
pub(crate) const ENTRY_WORDS: u32 = 22;
/// Number of bits of the index of an operand; the kind is above.
pub(crate) const INDEX_BITS: u32 = 14;
/// Largest number of steps of a program: some drivers silently end a loop after 65,535 iterations.
pub(crate) const MAX_STEPS: usize = 60_000;

/// Number of programs whose encoding is worth a thread of its own: it takes 0.2 ms or more.
const ENCODED: usize = 100;

/// Source of an operand.
#[derive(Debug, Clone, Copy)]
pub(crate) enum OperandKind {
    Register = 0,
    Input = 1,
    Constant = 2,
}

/// One encoded program, independent of its position in a batch.
#[derive(Debug)]
pub(crate) struct Encoded {
    /// Constants as the bits of f32.
    constants: Vec<u32>,
    steps: Vec<u32>,
    results: [u32; 3],
    /// Output stage as the bits of f32: matrix, scale, offset.
    output: [u32; 15],
    /// True if the results are colours, which are neither squared nor sent through the output
    /// stage.
    is_color: bool,
    registers: u32,
    /// See [`Encoded::rounds`].
    rounds: u64,
}

impl Encoded {
    /// Encodes a program. `inputs` is the union of the inputs of the batch, which are rows in this
    /// order.
    pub(crate) fn new(program: &Program, inputs: InputMask) -> Result<Self, GpuError> {
        let tape = Tape::new(program);
        let too_large = |what, given: usize, most: usize| GpuError::TooLarge { what, given, most };
        let indices = 1usize << INDEX_BITS;
        if tape.steps().len() > MAX_STEPS {
            return Err(too_large("steps", tape.steps().len(), MAX_STEPS));
        }
        if tape.constants().len() > indices {
            return Err(too_large("constants", tape.constants().len(), indices));
        }
        if usize::from(tape.registers()) > indices {
            return Err(too_large("registers", tape.registers().into(), indices));
        }
        let operand = |operand: TapeOperand| match operand {
            TapeOperand::Register(index) => word(OperandKind::Register, index.into()),
            TapeOperand::Constant(index) => word(OperandKind::Constant, index.into()),
            TapeOperand::Input(input) => {
                let below = inputs.iter().take_while(|other| *other != input).count();
                word(OperandKind::Input, u32::try_from(below).expect("there are 32 inputs at most"))
            }
        };
        let steps = tape.steps().iter().flat_map(|step| {
            let head = u32::from(step.operation.number()) << 16 | u32::from(step.dst);
            [head, operand(step.a) | operand(step.b) << 16]
        });
        let output = program.output();
        let mut numbers = output.matrix().as_flattened().iter().chain(output.scale());
        let mut offsets = output.offset().iter();
        Ok(Self {
            constants: tape.constants().iter().map(|c| c.canonical.to_bits()).collect(),
            steps: steps.collect(),
            results: tape.results().map(operand),
            output: std::array::from_fn(|_| {
                let number = numbers.next().or_else(|| offsets.next());
                number.expect("an output stage is fifteen numbers").to_bits()
            }),
            is_color: program.is_color(),
            registers: tape.registers().into(),
            rounds: tape.steps().iter().map(|step| cost(step.operation)).sum::<u64>() + 4,
        })
    }

    /// Returns the estimated work per sample, in iterations of the interpreter loop, including
    /// start and end of the program.
    pub(crate) fn rounds(&self) -> u64 {
        self.rounds
    }

    /// Returns the length of the register file that the program needs.
    pub(crate) fn registers(&self) -> u32 {
        self.registers
    }

    /// Returns the number of words in a batch, directory entry included.
    pub(crate) fn words(&self) -> u64 {
        u64::from(ENTRY_WORDS) + (self.constants.len() + self.steps.len()) as u64
    }
}

/// Encodes the programs of a batch, given the inputs of the batch.
pub(crate) fn encode(programs: &[&Program], mask: InputMask) -> Result<Vec<Encoded>, GpuError> {
    let encoded = threads::map(programs.to_vec(), ENCODED, |program| Encoded::new(program, mask));
    encoded.into_iter().collect()
}

/// Packs programs into the words of one batch.
pub(crate) fn pack(programs: &[Encoded]) -> Vec<u32> {
    let mut words = vec![0; programs.len() * ENTRY_WORDS as usize];
    let place = |words: &[u32]| u32::try_from(words.len()).expect("buffers are below 2^32 bytes");
    for (program, index) in programs.iter().zip(0..) {
        let constants = place(&words);
        words.extend(&program.constants);
        let steps = place(&words);
        words.extend(&program.steps);
        let entry = &mut words[index * ENTRY_WORDS as usize..][..ENTRY_WORDS as usize];
        let end = steps + u32::try_from(program.steps.len()).expect("bounded by MAX_STEPS");
        entry[..3].copy_from_slice(&[steps, end, constants]);
        entry[3..6].copy_from_slice(&program.results);
        entry[6..21].copy_from_slice(&program.output);
        entry[21] = program.is_color.into();
    }
    words
}

/// Returns an encoded operand.
fn word(kind: OperandKind, index: u32) -> u32 {
    (kind as u32) << INDEX_BITS | index
}

#[cfg(test)]
mod tests {
    use super::*;
    use brood_genome::{BirthKey, Dialect, Variation};

    #[test]
    fn pack_stores_every_program_where_its_entry_points() {
        let random = Variation::random(Dialect::default());
        let programs: Vec<Program> = (0..5)
            .map(|slot| Program::lower(&random.birth(BirthKey { seed: 3, slot, attempt: 0 })))
            .collect();
        let inputs = programs.iter().fold(InputMask::EMPTY, |mask, p| mask.union(p.inputs()));
        let encoded: Vec<Encoded> =
            programs.iter().map(|p| Encoded::new(p, inputs).unwrap()).collect();
        let words = pack(&encoded);
        assert_eq!(words.len() as u64, encoded.iter().map(Encoded::words).sum::<u64>());
        for (index, program) in encoded.iter().enumerate() {
            let entry = &words[index * ENTRY_WORDS as usize..][..ENTRY_WORDS as usize];
            let [steps, end, constants] = [entry[0], entry[1], entry[2]].map(|at| at as usize);
            assert_eq!(words[steps..end], program.steps);
            assert_eq!(words[constants..steps], program.constants);
            assert_eq!(entry[6..9].to_vec(), [1.0f32, 0.0, 0.0].map(f32::to_bits));
        }
    }
}
