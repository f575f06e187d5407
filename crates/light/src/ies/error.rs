//! Errors of the IES parser.

/// Error of [`IesProfile::parse`](crate::IesProfile::parse) with its line.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("line {line}: {kind}")]
pub struct IesError {
    /// Line of the file, from 1.
    pub line: usize,
    /// Kind of error.
    pub kind: IesErrorKind,
}

/// Kind of error in an IES file.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum IesErrorKind {
    /// No line begins with `TILT=`.
    #[error("no line begins with TILT=")]
    NoTilt,
    /// The tilt is given in another file.
    #[error("TILT must be NONE or INCLUDE; a tilt in another file is not supported")]
    TiltFile,
    /// The file ends before this value.
    #[error("the file ends before {0}")]
    Ends(&'static str),
    /// A word is not a finite number of at most 1e12.
    #[error("{what} must be a number, got {text:?}")]
    Number {
        /// Name of the value.
        what: &'static str,
        /// First 32 characters of the word.
        text: String,
    },
    /// A number is outside the domain of its field.
    #[error("{what} cannot be {value}")]
    Value {
        /// Name of the value.
        what: &'static str,
        /// Value in the file.
        value: f64,
    },
    /// Angles do not strictly ascend or are out of range.
    #[error("{0} angles must strictly ascend and stay in the range of the photometric type")]
    Angles(&'static str),
    /// Horizontal angles of type C match none of the symmetries of LM-63.
    #[error("horizontal angles of type C must go from 0 to 90, 180 or 360, or from 90 to 270")]
    Symmetry,
}
