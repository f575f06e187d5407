//! Lobes as a genome. Operations and their order are those of the fit, so that results have the
//! same bits.

use super::Shape;
use crate::{
    CONSTANTS, Dialect, Genome, GenomeError, InitialValue, Input, Instruction, Opcode, OpcodeSet,
    Operand, Output, RANGE, Register, Swizzle, WriteMask,
};

/// First register of the units and of the terms; each register holds four.
const UNITS: u8 = 10;
const TERMS: u8 = 12;
const RESULT: u8 = 0;
const REGISTERS: u8 = 16;
/// Largest number of units and of terms: two registers each.
const MOST: usize = 8;

/// Error of converting lobes to a genome.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum LobesError {
    /// Too many units or terms for the registers.
    #[error("a program has at most {MOST} units and {MOST} terms, got {units} and {terms}")]
    TooLarge {
        /// Number of units.
        units: usize,
        /// Number of terms.
        terms: usize,
    },
    /// The machine has this input in no register.
    #[error("no register holds {}", .0.name())]
    Input(Input),
    /// The genome is invalid.
    #[error(transparent)]
    Genome(#[from] GenomeError),
}

impl Shape {
    /// Program that computes the lobes of these parameters, under the energy limit.
    ///
    /// # Errors
    /// Returns [`LobesError`] if there are too many units or terms, an input has no register, or
    /// the genome is invalid.
    ///
    /// # Panics
    /// If the number of parameters is not [`Shape::len`].
    pub fn genome(&self, parameters: &[f64]) -> Result<Genome, LobesError> {
        let (units, terms) = (self.units, self.terms);
        assert_eq!(parameters.len(), self.len(), "there is one value for each parameter");
        if units > MOST || terms > MOST {
            return Err(LobesError::TooLarge { units, terms });
        }
        let mut code = Code::new();
        let inputs = self.operands()?;
        let terms = self.write(&mut code, parameters, &inputs);
        let colour =
            |channel: usize, term: usize| libm::exp2(parameters[self.colour(term, channel)]);
        code.combine(RESULT, 3, &terms, colour);
        Ok(code.genome(dialect(0))?.with_limit(true))
    }

    /// Registers that hold the inputs before the first instruction.
    ///
    /// # Errors
    /// Returns [`LobesError::Input`] if no register holds an input.
    pub(crate) fn operands(&self) -> Result<Vec<Operand>, LobesError> {
        self.inputs.iter().map(|input| holds(*input)).collect()
    }

    /// Writes the units and the terms of these parameters, which read `inputs`. Returns the
    /// registers of the terms.
    pub(crate) fn write(
        &self,
        code: &mut Code,
        parameters: &[f64],
        inputs: &[Operand],
    ) -> Vec<Operand> {
        let (units, terms) = (self.units, self.terms);
        // R9.w starts as 1 in the extended dialect; its weight is the bias.
        let one = operand(Register::Temporary(9), Some(3));
        let features: Vec<Operand> = inputs.iter().copied().chain([one]).collect();
        for first in (0..units).step_by(4) {
            let register = UNITS + first_u8(first);
            let weight = |unit: usize, input: usize| parameters[self.unit(unit, input)];
            let count = (units - first).min(4);
            code.combine(register, count, &features, |k, input| weight(first + k, input));
            code.apply(Opcode::Spl, register, count);
        }
        let own = (0..units).map(|unit| {
            operand(Register::Temporary(UNITS + first_u8(unit)), Some(component(unit)))
        });
        let features: Vec<Operand> = own.chain(inputs.iter().copied()).collect();
        for first in (0..terms).step_by(4) {
            let register = TERMS + first_u8(first);
            let weight = |term: usize, feature: usize| parameters[self.term(term, feature)];
            let count = (terms - first).min(4);
            code.combine(register, count, &features, |k, feature| weight(first + k, feature));
            code.apply(Opcode::Ex2, register, count);
        }
        let register = |term| Register::Temporary(TERMS + first_u8(term));
        (0..terms).map(|term| operand(register(term), Some(component(term)))).collect()
    }
}

/// Number of registers before the one that holds this unit or term: four per register.
fn first_u8(index: usize) -> u8 {
    u8::try_from(index / 4).expect("there are few registers")
}

/// Component of this index in its register.
fn component(index: usize) -> u8 {
    u8::try_from(index % 4).expect("a register has four components")
}

fn operand(register: Register, component: Option<u8>) -> Operand {
    let swizzle = component.map_or(Swizzle::IDENTITY, Swizzle::splat);
    Operand { register, swizzle, negate: false }
}

/// Operand that holds an input before the first instruction.
fn holds(input: Input) -> Result<Operand, LobesError> {
    let dialect = dialect(0);
    let mut places = (0..10u8).flat_map(|register| (0..4u8).map(move |at| (register, at)));
    let place = places
        .find(|(register, at)| {
            // The code overwrites this register.
            *register != RESULT
                && dialect.initial(*register, usize::from(*at)) == InitialValue::Input(input)
        })
        .ok_or(LobesError::Input(input))?;
    Ok(operand(Register::Temporary(place.0), Some(place.1)))
}

fn dialect(length: u16) -> Dialect {
    Dialect {
        opcodes: OpcodeSet::Extended,
        registers: REGISTERS,
        length,
        isotropic: true,
        homogeneous: true,
        ..Dialect::default()
    }
}

/// Code under construction: instructions and constants.
pub(crate) struct Code {
    instructions: Vec<(Opcode, u8, WriteMask, Vec<Operand>)>,
    constants: Vec<[f32; 4]>,
}

impl Code {
    pub(crate) fn new() -> Self {
        Self { instructions: Vec::new(), constants: Vec::new() }
    }

    /// Sets components of a register to sums of operands times weights, in the order of the
    /// operands.
    #[expect(clippy::cast_possible_truncation, reason = "the machine is of f32")]
    pub(crate) fn combine(
        &mut self,
        register: u8,
        count: usize,
        operands: &[Operand],
        weight: impl Fn(usize, usize) -> f64,
    ) {
        let bits = (1u8 << count) - 1;
        let mask = WriteMask::new(bits).expect("the mask is not empty");
        let own = operand(Register::Temporary(register), None);
        let mut is_first = true;
        for (at, factor) in operands.iter().enumerate() {
            let value = |k: usize| if k < count { weight(k, at) as f32 } else { 0.0 };
            let constant = [0, 1, 2, 3].map(value).map(|value| value.clamp(-RANGE, RANGE));
            // If all weights are 0, the last product is kept, to set the register to 0.
            let is_last = at + 1 == operands.len();
            if constant == [0.0; 4] && !(is_first && is_last) {
                continue;
            }
            let constant = self.constant(constant);
            let (opcode, operands) = if is_first {
                (Opcode::Mul, vec![*factor, constant])
            } else {
                (Opcode::Mad, vec![*factor, constant, own])
            };
            is_first = false;
            self.instructions.push((opcode, register, mask, operands));
        }
    }

    /// Applies a function to each of the first components, in place.
    fn apply(&mut self, opcode: Opcode, register: u8, count: usize) {
        for component in 0..count {
            let component = u8::try_from(component).expect("a register has four components");
            let mask = WriteMask::new(1 << component).expect("one component is a valid mask");
            let own = operand(Register::Temporary(register), Some(component));
            self.instructions.push((opcode, register, mask, vec![own]));
        }
    }

    /// Adds an instruction.
    pub(crate) fn push(&mut self, opcode: Opcode, (register, mask): (u8, u8), own: &[Operand]) {
        let mask = WriteMask::new(mask).expect("the mask is not empty");
        self.instructions.push((opcode, register, mask, own.to_vec()));
    }

    /// Adds a constant register.
    pub(crate) fn constant(&mut self, values: [f32; 4]) -> Operand {
        let index = u8::try_from(self.constants.len()).expect("there are few constants");
        self.constants.push(values);
        operand(Register::Constant(index), None)
    }

    /// Genome of the dialect with the length of the code.
    pub(crate) fn genome(self, dialect: Dialect) -> Result<Genome, GenomeError> {
        let length = u16::try_from(self.instructions.len()).unwrap_or(u16::MAX);
        let dialect = Dialect { length, ..dialect };
        let instructions = self.instructions.iter().enumerate().map(|(index, parts)| {
            let (opcode, register, mask, operands) = parts;
            Instruction::new(*opcode, *register, *mask, operands, &dialect)
                .map_err(|error| GenomeError::Instruction { index, error })
        });
        let instructions = instructions.collect::<Result<Vec<_>, _>>()?;
        let mut constants = Box::new([[0.0; 4]; CONSTANTS]);
        constants[..self.constants.len()].copy_from_slice(&self.constants);
        Genome::new(dialect, instructions, constants, Output::IDENTITY)
    }
}
