//! An instruction and the rules that every instruction of every dialect follows.

use std::fmt;

use crate::{CONSTANTS, Dialect, Opcode, OpcodeSet, Operand, Register, WriteMask};

/// An instruction: opcode, destination register with write mask, operands. Validated by
/// [`Instruction::new`]. Reads at most one constant register, as in the paper.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Instruction {
    opcode: Opcode,
    dst: u8,
    write_mask: WriteMask,
    src: [Option<Operand>; 3],
}

/// Error of [`Instruction::new`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum InstructionError {
    /// The opcode takes another number of operands.
    #[error("{} takes {} operand(s), got {given}", opcode.name(), opcode.operands())]
    OperandCount {
        /// The opcode.
        opcode: Opcode,
        /// Number of operands that were given.
        given: usize,
    },
    /// The opcode is in the extended dialect only.
    #[error("{} belongs to the extended dialect", .0.name())]
    NotInDialect(Opcode),
    /// The dialect has no such temporary register.
    #[error("R{index} does not exist in a dialect of {registers} registers")]
    NoSuchTemporary {
        /// Index of the register.
        index: u8,
        /// Number of registers of the dialect.
        registers: u8,
    },
    /// The constant register is beyond C127.
    #[error("C{0} does not exist: constants are C0 to C127")]
    NoSuchConstant(u8),
    /// The operands read two different constant registers.
    #[error("an instruction can read one constant register, not both C{0} and C{1}")]
    TwoConstants(u8, u8),
    /// A scalar opcode (SIN, COS, ...) has an operand with several components.
    #[error("{} reads one component: write exactly one swizzle letter", .0.name())]
    NotScalar(Opcode),
}

impl Instruction {
    /// Creates an instruction. Checks the number of operands, the registers of the dialect, the
    /// limit of one constant register, and the swizzles of scalar opcodes.
    ///
    /// # Errors
    /// Returns [`InstructionError`] with the rule that is violated.
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

    /// Operation of the instruction.
    #[inline]
    #[must_use]
    pub fn opcode(&self) -> Opcode {
        self.opcode
    }

    /// Temporary register that it writes.
    #[inline]
    #[must_use]
    pub fn dst(&self) -> u8 {
        self.dst
    }

    /// Components that it writes.
    #[inline]
    #[must_use]
    pub fn write_mask(&self) -> WriteMask {
        self.write_mask
    }

    /// Operands, as many as the opcode takes.
    #[inline]
    pub fn operands(&self) -> impl Iterator<Item = Operand> + '_ {
        self.src.iter().flatten().copied()
    }

    /// Operand `index`.
    ///
    /// # Panics
    /// If the opcode takes fewer operands; callers match on the opcode first.
    #[inline]
    #[must_use]
    pub fn operand(&self, index: usize) -> Operand {
        self.src[index].expect("the opcode takes that many operands")
    }

    /// Constant register that it reads, if any.
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
            // A scalar operand always has a splat swizzle, which prints its letter; an identity
            // swizzle prints none.
            write!(f, ", {operand}")
        })
    }
}
