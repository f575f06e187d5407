//! Why an OBJ file is refused, and at which line.

use crate::mesh::MeshError;

/// A reason with its line.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("line {line}: {kind}")]
pub struct ObjError {
    /// Line of the file, from 1.
    pub line: u32,
    /// What is wrong there.
    pub kind: ObjErrorKind,
}

/// What is wrong with a line. Texts never quote the file.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum ObjErrorKind {
    /// The file is longer than allowed.
    #[error("the file is over {limit} bytes")]
    TooManyBytes {
        /// The limit.
        limit: usize,
    },
    /// More statements or vertices than allowed.
    #[error("more than {limit} {what}")]
    TooMany {
        /// Of what.
        what: &'static str,
        /// The limit.
        limit: usize,
    },
    /// Fewer numbers than the statement needs.
    #[error("{what}: {needed} numbers are needed")]
    MissingNumber {
        /// The statement.
        what: &'static str,
        /// How many.
        needed: usize,
    },
    /// A word where a number is due.
    #[error("{what} is not a number")]
    NotANumber {
        /// The statement.
        what: &'static str,
    },
    /// NaN, an infinity or beyond the range of 32-bit floats.
    #[error("{what} is not a finite number")]
    NotFinite {
        /// The statement.
        what: &'static str,
    },
    /// A corner that is not of the form v, v/t, v//n or v/t/n.
    #[error("face corner is not of the form v, v/t, v//n or v/t/n")]
    MalformedCorner,
    /// Fewer than three corners.
    #[error("face has fewer than 3 corners")]
    TooFewCorners,
    /// Indices count from 1, or from -1 backwards.
    #[error("{what} index is 0")]
    ZeroIndex {
        /// Of what.
        what: &'static str,
    },
    /// No such vertex, texture position or normal.
    #[error("{what} index is out of range")]
    IndexOutOfRange {
        /// Of what.
        what: &'static str,
    },
    /// Concave faces that would take too long to cut into triangles.
    #[error("the concave faces up to here take too long to cut into triangles")]
    TooComplicated,
    /// Nothing to show.
    #[error("the file has no face")]
    NoFace,
    /// What came out is not a mesh.
    #[error("{0}")]
    Mesh(MeshError),
}

impl ObjErrorKind {
    pub(super) fn at(self, line: u32) -> ObjError {
        ObjError { line, kind: self }
    }
}
