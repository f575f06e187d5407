//! The text form of a genome: an assembly listing that reads back to the same genome, bit for bit.

mod cursor;
mod parse;
mod write;

pub(crate) use parse::{parse_destination, parse_operand};
#[cfg(test)]
pub(crate) use write::number;

/// What is wrong with a genome text, and where (both counted from 1, columns in characters).
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("line {line}, column {column}: {reason}")]
pub struct TextError {
    /// Line.
    pub line: u32,
    /// Column of the offending word.
    pub column: u32,
    /// What is wrong.
    pub reason: String,
}

#[cfg(test)]
#[path = "text_tests.rs"]
mod tests;
