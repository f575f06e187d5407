//! Packed words: the flat u32 encoding of a program, used in leases and for hashes.
//!
//! Layout: version; number of constants; number of steps; three result operands; fifteen words of
//! the output stage; three words per constant (f32 bits, low and high half of the f64 bits); two
//! words per step. An operand has its kind in bits 22..24 and its index below. A step is the
//! operation in the top byte with the first operand, then the second operand.
//!
//! Programs with layers have a version of their own, so that the words and hashes of all others do
//! not depend on layers. The number of layers follows the steps, then for each layer the number of
//! its kind and two words (low, high half) for each of its parameter values.
//!
//! Styles and programs of colours have versions of their own, too. The effects of a style follow
//! the steps, see `style.rs`. A style that paints a BRDF has a version for its layers, of which
//! there may be none: they are between the steps and the effects.
//!
//! Programs with bumps have a version of their own, too, again with layers of which there may be
//! none. The bumps follow the layers, see `bump.rs`.

mod bump;
mod part;
mod style;

use brood_genome::{Input, LAYERS_MAX, Model, ModelKind, Output, Parameter, RANGE};

pub use part::WordsError;
use part::{halves, joined, length};

use crate::{Constant, Meaning, Operand, Operation, Program, Step};

const VERSION: u32 = 0x4252_4401;
const LAYERED_VERSION: u32 = 0x4252_4402;
const STYLE_VERSION: u32 = 0x4252_4403;
const COLOR_VERSION: u32 = 0x4252_4404;
const BRDF_STYLE_VERSION: u32 = 0x4252_4405;
const SLOPES_VERSION: u32 = 0x4252_4406;
const BUMPED_VERSION: u32 = 0x4252_4407;
/// Number of words before the output stage.
const HEADER: usize = 6;
/// Number of words of the output stage: matrix, scale and offset.
const OUTPUT: usize = 15;
/// Largest number of constants, and of steps: the canonical evaluator numbers inputs and constants
/// in 15 bits. Genomes need at most 12,288.
const MOST: usize = (1 << 15) - 1 - Input::ALL.len();
const STEP_KIND: u32 = 0;
const INPUT_KIND: u32 = 1;
const CONSTANT_KIND: u32 = 2;
const INDEX_BITS: u32 = 22;

impl Program {
    /// Returns the packed words.
    #[must_use]
    pub fn to_words(&self) -> Vec<u32> {
        let version = match &self.meaning {
            Meaning::Reflectance if self.bumps.is_some() => BUMPED_VERSION,
            Meaning::Reflectance if self.layers.is_empty() => VERSION,
            Meaning::Reflectance => LAYERED_VERSION,
            Meaning::Style(_) if self.is_by_brdf() => BRDF_STYLE_VERSION,
            Meaning::Style(_) => STYLE_VERSION,
            Meaning::Color => COLOR_VERSION,
            Meaning::Slopes => SLOPES_VERSION,
        };
        let mut words = vec![version, length(self.constants.len()), length(self.steps.len())];
        words.extend(self.results.map(operand_word));
        let output = &self.output;
        let numbers = output.matrix().as_flattened().iter().chain(output.scale());
        words.extend(numbers.chain(output.offset()).map(|number| number.to_bits()));
        for constant in &self.constants {
            words.push(constant.canonical.to_bits());
            words.extend(halves(constant.reference));
        }
        for step in &self.steps {
            words.push(u32::from(step.operation.number()) << 24 | operand_word(step.a));
            words.push(operand_word(step.b));
        }
        if matches!(version, LAYERED_VERSION | BRDF_STYLE_VERSION | BUMPED_VERSION) {
            words.push(length(self.layers.len()));
        }
        for model in &self.layers {
            words.push(u32::from(model.kind().number()));
            words.extend(model.parameter_values().iter().copied().flat_map(halves));
        }
        if let Meaning::Style(effects) = &self.meaning {
            style::write(effects, &mut words);
        }
        if let Some(bumps) = self.bumps() {
            bump::write(bumps, &mut words);
        }
        words
    }

    /// Reads a program from packed words and checks everything, because they may come from outside.
    ///
    /// # Errors
    /// Returns a [`WordsError`] with the index of the first invalid word.
    pub fn from_words(words: &[u32]) -> Result<Self, WordsError> {
        let header = words.get(..HEADER).ok_or(WordsError::Length)?;
        let (has_layers, is_style) = match header[0] {
            VERSION | COLOR_VERSION | SLOPES_VERSION => (false, false),
            LAYERED_VERSION | BUMPED_VERSION => (true, false),
            STYLE_VERSION => (false, true),
            BRDF_STYLE_VERSION => (true, true),
            _ => return Err(WordsError::Version),
        };
        let (constants, steps) = (header[1] as usize, header[2] as usize);
        let first_constant = HEADER + OUTPUT;
        let first_step = first_constant + 3 * constants.min(MOST);
        let first_layer = first_step + 2 * steps.min(MOST);
        let ends = match has_layers || is_style {
            true => words.len() > first_layer,
            false => words.len() == first_layer,
        };
        if !ends || constants.max(steps) > MOST {
            return Err(WordsError::Length);
        }
        let reader = Reader { words, constants };
        let (layers, end) = match has_layers {
            true => reader.layers(first_layer, usize::from(header[0] == LAYERED_VERSION))?,
            false => (Vec::new(), first_layer),
        };
        let is_bumped = header[0] == BUMPED_VERSION;
        let mut program = Self {
            steps: Vec::with_capacity(steps),
            constants: Vec::with_capacity(constants),
            results: [Operand::Constant(0); 3],
            output: reader.output()?,
            layers,
            meaning: match header[0] {
                STYLE_VERSION | BRDF_STYLE_VERSION => Meaning::Style(style::read(words, end)?),
                COLOR_VERSION => Meaning::Color,
                SLOPES_VERSION => Meaning::Slopes,
                _ => Meaning::Reflectance,
            },
            bumps: if is_bumped { Some(Box::new(bump::read(words, end)?)) } else { None },
        };
        if is_style && program.is_by_brdf() != has_layers {
            return Err(WordsError::Effect(end));
        }
        if !is_style && !is_bumped && end != words.len() {
            return Err(WordsError::Length);
        }
        for index in 0..constants {
            program.constants.push(reader.constant(first_constant + 3 * index)?);
        }
        for index in 0..steps {
            program.steps.push(reader.step(first_step + 2 * index, index)?);
        }
        for channel in 0..3 {
            program.results[channel] = reader.operand(3 + channel, steps)?;
        }
        Ok(program)
    }
}

fn operand_word(operand: Operand) -> u32 {
    match operand {
        Operand::Step(index) => STEP_KIND << INDEX_BITS | u32::from(index),
        Operand::Input(input) => INPUT_KIND << INDEX_BITS | length(input.index()),
        Operand::Constant(index) => CONSTANT_KIND << INDEX_BITS | u32::from(index),
    }
}

struct Reader<'a> {
    words: &'a [u32],
    constants: usize,
}

impl Reader<'_> {
    fn output(&self) -> Result<Output, WordsError> {
        let number = |k: usize| f32::from_bits(self.words[HEADER + k]);
        let triple = |k: usize| [number(k), number(k + 1), number(k + 2)];
        Output::new([triple(0), triple(3), triple(6)], triple(9), triple(12))
            .map_err(|_| WordsError::Number(HEADER))
    }

    fn constant(&self, at: usize) -> Result<Constant, WordsError> {
        let canonical = f32::from_bits(self.words[at]);
        let reference = joined(self.words[at + 1], self.words[at + 2]);
        let fits = canonical.abs() <= RANGE && reference.abs() <= f64::from(RANGE);
        if fits { Ok(Constant { canonical, reference }) } else { Err(WordsError::Number(at)) }
    }

    /// Reads the layers, at least `least`, and returns the index of the word after them.
    fn layers(&self, start: usize, least: usize) -> Result<(Vec<Model>, usize), WordsError> {
        let count = self.words[start] as usize;
        if !(least..=LAYERS_MAX).contains(&count) {
            return Err(WordsError::Model(start));
        }
        let mut at = start + 1;
        let mut layers = Vec::with_capacity(count);
        for _ in 0..count {
            let number = *self.words.get(at).ok_or(WordsError::Length)?;
            let kind = u8::try_from(number).ok().and_then(ModelKind::from_number);
            let kind = kind.ok_or(WordsError::Model(at))?;
            let length: usize = kind.parameters().iter().map(Parameter::count).sum();
            let end = at + 1 + 2 * length;
            let words = self.words.get(at + 1..end).ok_or(WordsError::Length)?;
            let numbers: Vec<f64> =
                words.as_chunks().0.iter().map(|[low, high]| joined(*low, *high)).collect();
            let model =
                Model::from_parameter_values(kind, &numbers).map_err(|_| WordsError::Model(at))?;
            layers.push(model);
            at = end;
        }
        Ok((layers, at))
    }

    /// Reads step `index` from the words at `at`.
    fn step(&self, at: usize, index: usize) -> Result<Step, WordsError> {
        let number = (self.words[at] >> 24) as usize;
        let operation = *Operation::ALL.get(number).ok_or(WordsError::Operation(at))?;
        Ok(Step { operation, a: self.operand(at, index)?, b: self.operand(at + 1, index)? })
    }

    /// Reads an operand, which may refer to steps before `steps`.
    fn operand(&self, at: usize, steps: usize) -> Result<Operand, WordsError> {
        let word = self.words[at] & 0x00ff_ffff;
        let index = word & ((1 << INDEX_BITS) - 1);
        let narrow = u16::try_from(index).map_err(|_| WordsError::Operand(at))?;
        let operand = match word >> INDEX_BITS {
            STEP_KIND if usize::from(narrow) < steps => Some(Operand::Step(narrow)),
            INPUT_KIND => Input::from_index(index as usize).map(Operand::Input),
            CONSTANT_KIND if usize::from(narrow) < self.constants => {
                Some(Operand::Constant(narrow))
            }
            _ => None,
        };
        operand.ok_or(WordsError::Operand(at))
    }
}

#[cfg(test)]
mod tests {
    use brood_genome::Genome;

    use super::*;

    fn layered() -> Program {
        let models = [ModelKind::Lambert, ModelKind::RoughPlastic].map(Model::new);
        Program::lower(&Genome::of_models(models.to_vec()).unwrap())
    }

    #[test]
    fn layers_round_trip_and_broken_layers_are_refused() {
        let program = layered();
        assert_eq!(program.layers().len(), 2);
        let words = program.to_words();
        assert_eq!(Program::from_words(&words), Ok(program));
        let first_layer = HEADER + OUTPUT + 3 * words[1] as usize + 2 * words[2] as usize;
        let broken = |at: usize, word| {
            let mut words = words.clone();
            words[at] = word;
            Program::from_words(&words)
        };
        assert_eq!(broken(first_layer, 0), Err(WordsError::Model(first_layer)));
        assert_eq!(broken(first_layer, 1), Err(WordsError::Length));
        assert_eq!(broken(first_layer, 3), Err(WordsError::Length));
        let many = length(LAYERS_MAX + 1);
        assert_eq!(broken(first_layer, many), Err(WordsError::Model(first_layer)));
        assert_eq!(broken(first_layer + 1, 255), Err(WordsError::Model(first_layer + 1)));
        // A parameter that is not a number.
        let nan = broken(first_layer + 3, 0x7ff8_0000);
        assert_eq!(nan, Err(WordsError::Model(first_layer + 1)));
        for end in first_layer..words.len() {
            assert_eq!(Program::from_words(&words[..end]), Err(WordsError::Length));
        }
        let mut plain = words[..first_layer].to_vec();
        plain[0] = VERSION;
        assert!(Program::from_words(&plain).unwrap().layers().is_empty());
    }

    #[test]
    fn words_have_at_most_as_many_constants_as_slots() {
        let plain =
            Program::lower(&Genome::of_models(vec![Model::new(ModelKind::Lambert)]).unwrap());
        let output = &plain.to_words()[HEADER..HEADER + OUTPUT];
        let with = |constants: usize| {
            let mut words = vec![VERSION, length(constants), 0];
            words.extend([CONSTANT_KIND << INDEX_BITS; 3]);
            words.extend(output);
            words.extend(vec![0; 3 * constants]);
            Program::from_words(&words)
        };
        assert_eq!(MOST + Input::ALL.len(), 0x7fff);
        assert_eq!(with(MOST).unwrap().constants().len(), MOST);
        assert_eq!(with(MOST + 1), Err(WordsError::Length));
        assert_eq!(with(0), Err(WordsError::Operand(3)), "the results refer to constant 0");
    }

    #[test]
    fn numbers_and_operands_are_refused_outside_of_their_ranges() {
        let words = |operand: u32, step: u32, canonical: f32, reference: f64| {
            let plain = layered().to_words();
            let mut words = vec![VERSION, 1, 1];
            words.extend([STEP_KIND << INDEX_BITS; 3]);
            words.extend(&plain[HEADER..HEADER + OUTPUT]);
            words.push(canonical.to_bits());
            words.extend(halves(reference));
            words.extend([step | operand, operand]);
            Program::from_words(&words).map(|program| program.steps()[0])
        };
        let (constant, add) = (CONSTANT_KIND << INDEX_BITS, 0);
        let (at, step) = (HEADER + OUTPUT, HEADER + OUTPUT + 3);
        let whole = f64::from(RANGE);
        assert!(words(constant, add, RANGE, -whole).is_ok());
        assert_eq!(words(constant, add, 2.0 * RANGE, 0.0), Err(WordsError::Number(at)));
        assert_eq!(words(constant, add, 0.0, 2.0 * whole), Err(WordsError::Number(at)));
        assert_eq!(words(constant, add, f32::NAN, 0.0), Err(WordsError::Number(at)));
        let input = INPUT_KIND << INDEX_BITS | 1;
        let read = words(input, add, 0.0, 0.0).unwrap();
        assert_eq!(read.a, Operand::Input(Input::ALL[1]));
        let beyond = INPUT_KIND << INDEX_BITS | length(Input::ALL.len());
        for operand in [constant + 1, STEP_KIND << INDEX_BITS, beyond, 3 << INDEX_BITS, 1 << 16] {
            assert_eq!(words(operand, add, 0.0, 0.0), Err(WordsError::Operand(step)));
        }
        let unknown = length(Operation::ALL.len()) << 24;
        assert_eq!(words(constant, unknown, 0.0, 0.0), Err(WordsError::Operation(step)));
        let last = length(Operation::ALL.len() - 1) << 24;
        assert_eq!(words(constant, last, 0.0, 0.0).unwrap().operation, Operation::StepNeg);
    }
}
