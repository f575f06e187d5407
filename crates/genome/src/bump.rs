//! Bumps: heights over the texture, by a program of their own.

use crate::{
    CONSTANTS, Dialect, Genome, GenomeError, Instruction, OpcodeSet, Output, Parametrisation,
};

/// Largest number of instructions of the program of bumps.
pub const BUMP_LENGTH_MAX: usize = 64;

/// Largest magnitude of the strength of bumps.
pub const BUMP_STRENGTH_MAX: f32 = 16.0;

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
        let dialect = Self::dialect(length);
        let program =
            Genome::of_surface((dialect, instructions, constants), Output::IDENTITY)?;
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
