//! The canonical byte encoding of a genome and the content hash over it.

use std::fmt;
use std::str::FromStr;

use crate::{Genome, OpcodeSet, Operand, Parametrisation, Register};

/// Identity of a genome: BLAKE3 over its canonical bytes. Two genomes are equal exactly where their hashes are.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct GenomeHash([u8; 32]);

/// Text that is not a hash.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("a hash is 64 hexadecimal digits")]
pub struct HashError;

impl GenomeHash {
    /// The 32 bytes.
    #[must_use]
    pub fn as_bytes(&self) -> &[u8; 32] {
        &self.0
    }

    /// A hash from its bytes.
    #[must_use]
    pub fn from_bytes(bytes: [u8; 32]) -> Self {
        Self(bytes)
    }
}

impl fmt::Display for GenomeHash {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.iter().try_for_each(|byte| write!(f, "{byte:02x}"))
    }
}

impl FromStr for GenomeHash {
    type Err = HashError;

    fn from_str(text: &str) -> Result<Self, HashError> {
        let hash = blake3::Hash::from_hex(text).map_err(|_| HashError)?;
        Ok(Self(*hash.as_bytes()))
    }
}

impl Genome {
    /// Every fact of the genome in a fixed order: dialect, instructions, constants, output stage; numbers as
    /// little-endian bits.
    #[must_use]
    pub fn canonical_bytes(&self) -> Vec<u8> {
        let mut bytes = b"brood genome 1\n".to_vec();
        let dialect = self.dialect();
        bytes.push(match dialect.opcodes {
            OpcodeSet::Paper => 0,
            OpcodeSet::Extended => 1,
        });
        bytes.push(match dialect.parametrisation {
            Parametrisation::Smooth => 0,
            Parametrisation::Paper => 1,
        });
        bytes.push(dialect.registers);
        bytes.extend(dialect.length.to_le_bytes());
        bytes.push(u8::from(dialect.isotropic) | (u8::from(dialect.homogeneous) << 1));
        for instruction in self.instructions() {
            bytes.extend([instruction.opcode().number(), instruction.dst()]);
            bytes.push(instruction.write_mask().bits());
            instruction.operands().for_each(|operand| bytes.extend(operand_bytes(operand)));
        }
        let output = self.output();
        let numbers = self.constants().iter().flatten().chain(output.matrix().iter().flatten());
        for number in numbers.chain(output.scale()).chain(output.offset()) {
            bytes.extend(number.to_bits().to_le_bytes());
        }
        bytes
    }

    /// The content hash.
    #[must_use]
    pub fn hash(&self) -> GenomeHash {
        GenomeHash(*blake3::hash(&self.canonical_bytes()).as_bytes())
    }
}

fn operand_bytes(operand: Operand) -> [u8; 3] {
    let register = match operand.register {
        Register::Temporary(index) => index,
        Register::Constant(index) => 0x80 | index,
    };
    [register, operand.swizzle.bits(), u8::from(operand.negate)]
}
