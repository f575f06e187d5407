//! Errors of the OBJ parser.

use crate::mesh::MeshError;

/// Error of [`parse_obj`](crate::parse_obj) with its line.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("line {line}: {kind}")]
pub struct ObjError {
    /// Line of the file, from 1.
    pub line: u32,
    /// Kind of error.
    pub kind: ObjErrorKind,
}

/// Kind of error in an OBJ file. Messages never quote the file.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum ObjErrorKind {
    /// The file is longer than allowed.
    #[error("the file is longer than {limit} bytes")]
    TooManyBytes {
        /// The limit.
        limit: usize,
    },
    /// More statements or vertices than allowed.
    #[error("more than {limit} {what}")]
    TooMany {
        /// Name of the counted items.
        what: &'static str,
        /// The limit.
        limit: usize,
    },
    /// A statement has too few numbers.
    #[error("{what}: expected at least {needed} numbers")]
    MissingNumber {
        /// Name of the statement or coordinate.
        what: &'static str,
        /// Number of values that the statement needs.
        needed: usize,
    },
    /// A word is not a number.
    #[error("{what} is not a number")]
    NotANumber {
        /// Name of the statement or coordinate.
        what: &'static str,
    },
    /// A number is NaN, infinite or beyond the range of 32-bit floats.
    #[error("{what} is not a finite number")]
    NotFinite {
        /// Name of the statement or coordinate.
        what: &'static str,
    },
    /// A corner does not have the form v, v/t, v//n or v/t/n.
    #[error("face corner must have the form v, v/t, v//n or v/t/n")]
    MalformedCorner,
    /// A face has fewer than three corners.
    #[error("face must have at least 3 corners")]
    TooFewCorners,
    /// An index is 0.
    #[error("{what} index is 0; indices start at 1, or at -1 counting backwards")]
    ZeroIndex {
        /// Kind of index.
        what: &'static str,
    },
    /// An index refers to no vertex, texture position or normal.
    #[error("{what} index is out of range")]
    IndexOutOfRange {
        /// Kind of index.
        what: &'static str,
    },
    /// The concave faces take too long to triangulate.
    #[error("the concave faces up to this line take too long to triangulate")]
    TooComplicated,
    /// The file has no face.
    #[error("the file has no face")]
    NoFace,
    /// The parsed arrays are not a valid mesh.
    #[error("{0}")]
    Mesh(MeshError),
}

impl ObjErrorKind {
    /// Returns the error of this kind at a line.
    pub(super) fn at(self, line: u32) -> ObjError {
        ObjError { line, kind: self }
    }
}
