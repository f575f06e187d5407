//! Identity of a program.

use crate::Program;

brood_genome::content_hash! {
    /// BLAKE3 hash of the packed words. Genomes with the same program hash are neutral twins: they
    /// have the same reflectance everywhere.
    ProgramHash
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
