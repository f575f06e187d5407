//! The genome: instructions, constants, dialect, layers of models and the output stage, or effects;
//! valid by construction.

use crate::effect::{self, Effect, EffectsError};
use crate::{
    CONSTANTS, Dialect, DialectError, ImageHash, Instruction, InstructionError, Model, Opcode,
    OpcodeSet, Operand, Output, Parametrisation, RANGE, Register, Swizzle, WriteMask,
};

/// Largest number of layers of a genome.
pub const LAYERS_MAX: usize = 4;

/// Largest number of instructions of the program of bumps.
pub const BUMP_LENGTH_MAX: usize = 64;

/// Largest magnitude of the strength of bumps.
pub const BUMP_STRENGTH_MAX: f32 = 16.0;

/// A BRDF as a fixed-length program, layers of models, or both; or a painted material as effects,
/// with or without a program.
///
/// A BRDF is f = scale (matrix (g^2 + sum of the layers)) + offset, where g is the result of the
/// program: R0.xyz after the last instruction. A genome without a program has length 0, and at
/// least one layer or effect. A genome with effects has no layers, the identity as output stage and
/// no energy limit, unless its light effect is `by brdf`: then it is a BRDF and effects that paint
/// it. A BRDF without effects may have bumps, which turn the normal at which it is evaluated.
#[derive(Debug, Clone, PartialEq)]
pub struct Genome {
    dialect: Dialect,
    instructions: Vec<Instruction>,
    constants: Box<[[f32; 4]; CONSTANTS]>,
    output: Output,
    limited: bool,
    layers: Vec<Model>,
    effects: Vec<Effect>,
    bump: Option<Box<Bump>>,
}

/// Error of [`Genome::layered`] and [`Genome::painted`].
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum GenomeError {
    /// The dialect is not valid.
    #[error(transparent)]
    Dialect(#[from] DialectError),
    /// The number of instructions is not the dialect's length.
    #[error("the dialect's length is {expected} instructions, got {given}")]
    Length {
        /// Length of the dialect.
        expected: u16,
        /// Number of instructions that were given.
        given: usize,
    },
    /// There is neither an instruction nor a model nor an effect.
    #[error("a genome must have at least one instruction, one model or one effect")]
    Empty,
    /// The effects do not belong together.
    #[error(transparent)]
    Effects(#[from] EffectsError),
    /// Too many models.
    #[error("a genome can have at most {LAYERS_MAX} models, got {0}")]
    Layers(usize),
    /// An instruction is not valid in the dialect.
    #[error("instruction {index}: {error}")]
    Instruction {
        /// Position in the genome.
        index: usize,
        /// The rule that it violates.
        error: InstructionError,
    },
    /// A constant is not finite or too large.
    #[error("constant C{index} must be between -65504 and 65504, got {value}")]
    Constant {
        /// Index of the register.
        index: usize,
        /// The value.
        value: f32,
    },
    /// The program of bumps is empty or too long.
    #[error("bumps must have 1 to {BUMP_LENGTH_MAX} instructions, got {0}")]
    BumpLength(usize),
    /// The strength of bumps is not finite or too large.
    #[error(
        "the strength of bumps must be between -{BUMP_STRENGTH_MAX} and {BUMP_STRENGTH_MAX}, got {0}"
    )]
    BumpStrength(f32),
    /// Effects and bumps together.
    #[error("a painted material has no bumps")]
    PaintedBump,
}

impl Genome {
    /// Creates a genome without layers.
    ///
    /// # Errors
    /// As [`Genome::layered`].
    pub fn new(
        dialect: Dialect,
        instructions: Vec<Instruction>,
        constants: Box<[[f32; 4]; CONSTANTS]>,
        output: Output,
    ) -> Result<Self, GenomeError> {
        Self::layered(dialect, instructions, constants, output, Vec::new())
    }

    /// Creates a genome of models alone, without a program.
    ///
    /// # Errors
    /// Returns [`GenomeError`] if there is no model or there are too many.
    pub fn of_models(layers: Vec<Model>) -> Result<Self, GenomeError> {
        let dialect = Dialect { length: 0, ..Dialect::default() };
        let constants = Box::new([[0.0; 4]; CONSTANTS]);
        Self::layered(dialect, Vec::new(), constants, Output::IDENTITY, layers)
    }

    /// Creates a genome and checks all its parts.
    ///
    /// # Errors
    /// Returns [`GenomeError`] with the first part that is not valid.
    pub fn layered(
        dialect: Dialect,
        instructions: Vec<Instruction>,
        constants: Box<[[f32; 4]; CONSTANTS]>,
        output: Output,
        layers: Vec<Model>,
    ) -> Result<Self, GenomeError> {
        if instructions.is_empty() && layers.is_empty() && dialect.length == 0 {
            return Err(GenomeError::Empty);
        }
        let (limited, effects, bump) = (false, Vec::new(), None);
        Self { dialect, instructions, constants, output, limited, layers, effects, bump }.checked()
    }

    /// Creates the program of bumps and checks all its parts but the dialect.
    fn of_bumps(
        dialect: Dialect,
        instructions: Vec<Instruction>,
        constants: Box<[[f32; 4]; CONSTANTS]>,
    ) -> Result<Self, GenomeError> {
        let (output, limited, bump) = (Output::IDENTITY, false, None);
        let (layers, effects) = (Vec::new(), Vec::new());
        Self { dialect, instructions, constants, output, limited, layers, effects, bump }
            .with_checked_code()
    }

    /// Creates a painted genome and checks all its parts. It may have a program or not.
    ///
    /// # Errors
    /// Returns [`GenomeError`] with the first part that is not valid.
    pub fn painted(
        dialect: Dialect,
        instructions: Vec<Instruction>,
        constants: Box<[[f32; 4]; CONSTANTS]>,
        effects: Vec<Effect>,
    ) -> Result<Self, GenomeError> {
        if effects.is_empty() {
            return Err(GenomeError::Empty);
        }
        Effect::check_all(&effects)?;
        let (output, limited, layers, bump) = (Output::IDENTITY, false, Vec::new(), None);
        Self { dialect, instructions, constants, output, limited, layers, effects, bump }.checked()
    }

    /// Creates a painted genome without a program.
    ///
    /// # Errors
    /// Returns [`GenomeError`] if there is no effect, or the effects do not belong together.
    pub fn of_effects(effects: Vec<Effect>) -> Result<Self, GenomeError> {
        let dialect = Dialect { length: 0, ..Dialect::default() };
        Self::painted(dialect, Vec::new(), Box::new([[0.0; 4]; CONSTANTS]), effects)
    }

    /// Returns the BRDF of this genome under effects that paint what it reflects.
    ///
    /// # Errors
    /// Returns [`GenomeError`] if the effects do not belong together or are not `by brdf`, or the
    /// genome has no BRDF or has bumps.
    pub fn with_effects(self, effects: Vec<Effect>) -> Result<Self, GenomeError> {
        Effect::check_all(&effects)?;
        if self.bump.is_some() {
            return Err(GenomeError::PaintedBump);
        }
        match effect::are_by_brdf(&effects) {
            true => Self { effects, ..self }.checked(),
            false => Err(EffectsError::NotByBrdf.into()),
        }
    }

    /// Returns the genome if its dialect, layers, instructions and constants are valid.
    fn checked(self) -> Result<Self, GenomeError> {
        let Self { dialect, instructions, layers, .. } = &self;
        match self.has_brdf() {
            true => dialect.validate()?,
            false => dialect.validate_painted()?,
        }
        if self.is_by_brdf() && instructions.is_empty() && layers.is_empty() {
            return Err(EffectsError::NoBrdf.into());
        }
        if layers.len() > LAYERS_MAX {
            return Err(GenomeError::Layers(layers.len()));
        }
        self.with_checked_code()
    }

    /// Returns the genome if its instructions and constants are valid in its dialect.
    fn with_checked_code(self) -> Result<Self, GenomeError> {
        let Self { dialect, instructions, constants, .. } = &self;
        if instructions.len() != usize::from(dialect.length) {
            let given = instructions.len();
            return Err(GenomeError::Length { expected: dialect.length, given });
        }
        for (index, instruction) in instructions.iter().enumerate() {
            let operands: Vec<_> = instruction.operands().collect();
            let (opcode, dst) = (instruction.opcode(), instruction.dst());
            Instruction::new(opcode, dst, instruction.write_mask(), &operands, dialect)
                .map_err(|error| GenomeError::Instruction { index, error })?;
        }
        for (index, constant) in constants.iter().enumerate() {
            if let Some(value) = constant.iter().find(|v| !(-RANGE..=RANGE).contains(*v)) {
                return Err(GenomeError::Constant { index, value: *value });
            }
        }
        Ok(self)
    }

    /// Dialect: the opcodes, inputs, registers and length of the genome.
    #[inline]
    #[must_use]
    pub fn dialect(&self) -> &Dialect {
        &self.dialect
    }

    /// Instructions, as many as the dialect's length.
    #[inline]
    #[must_use]
    pub fn instructions(&self) -> &[Instruction] {
        &self.instructions
    }

    /// Models that are added to the squares of the program's results.
    #[inline]
    #[must_use]
    pub fn layers(&self) -> &[Model] {
        &self.layers
    }

    /// Effects of a painted genome in the order of painting; the first is a light effect. Empty for
    /// a BRDF.
    #[inline]
    #[must_use]
    pub fn effects(&self) -> &[Effect] {
        &self.effects
    }

    /// Different control images of the effects, in the order of their first use.
    #[must_use]
    pub fn images(&self) -> Vec<ImageHash> {
        effect::images_of(&self.effects)
    }

    /// True if the genome is a painted material: it has effects.
    #[inline]
    #[must_use]
    pub fn is_painted(&self) -> bool {
        !self.effects.is_empty()
    }

    /// True if the genome is a painted material whose light effect is `by brdf`.
    #[must_use]
    pub fn is_by_brdf(&self) -> bool {
        effect::are_by_brdf(&self.effects)
    }

    /// True if the genome has a BRDF: it is one, or it paints one.
    #[must_use]
    pub fn has_brdf(&self) -> bool {
        !self.is_painted() || self.is_by_brdf()
    }

    /// Bumps of a BRDF; `None` if its surface is as the mesh.
    #[inline]
    #[must_use]
    pub fn bump(&self) -> Option<&Bump> {
        self.bump.as_deref()
    }

    /// Returns the genome with other bumps. A painted genome stays as it is.
    #[must_use]
    pub fn with_bump(self, bump: Option<Bump>) -> Self {
        if self.is_painted() { self } else { Self { bump: bump.map(Box::new), ..self } }
    }

    /// Constants C0 to C127.
    #[inline]
    #[must_use]
    pub fn constants(&self) -> &[[f32; 4]; CONSTANTS] {
        &self.constants
    }

    /// Output stage.
    #[inline]
    #[must_use]
    pub fn output(&self) -> &Output {
        &self.output
    }

    /// True if f is divided by its largest directional albedo where that is above 1.
    #[inline]
    #[must_use]
    pub fn is_limited(&self) -> bool {
        self.limited
    }

    /// Returns the same program in a longer genome. Moves of a register to itself are prepended:
    /// they change nothing, and mutation can turn them into other instructions. A genome that
    /// already has the length or that has no program is returned as it is.
    ///
    /// # Errors
    /// Returns [`GenomeError`] if the genome is longer or the length is not valid for a dialect.
    pub fn padded(self, length: u16) -> Result<Self, GenomeError> {
        if self.instructions.is_empty() {
            return Ok(self);
        }
        let dialect = Dialect { length, ..self.dialect };
        let missing = usize::from(length).saturating_sub(self.instructions.len());
        let last = dialect.registers.saturating_sub(1);
        let register = Register::Temporary(last);
        let own = Operand { register, swizzle: Swizzle::IDENTITY, negate: false };
        let idle = Instruction::new(Opcode::Mov, last, WriteMask::ALL, &[own], &dialect)
            .map_err(|error| GenomeError::Instruction { index: 0, error })?;
        let idle = std::iter::repeat_n(idle, missing);
        let instructions = idle.chain(self.instructions).collect();
        Self { dialect, instructions, ..self }.checked()
    }

    /// Returns the genome with another output stage. A genome without a BRDF stays as it is.
    #[must_use]
    pub fn with_output(self, output: Output) -> Self {
        if self.has_brdf() { Self { output, ..self } } else { self }
    }

    /// Returns the genome with other constants.
    ///
    /// # Panics
    /// If a constant is outside [-65504, 65504].
    #[must_use]
    pub fn with_constants(self, constants: Box<[[f32; 4]; CONSTANTS]>) -> Self {
        let is_in_range = |value: &f32| (-RANGE..=RANGE).contains(value);
        assert!(constants.as_flattened().iter().all(is_in_range), "constants are within the range");
        Self { constants, ..self }
    }

    /// Returns the genome with the energy limit on or off. A genome without a BRDF stays as it is.
    #[must_use]
    pub fn with_limit(self, limited: bool) -> Self {
        if self.has_brdf() { Self { limited, ..self } } else { self }
    }
}

/// Bumps of a BRDF: a height over the texture position, whose slopes turn the normal.
///
/// The height is `strength` times R0.x after the last instruction. It is in units of the texture: a
/// height that grows by 1 while u grows by 1 has slope 1. Programs read u and v alone: each
/// temporary register begins as (u, v, 1, 0).
#[derive(Debug, Clone, PartialEq)]
pub struct Bump {
    strength: f32,
    program: Genome,
}

impl Bump {
    /// Creates bumps and checks all their parts.
    ///
    /// # Errors
    /// Returns [`GenomeError`] with the first part that is not valid.
    pub fn new(
        strength: f32,
        instructions: Vec<Instruction>,
        constants: Box<[[f32; 4]; CONSTANTS]>,
    ) -> Result<Self, GenomeError> {
        let length = instructions.len();
        if !(1..=BUMP_LENGTH_MAX).contains(&length) {
            return Err(GenomeError::BumpLength(length));
        }
        let program = Genome::of_bumps(Self::dialect(length), instructions, constants)?;
        Self { strength: 1.0, program }.with_strength(strength)
    }

    /// Returns the same bumps with another strength.
    ///
    /// # Errors
    /// Returns [`GenomeError::BumpStrength`] if it is not within [-16, 16].
    pub fn with_strength(self, strength: f32) -> Result<Self, GenomeError> {
        match (-BUMP_STRENGTH_MAX..=BUMP_STRENGTH_MAX).contains(&strength) {
            // Adding +0 turns -0 into +0: each genome has one encoding.
            true => Ok(Self { strength: strength + 0.0, ..self }),
            false => Err(GenomeError::BumpStrength(strength)),
        }
    }

    /// Dialect of the program of bumps with this number of instructions.
    #[must_use]
    pub fn dialect(length: usize) -> Dialect {
        Dialect {
            opcodes: OpcodeSet::Surface,
            parametrisation: Parametrisation::Smooth,
            registers: 8,
            length: u16::try_from(length).unwrap_or(u16::MAX),
            isotropic: false,
            homogeneous: false,
        }
    }

    /// Factor of the height; 0 is flat.
    #[inline]
    #[must_use]
    pub fn strength(&self) -> f32 {
        self.strength
    }

    /// Program whose R0.x is the height before the factor.
    #[inline]
    #[must_use]
    pub fn program(&self) -> &Genome {
        &self.program
    }
}
