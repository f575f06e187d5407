//! The genome: instructions, constants, dialect, layers of models and the output stage, valid by construction.

use crate::{
    Dialect, DialectError, Instruction, InstructionError, Model, Opcode, Operand, RANGE, Register,
    Swizzle, WriteMask,
};

/// Number of constant registers.
pub const CONSTANTS: usize = 128;

/// Most models that lie over a program.
pub const LAYERS_MAX: usize = 4;

/// What computes a BRDF: a fixed-length program, layers of models, or both.
///
/// f = scale (matrix (g^2 + sum of the layers)) + offset, where g is the program's. A genome without a program has the length 0
/// and at least one layer.
#[derive(Debug, Clone, PartialEq)]
pub struct Genome {
    dialect: Dialect,
    instructions: Vec<Instruction>,
    constants: Box<[[f32; 4]; CONSTANTS]>,
    output: Output,
    limited: bool,
    layers: Vec<Model>,
}

/// What turns the squares of the result registers into reflectance: f = scale (matrix g^2) + offset, the
/// layers added to g^2.
///
/// All numbers are finite and in [0, 65504], so that f stays non-negative and finite whatever the program does.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Output {
    matrix: [[f32; 3]; 3],
    scale: [f32; 3],
    offset: [f32; 3],
}

/// Why an output stage is not one.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum OutputError {
    /// A number that is negative, not finite or beyond the range.
    #[error("{0} is not a number from 0 to 65504")]
    OutOfRange(f32),
    /// A saturation outside 0 to 1.
    #[error("saturation must be 0 to 1, not {0}")]
    Saturation(f32),
}

/// Why parts do not make a genome.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum GenomeError {
    /// The dialect itself.
    #[error(transparent)]
    Dialect(#[from] DialectError),
    /// The number of instructions is not the dialect's length.
    #[error("the dialect's length is {expected} instructions, not {given}")]
    Length {
        /// By the dialect.
        expected: u16,
        /// As given.
        given: usize,
    },
    /// Neither a program nor a model.
    #[error("a genome has at least one instruction or one model")]
    Empty,
    /// More models than there may be.
    #[error("a genome has at most {LAYERS_MAX} models, not {0}")]
    Layers(usize),
    /// An instruction that is not valid in the dialect.
    #[error("instruction {index}: {error}")]
    Instruction {
        /// Position in the genome.
        index: usize,
        /// What is wrong.
        error: InstructionError,
    },
    /// A constant that is not finite or beyond the range.
    #[error("constant C{index}: {value} is not a number from -65504 to 65504")]
    Constant {
        /// The register.
        index: usize,
        /// The value.
        value: f32,
    },
}

impl Genome {
    /// Puts a genome without layers together, checking everything.
    pub fn new(
        dialect: Dialect,
        instructions: Vec<Instruction>,
        constants: Box<[[f32; 4]; CONSTANTS]>,
        output: Output,
    ) -> Result<Self, GenomeError> {
        Self::layered(dialect, instructions, constants, output, Vec::new())
    }

    /// Models alone, one over the other.
    pub fn of_models(layers: Vec<Model>) -> Result<Self, GenomeError> {
        let dialect = Dialect { length: 0, ..Dialect::default() };
        let constants = Box::new([[0.0; 4]; CONSTANTS]);
        Self::layered(dialect, Vec::new(), constants, Output::IDENTITY, layers)
    }

    /// Puts a genome together, checking everything.
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

    /// What it may use.
    #[inline]
    #[must_use]
    pub fn dialect(&self) -> &Dialect {
        &self.dialect
    }

    /// The instructions, as many as the dialect's length.
    #[inline]
    #[must_use]
    pub fn instructions(&self) -> &[Instruction] {
        &self.instructions
    }

    /// Models that are added to the square of the program's results.
    #[inline]
    #[must_use]
    pub fn layers(&self) -> &[Model] {
        &self.layers
    }

    /// C0..C127.
    #[inline]
    #[must_use]
    pub fn constants(&self) -> &[[f32; 4]; CONSTANTS] {
        &self.constants
    }

    /// The output stage.
    #[inline]
    #[must_use]
    pub fn output(&self) -> &Output {
        &self.output
    }

    /// Whether its reflectance is divided by its largest directional albedo where that is above 1.
    #[inline]
    #[must_use]
    pub fn is_limited(&self) -> bool {
        self.limited
    }

    /// The same program in a longer genome: moves of a register to itself come before it, which change nothing and which
    /// mutation may turn into something. A genome that has the length already stays as it is, and so does one without a
    /// program.
    ///
    /// # Error
    /// Where the genome is longer, or the length is none of a dialect.
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

    /// The same program with another output stage.
    #[must_use]
    pub fn with_output(self, output: Output) -> Self {
        Self { output, ..self }
    }

    /// The same instructions with other constants.
    ///
    /// # Panics
    /// Where one is beyond the range of the machine.
    #[must_use]
    pub fn with_constants(self, constants: Box<[[f32; 4]; CONSTANTS]>) -> Self {
        let is_held = |value: &f32| (-RANGE..=RANGE).contains(value);
        assert!(constants.as_flattened().iter().all(is_held), "constants are within the range");
        Self { constants, ..self }
    }

    /// The same program under the energy limit, or not.
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

    /// Checks that all numbers are finite and in [0, 65504]. Rows of the matrix make red, green, blue.
    pub fn new(
        matrix: [[f32; 3]; 3],
        scale: [f32; 3],
        offset: [f32; 3],
    ) -> Result<Self, OutputError> {
        let numbers = matrix.iter().flatten().chain(&scale).chain(&offset);
        match numbers.copied().find(|value| !(0.0..=RANGE).contains(value)) {
            Some(value) => Err(OutputError::OutOfRange(value)),
            // Adding +0 turns -0 into 0, so that equal stages have equal bits.
            None => Ok(Self {
                matrix: matrix.map(|row| row.map(|value| value + 0.0)),
                scale: scale.map(|value| value + 0.0),
                offset: offset.map(|value| value + 0.0),
            }),
        }
    }

    /// The matrix that mixes colours with their luminance (Rec. 709 weights): 1 keeps them, 0 leaves grey.
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

    /// The stage whose reflectance is this one's divided by a number.
    ///
    /// # Domain
    /// A finite divisor of at least 1.
    ///
    /// # Error
    /// Each number is rounded to the nearest f32.
    #[must_use]
    #[expect(clippy::cast_possible_truncation, reason = "rounded to the nearest f32")]
    pub fn divided(&self, divisor: f64) -> Self {
        let divide = |value: f32| (f64::from(value) / divisor) as f32;
        Self { scale: self.scale.map(divide), offset: self.offset.map(divide), ..*self }
    }

    /// Rows make red, green, blue.
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

    /// What is added to each channel last.
    #[must_use]
    #[inline]
    pub fn offset(&self) -> &[f32; 3] {
        &self.offset
    }
}
