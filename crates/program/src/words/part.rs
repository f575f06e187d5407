//! Parts of packed words: numbers as words, and the error of invalid ones.

/// Error of words that do not encode a program.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum WordsError {
    /// The version is unknown.
    #[error("the packed words have an unknown version")]
    Version,
    /// The length differs from that of the counts.
    #[error("the length of the packed words differs from that of their counts")]
    Length,
    /// An operand refers to nothing, or to a later step.
    #[error("the operand at word {0} refers to no input, constant or earlier step")]
    Operand(usize),
    /// The operation does not exist.
    #[error("word {0} is not the number of an operation")]
    Operation(usize),
    /// A constant or a number of the output stage is out of range.
    #[error("the number at word {0} is outside of the range of the machine")]
    Number(usize),
    /// The kind of model does not exist, or one of its numbers is invalid.
    #[error("the words from {0} on do not encode a model")]
    Model(usize),
    /// The effects do not belong together, or one of them is invalid.
    #[error("the words from {0} on do not encode an effect")]
    Effect(usize),
    /// The bumps are invalid.
    #[error("the words from {0} on do not encode bumps")]
    Bumps(usize),
}

/// Returns a length as a word.
pub(super) fn length(length: usize) -> u32 {
    u32::try_from(length).expect("a program has fewer than 65536 steps")
}

/// Returns the low and the high half of the bits of a number.
pub(super) fn halves(number: f64) -> [u32; 2] {
    let bits = number.to_bits();
    [bits & u64::from(u32::MAX), bits >> 32]
        .map(|half| u32::try_from(half).expect("half of 64 bits"))
}

/// Returns the number with these halves.
pub(super) fn joined(low: u32, high: u32) -> f64 {
    f64::from_bits(u64::from(low) | u64::from(high) << 32)
}
