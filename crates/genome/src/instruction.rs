//! One instruction and the rules that hold for every instruction of every dialect.

use std::fmt;

use crate::{CONSTANTS, Dialect, Opcode, OpcodeSet, Operand, Register, WriteMask};

/// Opcode, destination register with write mask, operands. Validated: see [`Instruction::new`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Instruction {
    opcode: Opcode,
    dst: u8,
    write_mask: WriteMask,
    src: [Option<Operand>; 3],
}

/// Why an instruction is not valid.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum InstructionError {
    /// Too few or too many operands.
    #[error("{} takes {} operand(s), not {given}", opcode.name(), opcode.operands())]
    OperandCount {
        /// The opcode.
        opcode: Opcode,
        /// How many were given.
        given: usize,
    },
    /// The opcode belongs to the extended dialect.
    #[error("{} belongs to the extended dialect", .0.name())]
    NotInDialect(Opcode),
    /// A temporary register that the dialect does not have.
    #[error("R{index} does not exist in a dialect of {registers} registers")]
    NoSuchTemporary {
        /// The register.
        index: u8,
        /// How many there are.
        registers: u8,
    },
    /// A constant register beyond C127.
    #[error("C{0} does not exist: constants are C0 to C127")]
    NoSuchConstant(u8),
    /// More than one distinct constant register.
    #[error("an instruction may read one constant register, not both C{0} and C{1}")]
    TwoConstants(u8, u8),
    /// SIN, COS and the other scalar opcodes read one component.
    #[error("{} reads one component: write exactly one swizzle letter", .0.name())]
    NotScalar(Opcode),
}

impl Instruction {
    /// Checks operand count, registers against the dialect, the one-constant rule and scalar swizzles.
    pub fn new(
        opcode: Opcode,
        dst: u8,
        write_mask: WriteMask,
        operands: &[Operand],
        dialect: &Dialect,
    ) -> Result<Self, InstructionError> {
        if usize::from(opcode.number()) >= Opcode::PAPER && dialect.opcodes == OpcodeSet::Paper {
            return Err(InstructionError::NotInDialect(opcode));
        }
        if operands.len() != opcode.operands() {
            return Err(InstructionError::OperandCount { opcode, given: operands.len() });
        }
        let registers = dialect.registers;
        if dst >= registers {
            return Err(InstructionError::NoSuchTemporary { index: dst, registers });
        }
        let mut constant = None;
        for operand in operands {
            match operand.register {
                Register::Temporary(index) if index >= registers => {
                    return Err(InstructionError::NoSuchTemporary { index, registers });
                }
                Register::Temporary(_) => {}
                Register::Constant(index) if usize::from(index) >= CONSTANTS => {
                    return Err(InstructionError::NoSuchConstant(index));
                }
                Register::Constant(index) => match constant {
                    Some(other) if other != index => {
                        return Err(InstructionError::TwoConstants(other, index));
                    }
                    _ => constant = Some(index),
                },
            }
            if opcode.is_scalar() && !operand.swizzle.is_splat() {
                return Err(InstructionError::NotScalar(opcode));
            }
        }
        let mut src = [None; 3];
        for (slot, operand) in src.iter_mut().zip(operands) {
            *slot = Some(*operand);
        }
        Ok(Self { opcode, dst, write_mask, src })
    }

    /// What it does.
    #[inline]
    #[must_use]
    pub fn opcode(&self) -> Opcode {
        self.opcode
    }

    /// The temporary register it writes.
    #[inline]
    #[must_use]
    pub fn dst(&self) -> u8 {
        self.dst
    }

    /// The components it writes.
    #[inline]
    #[must_use]
    pub fn write_mask(&self) -> WriteMask {
        self.write_mask
    }

    /// Its operands, as many as the opcode takes.
    #[inline]
    pub fn operands(&self) -> impl Iterator<Item = Operand> + '_ {
        self.src.iter().flatten().copied()
    }

    /// Operand 0..3.
    ///
    /// # Panics
    /// Where the opcode takes fewer: the caller matches on the opcode first.
    #[inline]
    #[must_use]
    pub fn operand(&self, index: usize) -> Operand {
        self.src[index].expect("the opcode takes that many operands")
    }

    /// The constant register it reads, if any.
    #[must_use]
    pub fn constant(&self) -> Option<u8> {
        self.operands().find_map(|operand| match operand.register {
            Register::Constant(index) => Some(index),
            Register::Temporary(_) => None,
        })
    }
}

impl fmt::Display for Instruction {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} R{}{}", self.opcode.name(), self.dst, self.write_mask)?;
        self.operands().try_for_each(|operand| {
            // One place of the identity never stands for a scalar operand: splats print their letter.
            write!(f, ", {operand}")
        })
    }
}
