//! Identity of a program.

use std::fmt;

use crate::Program;

/// BLAKE3 hash of the packed words. Genomes with the same program hash are neutral twins: they have
/// the same reflectance everywhere.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct ProgramHash([u8; 32]);

impl ProgramHash {
    /// Returns the 32 bytes.
    #[must_use]
    pub fn as_bytes(&self) -> &[u8; 32] {
        &self.0
    }

    /// Creates a hash from its bytes.
    #[must_use]
    pub fn from_bytes(bytes: [u8; 32]) -> Self {
        Self(bytes)
    }
}

impl fmt::Display for ProgramHash {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.iter().try_for_each(|byte| write!(f, "{byte:02x}"))
    }
}

impl Program {
    /// Returns the identity of the program.
    #[must_use]
    pub fn hash(&self) -> ProgramHash {
        ProgramHash(*blake3::hash(bytemuck::cast_slice(&self.little_endian_words())).as_bytes())
    }

    fn little_endian_words(&self) -> Vec<u32> {
        self.to_words().into_iter().map(u32::to_le).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hash_is_shown_as_64_hexadecimal_digits() {
        let mut bytes = [0; 32];
        (bytes[0], bytes[31]) = (0x0a, 0xff);
        let text = ProgramHash::from_bytes(bytes).to_string();
        assert_eq!(text, format!("0a{}ff", "00".repeat(30)));
    }
}
