//! The genome: instructions, constants, dialect, layers of models and the output stage; valid by
//! construction.

use crate::{
    Dialect, DialectError, Instruction, InstructionError, Model, Opcode, Operand, RANGE, Register,
    Swizzle, WriteMask,
};

/// Number of constant registers.
pub const CONSTANTS: usize = 128;

/// Largest number of layers of a genome.
pub const LAYERS_MAX: usize = 4;

/// A BRDF as a fixed-length program, layers of models, or both.
///
/// f = scale (matrix (g^2 + sum of the layers)) + offset, where g is the result of the program. A
/// genome without a program has length 0 and at least one layer.
#[derive(Debug, Clone, PartialEq)]
pub struct Genome {
    dialect: Dialect,
    instructions: Vec<Instruction>,
    constants: Box<[[f32; 4]; CONSTANTS]>,
    output: Output,
    limited: bool,
    layers: Vec<Model>,
}

/// Output stage: maps the squares of the result registers, plus the layers, to reflectance by f =
/// scale (matrix g^2) + offset.
///
/// All values are finite and in [0, 65504], so f is non-negative and finite for any program.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Output {
    matrix: [[f32; 3]; 3],
    scale: [f32; 3],
    offset: [f32; 3],
}

/// Error of [`Output::new`] and [`Output::saturation`].
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum OutputError {
    /// A value is negative, not finite or too large.
    #[error("values of the output stage must be between 0 and 65504, got {0}")]
    OutOfRange(f32),
    /// The saturation is outside [0, 1].
    #[error("saturation must be between 0 and 1, got {0}")]
    Saturation(f32),
}

/// Error of [`Genome::layered`].
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
    /// There is neither an instruction nor a model.
    #[error("a genome must have at least one instruction or one model")]
    Empty,
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
        dialect.validate()?;
        if layers.len() > LAYERS_MAX {
            return Err(GenomeError::Layers(layers.len()));
        }
        if instructions.len() != usize::from(dialect.length) {
            let given = instructions.len();
            return Err(GenomeError::Length { expected: dialect.length, given });
        }
        if instructions.is_empty() && layers.is_empty() {
            return Err(GenomeError::Empty);
        }
        for (index, instruction) in instructions.iter().enumerate() {
            let operands: Vec<_> = instruction.operands().collect();
            let (opcode, dst) = (instruction.opcode(), instruction.dst());
            Instruction::new(opcode, dst, instruction.write_mask(), &operands, &dialect)
                .map_err(|error| GenomeError::Instruction { index, error })?;
        }
        for (index, constant) in constants.iter().enumerate() {
            if let Some(value) = constant.iter().find(|v| !(-RANGE..=RANGE).contains(*v)) {
                return Err(GenomeError::Constant { index, value: *value });
            }
        }
        Ok(Self { dialect, instructions, constants, output, limited: false, layers })
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
        let Self { constants, output, limited, layers, .. } = self;
        let padded = Self::layered(dialect, instructions, constants, output, layers)?;
        Ok(padded.with_limit(limited))
    }

    /// Returns the genome with another output stage.
    #[must_use]
    pub fn with_output(self, output: Output) -> Self {
        Self { output, ..self }
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

    /// Returns the genome with the energy limit on or off.
    #[must_use]
    pub fn with_limit(self, limited: bool) -> Self {
        Self { limited, ..self }
    }
}

impl Default for Output {
    fn default() -> Self {
        Self::IDENTITY
    }
}

impl Output {
    /// f = g^2.
    pub const IDENTITY: Self = Self {
        matrix: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
        scale: [1.0; 3],
        offset: [0.0; 3],
    };

    /// Creates an output stage. Rows of the matrix make red, green and blue.
    ///
    /// # Errors
    /// Returns [`OutputError::OutOfRange`] unless all values are finite and in [0, 65504].
    pub fn new(
        matrix: [[f32; 3]; 3],
        scale: [f32; 3],
        offset: [f32; 3],
    ) -> Result<Self, OutputError> {
        let values = matrix.iter().flatten().chain(&scale).chain(&offset);
        match values.copied().find(|value| !(0.0..=RANGE).contains(value)) {
            Some(value) => Err(OutputError::OutOfRange(value)),
            // Adding +0 turns -0 into 0, so that equal stages have equal bits.
            None => Ok(Self {
                matrix: matrix.map(|row| row.map(|value| value + 0.0)),
                scale: scale.map(|value| value + 0.0),
                offset: offset.map(|value| value + 0.0),
            }),
        }
    }

    /// Creates an output stage that mixes colours with their luminance (Rec. 709 weights): 1 keeps
    /// colours, 0 gives grey.
    ///
    /// # Errors
    /// Returns [`OutputError::Saturation`] if `saturation` is outside [0, 1].
    pub fn saturation(saturation: f32) -> Result<Self, OutputError> {
        const LUMINANCE: [f32; 3] = [0.2126, 0.7152, 0.0722];
        if !(0.0..=1.0).contains(&saturation) {
            return Err(OutputError::Saturation(saturation));
        }
        let mut matrix = [LUMINANCE.map(|weight| (1.0 - saturation) * weight); 3];
        for (channel, row) in matrix.iter_mut().enumerate() {
            row[channel] += saturation;
        }
        Self::new(matrix, [1.0; 3], [0.0; 3])
    }

    /// Returns the output stage with f divided by `divisor`.
    ///
    /// # Domain
    /// `divisor` finite and at least 1.
    ///
    /// # Error
    /// Each value is rounded to the nearest f32.
    #[must_use]
    #[expect(clippy::cast_possible_truncation, reason = "rounded to the nearest f32")]
    pub fn divided(&self, divisor: f64) -> Self {
        let divide = |value: f32| (f64::from(value) / divisor) as f32;
        Self { scale: self.scale.map(divide), offset: self.offset.map(divide), ..*self }
    }

    /// Rows that make red, green and blue.
    #[must_use]
    #[inline]
    pub fn matrix(&self) -> &[[f32; 3]; 3] {
        &self.matrix
    }

    /// Factor of each channel after the matrix.
    #[must_use]
    #[inline]
    pub fn scale(&self) -> &[f32; 3] {
        &self.scale
    }

    /// Offset of each channel, added last.
    #[must_use]
    #[inline]
    pub fn offset(&self) -> &[f32; 3] {
        &self.offset
    }
}
