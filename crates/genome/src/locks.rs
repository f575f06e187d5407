//! Locks: parts of the first parent that its children keep whatever is drawn.

use serde::{Deserialize, Serialize};

use crate::liveness::walk_back;
use crate::{CONSTANTS, Dialect, Genome, Instruction, REGISTERS};

/// A result of a genome, before the colour matrix.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum Channel {
    /// g of red.
    #[serde(rename = "r")]
    Red,
    /// g of green.
    #[serde(rename = "g")]
    Green,
    /// g of blue.
    #[serde(rename = "b")]
    Blue,
}

/// What breeding must not touch.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Locks {
    /// Positions of instructions that stay as they are.
    pub instructions: Vec<u16>,
    /// Constant registers whose values stay.
    pub constants: Vec<u8>,
    /// Channels that stay the same function of the inputs: the instructions that they depend on stay, with the constants
    /// these read, and no other instruction comes to write what they still need.
    pub channels: Vec<Channel>,
}

/// Why locks name nothing.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum LocksError {
    /// A position that no genome of the dialect has.
    #[error(
        "there is no instruction {given}: a genome of the dialect has {length}, counted from 0"
    )]
    Instruction {
        /// Where in the list.
        at: usize,
        /// As given.
        given: u16,
        /// The dialect's length.
        length: u16,
    },
    /// A register that no genome has.
    #[error("there is no constant C{given}: constants are 0 to 127")]
    Constant {
        /// Where in the list.
        at: usize,
        /// As given.
        given: u8,
    },
}

impl LocksError {
    /// JSON pointer to what is wrong, within the locks.
    #[must_use]
    pub fn pointer(&self) -> String {
        match self {
            Self::Instruction { at, .. } => format!("/instructions/{at}"),
            Self::Constant { at, .. } => format!("/constants/{at}"),
        }
    }
}

impl Locks {
    /// Whether nothing is locked.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.instructions.is_empty() && self.constants.is_empty() && self.channels.is_empty()
    }

    /// Checks that what is named is there in genomes of the dialect.
    pub fn validate(&self, dialect: &Dialect) -> Result<(), LocksError> {
        let length = dialect.length;
        let beyond = self.instructions.iter().enumerate().find(|(_, given)| **given >= length);
        if let Some((at, given)) = beyond {
            return Err(LocksError::Instruction { at, given: *given, length });
        }
        let known = |given: u8| usize::from(given) < CONSTANTS;
        match self.constants.iter().enumerate().find(|(_, given)| !known(**given)) {
            Some((at, given)) => Err(LocksError::Constant { at, given: *given }),
            None => Ok(()),
        }
    }
}

/// Locks resolved for one parent.
pub(crate) struct Held {
    instructions: Vec<bool>,
    constants: [bool; CONSTANTS],
    /// For each position, what locked channels read after it of each register; nothing where no channel is locked.
    needed: Vec<[u8; REGISTERS]>,
}

impl Held {
    /// Nothing is held.
    pub(crate) fn nothing(length: usize) -> Self {
        Self {
            instructions: vec![false; length],
            constants: [false; CONSTANTS],
            needed: Vec::new(),
        }
    }

    /// # Domain
    /// Locks that [`Locks::validate`] accepts for the parent's dialect.
    pub(crate) fn of(parent: &Genome, locks: &Locks) -> Self {
        let instructions = parent.instructions();
        let mut held = Self::nothing(instructions.len());
        for index in &locks.instructions {
            held.instructions[usize::from(*index)] = true;
        }
        for index in &locks.constants {
            held.constants[usize::from(*index)] = true;
        }
        let result = locks.channels.iter().fold(0, |mask, channel| mask | 1 << *channel as u8);
        if result == 0 {
            return held;
        }
        held.needed = vec![[0; REGISTERS]; instructions.len()];
        walk_back(instructions, result, |index, live, wanted| {
            held.needed[index].copy_from_slice(&wanted[..REGISTERS]);
            if live != 0 {
                held.instructions[index] = true;
                if let Some(constant) = instructions[index].constant() {
                    held.constants[usize::from(constant)] = true;
                }
            }
        });
        held
    }

    /// Whether the instruction at a position stays.
    pub(crate) fn instruction(&self, position: usize) -> bool {
        self.instructions[position]
    }

    /// Whether a constant register stays.
    pub(crate) fn constant(&self, index: usize) -> bool {
        self.constants[index]
    }

    /// Whether the parent's instruction at a position may give way to another one.
    pub(crate) fn allows(&self, position: usize, other: &Instruction) -> bool {
        let needed = self.needed.get(position);
        let touched = needed.map_or(0, |needed| needed[usize::from(other.dst())]);
        !self.instructions[position] && other.write_mask().bits() & touched == 0
    }
}

#[cfg(test)]
#[path = "locks_tests.rs"]
mod tests;
