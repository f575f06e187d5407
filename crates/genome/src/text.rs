//! Text form of a genome: an assembly listing that round-trips to the same bits. docs/guide.md has
//! an annotated example.

mod cursor;
mod effect;
mod parse;
mod write;

pub(crate) use parse::{parse_destination, parse_operand};
#[cfg(test)]
pub(crate) use write::number;

/// Error of parsing a genome text. Lines and columns count from 1, columns in characters.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("line {line}, column {column}: {reason}")]
pub struct TextError {
    /// Line.
    pub line: u32,
    /// Column of the offending word.
    pub column: u32,
    /// Description of the error.
    pub reason: String,
}

#[cfg(test)]
#[path = "text_tests.rs"]
mod tests;
