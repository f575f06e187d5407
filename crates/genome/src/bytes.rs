//! Canonical byte encoding of a genome, its decoder, and the content hash over it.

use crate::effect::{PALETTE_MAX, PALETTE_MIN};
use crate::{
    BUMP_LENGTH_MAX, Bump, CONSTANTS, Dialect, Effect, EffectImage, EffectKind, EffectsError,
    Genome, GenomeError, GenomeHash, ImageHash, Instruction, InstructionError, LAYERS_MAX, Model,
    ModelKind, Opcode, OpcodeSet, Operand, Output, OutputError, Palette, Parameter,
    ParameterValues, Parametrisation, Register, Swizzle, WriteMask,
};

const HEAD: &[u8] = b"brood genome 1\n";
/// Bit of an effect with images, beside the number of its kind.
const HAS_IMAGES: u8 = 0x80;

/// Error of [`Genome::from_canonical_bytes`].
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum BytesError {
    /// The bytes do not begin with the header of the encoding.
    #[error("not the canonical bytes of a genome of version 1")]
    Head,
    /// There are too few or too many bytes.
    #[error("wrong number of bytes: the genome needs {0}")]
    Length(usize),
    /// A byte has no meaning at its position.
    #[error("invalid byte {value} at offset {at}")]
    Byte {
        /// Offset of the byte.
        at: usize,
        /// Value of the byte.
        value: u8,
    },
    /// An instruction is not valid in the dialect.
    #[error("instruction {index}: {error}")]
    Instruction {
        /// Position in the genome.
        index: usize,
        /// The rule that it violates.
        error: InstructionError,
    },
    /// A model has a value that is not valid for its parameter.
    #[error("the model at offset {at} has a parameter value out of range")]
    Model {
        /// Offset of the model.
        at: usize,
    },
    /// An effect has a value that is not valid for its parameter.
    #[error("the effect at offset {at} has an invalid palette or parameter value")]
    Effect {
        /// Offset of the effect.
        at: usize,
    },
    /// The bytes encode a genome in another form than the canonical one, such as -0 for 0.
    #[error("not the canonical form of the genome that the bytes encode")]
    Form,
    /// The output stage is not valid.
    #[error(transparent)]
    Output(#[from] OutputError),
    /// The parts do not make a genome.
    #[error(transparent)]
    Genome(#[from] GenomeError),
}

impl Genome {
    /// Returns all parts of the genome in a fixed order: dialect, instructions, constants, output
    /// stage, layers, effects, bumps (strength, number of instructions, instructions, constants);
    /// numbers as little-endian bits. The energy limit and the presence of layers, effects and
    /// bumps are bits of one byte, so that genomes without them keep the bytes of earlier versions.
    #[must_use]
    pub fn canonical_bytes(&self) -> Vec<u8> {
        let mut bytes = HEAD.to_vec();
        let dialect = self.dialect();
        bytes.push(match dialect.opcodes {
            OpcodeSet::Paper => 0,
            OpcodeSet::Extended => 1,
            OpcodeSet::Directed => 2,
            OpcodeSet::Surface => unreachable!("a genome is not a program of bumps"),
        });
        bytes.push(match dialect.parametrisation {
            Parametrisation::Smooth => 0,
            Parametrisation::Paper => 1,
        });
        bytes.push(dialect.registers);
        bytes.extend(dialect.length.to_le_bytes());
        let has_layers = !self.layers().is_empty();
        // Bits 0 to 5 of one byte.
        let Dialect { isotropic, homogeneous, .. } = *dialect;
        let (is_limited, has_bump) = (self.is_limited(), self.bump().is_some());
        let switches =
            [isotropic, homogeneous, is_limited, has_layers, self.is_painted(), has_bump];
        bytes.push((0..).zip(switches).map(|(bit, on)| u8::from(on) << bit).sum());
        write_instructions(self, &mut bytes);
        let output = self.output();
        let numbers = self.constants().iter().flatten().chain(output.matrix().iter().flatten());
        for number in numbers.chain(output.scale()).chain(output.offset()) {
            bytes.extend(number.to_bits().to_le_bytes());
        }
        if has_layers {
            bytes.push(u8::try_from(self.layers().len()).expect("there are few layers"));
        }
        for model in self.layers() {
            bytes.push(model.kind().number());
            bytes.extend(
                model.parameter_values().iter().flat_map(|number| number.to_bits().to_le_bytes()),
            );
        }
        if self.is_painted() {
            bytes.push(u8::try_from(self.effects().len()).expect("there are few effects"));
        }
        self.effects().iter().for_each(|effect| write_effect(effect, &mut bytes));
        if let Some(bump) = self.bump() {
            let program = bump.program();
            bytes.extend(bump.strength().to_bits().to_le_bytes());
            bytes.extend(program.dialect().length.to_le_bytes());
            write_instructions(program, &mut bytes);
            let numbers = program.constants().as_flattened().iter();
            bytes.extend(numbers.flat_map(|number| number.to_bits().to_le_bytes()));
        }
        bytes
    }

    /// Decodes canonical bytes. Everything is checked, as for a text.
    ///
    /// # Errors
    /// Returns [`BytesError`] if the bytes are not the canonical encoding of a genome.
    pub fn from_canonical_bytes(bytes: &[u8]) -> Result<Self, BytesError> {
        let body = bytes.strip_prefix(HEAD).ok_or(BytesError::Head)?;
        let mut reader = Reader { total: bytes.len(), rest: body };
        let (dialect, [limited, has_layers, has_effects, has_bump]) = reader.dialect()?;
        let validated = match has_effects {
            true => dialect.validate_painted(),
            false => dialect.validate(),
        };
        validated.map_err(GenomeError::from)?;
        let instructions = reader.instructions(&dialect)?;
        let constants = reader.constants()?;
        let mut numbers = [[0.0; 3]; 5];
        for number in numbers.iter_mut().flatten() {
            *number = reader.number()?;
        }
        let [red, green, blue, scale, offset] = numbers;
        let layers = if has_layers { reader.layers()? } else { Vec::new() };
        let effects = if has_effects { reader.effects()? } else { Vec::new() };
        let bump = if has_bump { Some(reader.bump()?) } else { None };
        if !reader.rest.is_empty() {
            return Err(BytesError::Length(reader.at()));
        }
        let output = Output::new([red, green, blue], scale, offset)?;
        if has_effects && has_bump {
            return Err(GenomeError::PaintedBump.into());
        }
        let is_plain = !limited && !has_layers && output == Output::IDENTITY;
        let genome = if has_effects && is_plain {
            Self::painted(dialect, instructions, constants, effects)?
        } else {
            if has_effects && !crate::effect::are_by_brdf(&effects) {
                return Err(GenomeError::from(EffectsError::NotByBrdf).into());
            }
            let genome = Self::layered(dialect, instructions, constants, output, layers)?;
            let genome = genome.with_limit(limited).with_bump(bump);
            if has_effects { genome.with_effects(effects)? } else { genome }
        };
        // Otherwise two hashes would name the same genome.
        if genome.canonical_bytes() == bytes { Ok(genome) } else { Err(BytesError::Form) }
    }

    /// Content hash.
    #[must_use]
    pub fn hash(&self) -> GenomeHash {
        GenomeHash::of(&self.canonical_bytes())
    }
}

/// Decoder of canonical bytes.
struct Reader<'a> {
    total: usize,
    rest: &'a [u8],
}

impl Reader<'_> {
    /// Number of bytes read.
    fn at(&self) -> usize {
        self.total - self.rest.len()
    }

    fn take<const N: usize>(&mut self) -> Result<[u8; N], BytesError> {
        let (bytes, rest) =
            self.rest.split_first_chunk().ok_or(BytesError::Length(self.at() + N))?;
        self.rest = rest;
        Ok(*bytes)
    }

    /// Reads one byte and decodes it.
    fn byte<T>(&mut self, meaning: impl FnOnce(u8) -> Option<T>) -> Result<T, BytesError> {
        let at = self.at();
        let [value] = self.take()?;
        meaning(value).ok_or(BytesError::Byte { at, value })
    }

    fn number(&mut self) -> Result<f32, BytesError> {
        Ok(f32::from_le_bytes(self.take()?))
    }

    fn instructions(&mut self, dialect: &Dialect) -> Result<Vec<Instruction>, BytesError> {
        (0..usize::from(dialect.length)).map(|index| self.instruction(index, dialect)).collect()
    }

    fn constants(&mut self) -> Result<Box<[[f32; 4]; CONSTANTS]>, BytesError> {
        let mut constants = Box::new([[0.0; 4]; CONSTANTS]);
        for constant in constants.iter_mut().flatten() {
            *constant = self.number()?;
        }
        Ok(constants)
    }

    /// Reads bumps. Rejects a strength that would be stored with other bits (-0).
    fn bump(&mut self) -> Result<Bump, BytesError> {
        let (at, strength) = (self.at(), self.number()?);
        let length = u16::from_le_bytes(self.take()?);
        if strength.to_bits() == (-0.0_f32).to_bits() {
            return Err(BytesError::Byte { at, value: 0x80 });
        }
        if usize::from(length) > BUMP_LENGTH_MAX {
            return Err(GenomeError::BumpLength(length.into()).into());
        }
        let instructions = self.instructions(&Bump::dialect(length.into()))?;
        Ok(Bump::new(strength, instructions, self.constants()?)?)
    }

    /// Reads the dialect, the energy limit, and whether there are layers, effects and bumps.
    fn dialect(&mut self) -> Result<(Dialect, [bool; 4]), BytesError> {
        let opcodes = self.byte(|byte| match byte {
            0 => Some(OpcodeSet::Paper),
            1 => Some(OpcodeSet::Extended),
            2 => Some(OpcodeSet::Directed),
            _ => None,
        })?;
        let parametrisation = self.byte(|byte| match byte {
            0 => Some(Parametrisation::Smooth),
            1 => Some(Parametrisation::Paper),
            _ => None,
        })?;
        let registers = self.byte(Some)?;
        let length = u16::from_le_bytes(self.take()?);
        let [isotropic, homogeneous, limited, has_layers, has_effects, has_bump] = self
            .byte(|byte| (byte < 64).then_some([1, 2, 4, 8, 16, 32].map(|bit| byte & bit != 0)))?;
        let dialect =
            Dialect { opcodes, parametrisation, registers, length, isotropic, homogeneous };
        Ok((dialect, [limited, has_layers, has_effects, has_bump]))
    }

    /// Reads the layers, at least one.
    fn layers(&mut self) -> Result<Vec<Model>, BytesError> {
        let count = self.byte(|count| (1..=LAYERS_MAX).contains(&count.into()).then_some(count))?;
        (0..count).map(|_| self.model()).collect()
    }

    /// Reads a model: number of its kind, then its parameter values as f64. Rejects a value that
    /// the model would store with other bits (-0), so that each genome has one encoding.
    fn model(&mut self) -> Result<Model, BytesError> {
        let at = self.at();
        let kind = self.byte(ModelKind::from_number)?;
        let values = self.numbers(kind.parameters())?;
        let model = Model::from_parameter_values(kind, &values).ok();
        let model = model.filter(|model| has_bits(model.parameter_values(), &values));
        model.ok_or(BytesError::Model { at })
    }

    /// Reads the effects, at least one.
    fn effects(&mut self) -> Result<Vec<Effect>, BytesError> {
        let is_count = |count: u8| (1..=EffectKind::ALL.len()).contains(&count.into());
        let count = self.byte(|count| is_count(count).then_some(count))?;
        (0..count).map(|_| self.effect()).collect()
    }

    /// Reads an effect, as [`write_effect`] writes it. Rejects a value that the effect would store
    /// with other bits, so that each genome has one encoding.
    fn effect(&mut self) -> Result<Effect, BytesError> {
        let at = self.at();
        let invalid = BytesError::Effect { at };
        let (kind, has_images) = self.byte(|byte| {
            let kind = EffectKind::from_number(byte & !HAS_IMAGES)?;
            Some((kind, byte & HAS_IMAGES != 0))
        })?;
        let palette = if kind.has_palette() { Some(self.palette(at)?) } else { None };
        let values = self.numbers(kind.parameters())?;
        let made = ParameterValues::from_values(kind.name(), kind.parameters(), &values);
        let made = made.ok().and_then(|values| Effect::new(kind, values, palette).ok());
        let made = made.filter(|effect| has_bits(effect.values().values(), &values));
        let made = made.ok_or(invalid)?;
        match has_images {
            true => made.with_images(self.images(kind)?).map_err(|_| invalid),
            false => Ok(made),
        }
    }

    /// Reads the images of an effect, at least one, in the order of their places.
    fn images(&mut self, kind: EffectKind) -> Result<Vec<EffectImage>, BytesError> {
        let places = kind.image_places();
        let is_count = |count: u8| (1..=places.len()).contains(&count.into());
        let count = self.byte(|count| is_count(count).then_some(count))?;
        let mut next = 0;
        let image = |_| {
            let place =
                self.byte(|place| (next..places.len()).contains(&place.into()).then_some(place))?;
            next = usize::from(place) + 1;
            let image = ImageHash::from_bytes(self.take()?);
            let at = self.at();
            let share = f64::from_le_bytes(self.take()?);
            // -0 would be a second encoding of 0.
            match (0.0..=1.0).contains(&share) && share.is_sign_positive() {
                true => Ok(EffectImage { place: places[usize::from(place)].name, image, share }),
                false => Err(BytesError::Effect { at }),
            }
        };
        (0..count).map(image).collect()
    }

    /// Reads the palette of the effect at an offset.
    fn palette(&mut self, at: usize) -> Result<Palette, BytesError> {
        let count = self.byte(|count| {
            (PALETTE_MIN..=PALETTE_MAX).contains(&count.into()).then_some(usize::from(count))
        })?;
        let colors = (0..count).map(|_| self.take()).collect::<Result<Vec<_>, _>>()?;
        let edges: Vec<f64> =
            (1..count).map(|_| self.take().map(f64::from_le_bytes)).collect::<Result<_, _>>()?;
        let palette = Palette::new(Some(colors), Some(edges.clone())).ok();
        palette.filter(|made| has_bits(made.edges(), &edges)).ok_or(BytesError::Effect { at })
    }

    /// Reads the values of the parameters of a table as f64.
    fn numbers(&mut self, table: &[Parameter]) -> Result<Vec<f64>, BytesError> {
        let count: usize = table.iter().map(Parameter::count).sum();
        (0..count).map(|_| self.take().map(f64::from_le_bytes)).collect()
    }

    fn instruction(&mut self, index: usize, dialect: &Dialect) -> Result<Instruction, BytesError> {
        let opcode = self.byte(Opcode::from_number)?;
        let dst = self.byte(Some)?;
        let write_mask = self.byte(WriteMask::new)?;
        let unread =
            Operand { register: Register::Temporary(0), swizzle: Swizzle::IDENTITY, negate: false };
        let mut operands = [unread; 3];
        let operands = &mut operands[..opcode.operands()];
        for operand in operands.iter_mut() {
            *operand = self.operand()?;
        }
        Instruction::new(opcode, dst, write_mask, operands, dialect)
            .map_err(|error| BytesError::Instruction { index, error })
    }

    fn operand(&mut self) -> Result<Operand, BytesError> {
        let register = self.byte(|byte| {
            Some(match byte {
                0..0x80 => Register::Temporary(byte),
                _ => Register::Constant(byte & 0x7f),
            })
        })?;
        let swizzle = self.byte(|byte| Some(Swizzle::from_bits(byte)))?;
        let negate = self.byte(|byte| (byte < 2).then_some(byte == 1))?;
        Ok(Operand { register, swizzle, negate })
    }
}

/// True if both have the same bits.
fn has_bits(made: &[f64], read: &[f64]) -> bool {
    made.iter().zip(read).all(|(a, b)| a.to_bits() == b.to_bits())
}

fn write_instructions(genome: &Genome, bytes: &mut Vec<u8>) {
    for instruction in genome.instructions() {
        bytes.extend([instruction.opcode().number(), instruction.dst()]);
        bytes.push(instruction.write_mask().bits());
        instruction.operands().for_each(|operand| bytes.extend(operand_bytes(operand)));
    }
}

/// Writes the number of an effect's kind, its palette if the kind has one (number of colours, their
/// codes, the edges as f64), and its parameter values as f64. If it has images, bit 7 of the first
/// byte is set, and they follow: their number, and for each its place, hash and share.
fn write_effect(effect: &Effect, bytes: &mut Vec<u8>) {
    let flag = if effect.images().is_empty() { 0 } else { HAS_IMAGES };
    bytes.push(effect.kind().number() | flag);
    let edges = effect.palette().map_or(&[][..], Palette::edges);
    if let Some(palette) = effect.palette() {
        bytes.push(u8::try_from(palette.colors().len()).expect("a palette has at most 8 colours"));
        bytes.extend(palette.colors().as_flattened());
    }
    let numbers = edges.iter().chain(effect.values().values());
    bytes.extend(numbers.flat_map(|number| number.to_bits().to_le_bytes()));
    if flag != 0 {
        bytes.push(u8::try_from(effect.images().len()).expect("an effect has few images"));
    }
    let places = effect.kind().image_places();
    for EffectImage { place, image, share } in effect.images() {
        let place = places.iter().position(|own| own.name == *place);
        let place = place.expect("images take places of their effect");
        bytes.push(u8::try_from(place).expect("an effect has few places"));
        bytes.extend(image.as_bytes());
        bytes.extend(share.to_bits().to_le_bytes());
    }
}

/// Register (bit 7 is set for a constant), swizzle, and 1 if the value is negated.
fn operand_bytes(operand: Operand) -> [u8; 3] {
    let register = match operand.register {
        Register::Temporary(index) => index,
        Register::Constant(index) => 0x80 | index,
    };
    [register, operand.swizzle.bits(), u8::from(operand.negate)]
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::{BirthKey, Variation};

    fn genome(seed: u64, extended: bool) -> Genome {
        let opcodes = if extended { OpcodeSet::Extended } else { OpcodeSet::Paper };
        let dialect = Dialect {
            opcodes,
            registers: 12,
            length: 40,
            isotropic: extended,
            ..Dialect::default()
        };
        Variation::random(dialect).birth(BirthKey { seed, slot: 0, attempt: 0 })
    }

    #[test]
    fn opcode_numbers_round_trip() {
        for opcode in Opcode::ALL {
            assert_eq!(Opcode::from_number(opcode.number()), Some(opcode));
        }
        assert_eq!(Opcode::from_number(17), None);
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(60))]

        #[test]
        fn bytes_round_trip(seed in any::<u64>(), extended: bool) {
            let genome = genome(seed, extended);
            let output = Output::saturation(0.3).unwrap();
            let other = genome.clone().with_output(output).with_limit(true);
            for genome in [genome, other] {
                let bytes = genome.canonical_bytes();
                prop_assert_eq!(Genome::from_canonical_bytes(&bytes), Ok(genome));
            }
        }

        #[test]
        fn damaged_bytes_are_rejected_or_decode_to_another_genome(
            seed in any::<u64>(), extended: bool, at in any::<prop::sample::Index>(), flip in 1u8..,
        ) {
            let genome = genome(seed, extended);
            let mut bytes = genome.canonical_bytes();
            let at = at.index(bytes.len());
            prop_assert!(Genome::from_canonical_bytes(&bytes[..at]).is_err());
            bytes[at] ^= flip;
            match Genome::from_canonical_bytes(&bytes) {
                Err(error) => prop_assert!(!error.to_string().is_empty()),
                Ok(other) => prop_assert!(other.hash() != genome.hash()),
            }
            bytes[at] ^= flip;
            bytes.push(0);
            let length = bytes.len() - 1;
            prop_assert_eq!(Genome::from_canonical_bytes(&bytes), Err(BytesError::Length(length)));
        }
    }
}
