//! Dialects: the opcodes, inputs, registers and length of the genomes of a lineage.

use serde::{Deserialize, Serialize};

use crate::{Input, Parametrisation};

/// Set of opcodes and inputs.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum OpcodeSet {
    /// The paper's thirteen opcodes and eight inputs.
    #[default]
    Paper,
    /// Also four more smooth functions, and symmetric inputs in R7, R8 and R9.
    Extended,
    /// As extended, with inputs of the first light, the eye and the depth in R10 and R11 that
    /// change when the directions are exchanged. For programs of painted materials only.
    Directed,
    /// The opcodes of extended, and the inputs u and v alone. For programs of bumps only.
    Surface,
}

/// Rules for the genomes of a lineage. Fixed within a lineage, except `isotropic` and
/// `homogeneous`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Dialect {
    /// Set of opcodes and inputs.
    pub opcodes: OpcodeSet,
    /// Form of the azimuthal inputs.
    pub parametrisation: Parametrisation,
    /// Number of temporary registers, 4 to 16 (extended: 10 to 16, directed: 12 to 16).
    pub registers: u8,
    /// Number of instructions, 1 to 1024; 0 for genomes of models without a program.
    pub length: u16,
    /// If true, p5 and p6 read as 0: f is unchanged by rotations about the normal.
    pub isotropic: bool,
    /// If true, u and v read as 0: f is the same everywhere on the surface.
    pub homogeneous: bool,
}

impl Default for Dialect {
    fn default() -> Self {
        Self {
            opcodes: OpcodeSet::Paper,
            parametrisation: Parametrisation::Smooth,
            registers: 7,
            length: 100,
            isotropic: false,
            homogeneous: false,
        }
    }
}

/// Error of [`Dialect::validate`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum DialectError {
    /// The number of registers is out of range for the opcode set.
    #[error("registers must be between {min} and 16, got {given}")]
    Registers {
        /// Least number for this opcode set.
        min: u8,
        /// Number that was given.
        given: u8,
    },
    /// Only painted materials read directed inputs.
    #[error("the opcode set `directed` is for genomes with effects that are not `by brdf`")]
    Directed,
    /// Only bumps are functions of the position alone.
    #[error("the opcode set `surface` is for bumps")]
    Surface,
    /// The length is above 1024.
    #[error("length must be between 0 and 1024, got {0}")]
    Length(u16),
}

/// Initial value of a register component, before the first instruction.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum InitialValue {
    /// The constant 0.
    Zero,
    /// The constant 1.
    One,
    /// An input of the sample.
    Input(Input),
}

/// The eight quantities of the paper, independent of the parametrisation.
#[derive(Clone, Copy)]
enum Symbol {
    P1,
    P3,
    P5,
    P6,
    Q1,
    Q2,
    U,
    V,
}

use Symbol::{P1, P3, P5, P6, Q1, Q2, U, V};

/// Initial values of R0..R6; registers from R7 on repeat them, except R7 to R9 of the extended
/// dialect.
const INITIAL: [[Symbol; 4]; 7] = [
    [P1, P3, P5, P6],
    [Q1, Q2, U, V],
    [P3, Q1, Q2, P1],
    [Q1, Q2, P1, P3],
    [Q2, P1, P3, Q1],
    [P6, P5, V, U],
    [P1, Q1, P5, U],
];

impl Dialect {
    /// Checks the bounds of the fields, for BRDFs.
    ///
    /// # Errors
    /// Returns [`DialectError`] if the number of registers or the length is out of range, or the
    /// opcode set is that of painted materials.
    pub fn validate(&self) -> Result<(), DialectError> {
        match self.opcodes {
            OpcodeSet::Directed => Err(DialectError::Directed),
            OpcodeSet::Surface => Err(DialectError::Surface),
            OpcodeSet::Paper | OpcodeSet::Extended => self.validate_painted(),
        }
    }

    /// Checks the bounds of the fields, for painted materials.
    ///
    /// # Errors
    /// Returns [`DialectError`] if the number of registers or the length is out of range.
    pub fn validate_painted(&self) -> Result<(), DialectError> {
        let min = match self.opcodes {
            OpcodeSet::Paper => 4,
            OpcodeSet::Extended => 10,
            OpcodeSet::Directed => 12,
            OpcodeSet::Surface => return Err(DialectError::Surface),
        };
        if !(min..=16).contains(&self.registers) {
            return Err(DialectError::Registers { min, given: self.registers });
        }
        if self.length > 1024 {
            return Err(DialectError::Length(self.length));
        }
        Ok(())
    }

    /// True if genomes of both dialects can be crossed: the dialects are equal except for
    /// `isotropic` and `homogeneous`, or one of them has no program.
    #[must_use]
    pub fn is_compatible(&self, other: &Self) -> bool {
        if self.length == 0 || other.length == 0 {
            return true;
        }
        let free = |dialect: &Self| Self { isotropic: false, homogeneous: false, ..*dialect };
        free(self) == free(other)
    }

    /// Initial value of component 0..4 of temporary register `register`.
    #[must_use]
    pub fn initial(&self, register: u8, component: usize) -> InitialValue {
        if self.opcodes == OpcodeSet::Surface {
            return match component {
                0 => InitialValue::Input(Input::U),
                1 => InitialValue::Input(Input::V),
                2 => InitialValue::One,
                _ => InitialValue::Zero,
            };
        }
        if self.opcodes != OpcodeSet::Paper && (7..10).contains(&register) {
            return self.extended(register, component);
        }
        if self.opcodes == OpcodeSet::Directed && (10..12).contains(&register) {
            return directed(register, component);
        }
        self.symbol(INITIAL[usize::from(register) % INITIAL.len()][component])
    }

    /// Initial value of R7, R8 or R9 in the extended dialect.
    fn extended(&self, register: u8, component: usize) -> InitialValue {
        let input = match (register, component) {
            (7, 0) => Input::LogTanHalf,
            (7, 1) => Input::HalfDotLight,
            (7, 2) => Input::CosineDifference,
            (7, _) => Input::MirrorAsymmetry,
            (8, 0) => Input::CosineProduct,
            (8, 1) => Input::LogHalfDotLight,
            (8, 2) => Input::LogHalfAngle,
            (8, _) => Input::LogCosineProduct,
            (_, 0) => Input::LogCosineSum,
            (_, 1) => Input::NormalDotHalf,
            (_, 2) => return self.symbol(P3),
            _ => return InitialValue::One,
        };
        InitialValue::Input(input)
    }

    /// Input of a quantity in this parametrisation, or zero where a switch removes it.
    fn symbol(&self, symbol: Symbol) -> InitialValue {
        use Parametrisation::{Paper, Smooth};
        InitialValue::Input(match (symbol, self.parametrisation) {
            (P5 | P6, _) if self.isotropic => return InitialValue::Zero,
            (U | V, _) if self.homogeneous => return InitialValue::Zero,
            (P1, _) => Input::P1,
            (U, _) => Input::U,
            (V, _) => Input::V,
            (P3, Smooth) => Input::SmoothP3,
            (P5, Smooth) => Input::SmoothP5,
            (P6, Smooth) => Input::SmoothP6,
            (Q1, Smooth) => Input::SmoothQ1,
            (Q2, Smooth) => Input::SmoothQ2,
            (P3, Paper) => Input::PaperP3,
            (P5, Paper) => Input::PaperP5,
            (P6, Paper) => Input::PaperP6,
            (Q1, Paper) => Input::PaperQ1,
            (Q2, Paper) => Input::PaperQ2,
        })
    }
}

/// Initial value of R10 or R11 in the directed dialect.
fn directed(register: u8, component: usize) -> InitialValue {
    InitialValue::Input(match (register, component) {
        (10, 0) => Input::Light0Cos,
        (10, 1) => Input::Light0Mirror,
        (10, 2) => Input::NormalDotEye,
        (10, _) => Input::Depth,
        (_, 0) => Input::P2,
        (_, 1) => Input::SmoothP4,
        (_, 2) => return InitialValue::One,
        _ => return InitialValue::Zero,
    })
}

/// Overrides of the lineage's dialect. The genomes of the children contain the result.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(utoipa::ToSchema))]
#[serde(deny_unknown_fields)]
pub struct DialectConstraints {
    /// True: programs read 0 for the inputs p5 and p6, so materials are isotropic.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub isotropic: Option<bool>,
    /// True: programs read 0 for u and v, so materials are homogeneous but for their bumps.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub homogeneous: Option<bool>,
    /// True: random children, and those that mutate, have bumps. False: no child has any. Default:
    /// children have bumps if their parents do. Painted materials have none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub bumps: Option<bool>,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn constraints_make_their_inputs_zero() {
        let dialect = Dialect { isotropic: true, homogeneous: true, ..Dialect::default() };
        for register in 0..7 {
            for component in 0..4 {
                if let InitialValue::Input(input) = dialect.initial(register, component) {
                    use Input::{P1, SmoothP3, SmoothQ1, SmoothQ2};
                    assert!([P1, SmoothP3, SmoothQ1, SmoothQ2].contains(&input));
                }
            }
        }
        assert_eq!(dialect.initial(5, 0), InitialValue::Zero);
    }

    #[test]
    fn dialect_is_rejected_when_out_of_bounds() {
        let dialect = Dialect::default();
        assert!(Dialect { registers: 3, ..dialect }.validate().is_err());
        assert!(Dialect { registers: 17, ..dialect }.validate().is_err());
        assert!(Dialect { length: 0, ..dialect }.validate().is_ok());
        assert_eq!(Dialect { length: 1025, ..dialect }.validate(), Err(DialectError::Length(1025)));
        let extended = Dialect { opcodes: OpcodeSet::Extended, ..dialect };
        assert_eq!(extended.validate(), Err(DialectError::Registers { min: 10, given: 7 }));
        assert!(Dialect { registers: 10, ..extended }.validate().is_ok());
        let directed = Dialect { opcodes: OpcodeSet::Directed, registers: 12, ..dialect };
        assert_eq!(directed.validate(), Err(DialectError::Directed));
        assert_eq!(directed.validate_painted(), Ok(()));
        let few = Dialect { registers: 11, ..directed };
        assert_eq!(few.validate_painted(), Err(DialectError::Registers { min: 12, given: 11 }));
    }
}
