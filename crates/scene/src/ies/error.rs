//! Why bytes are not a photometric profile.

/// What is wrong, and where.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("line {line}: {kind}")]
pub struct IesError {
    /// The line, counted from 1.
    pub line: usize,
    /// What is wrong with it.
    pub kind: IesErrorKind,
}

/// What can be wrong with a profile.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum IesErrorKind {
    /// There is no line that begins with `TILT=`.
    #[error("there is no line TILT=")]
    NoTilt,
    /// The tilt is in another file.
    #[error("the tilt is neither NONE nor INCLUDE; files that name another one are not read")]
    TiltFile,
    /// The file ends before this.
    #[error("the file ends before {0}")]
    Ends(&'static str),
    /// Not a number, or one that is not finite.
    #[error("{what} is no number: {text:?}")]
    Number {
        /// Which number.
        what: &'static str,
        /// At most 32 characters of what is there.
        text: String,
    },
    /// A number of a meaning that has no such value.
    #[error("{what} cannot be {value}")]
    Value {
        /// Which number.
        what: &'static str,
        /// Its value.
        value: f64,
    },
    /// Angles that do not ascend or are out of range.
    #[error("{0} angles must ascend within the range of their type")]
    Angles(&'static str),
    /// Horizontal angles of type C that end where no symmetry has its border.
    #[error("horizontal angles of type C must go from 0 to 90, 180 or 360, or from 90 to 270")]
    Symmetry,
}
