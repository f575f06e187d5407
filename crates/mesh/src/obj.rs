//! Parser of Wavefront OBJ files, from bytes to a mesh.
//!
//! Owns the grammar, its limits and line numbers. Opens no files: `mtllib` only yields a warning.
//! The mesh module fills in missing normals, texture positions and tangents.

mod error;
mod face;
mod join;
mod limits;
mod line;
mod number;
mod polygon;
mod reader;
#[cfg(test)]
mod tests;
mod warning;

pub use error::{ObjError, ObjErrorKind};
pub use limits::ObjLimits;
pub use warning::ObjWarning;

use crate::Mesh;
use join::join;
use reader::read;
use warning::Warnings;

/// Parsed file.
#[derive(Debug, Clone, PartialEq)]
pub struct ObjFile {
    /// Mesh.
    pub mesh: Mesh,
    /// Warnings: first those of single lines in order, then those of the whole file.
    pub warnings: Vec<ObjWarning>,
}

/// Parses a file: `v`, `vt`, `vn` and `f` with all forms of indices. Other statements are ignored,
/// with a warning if data is lost.
///
/// # Domain
/// Any bytes, UTF-8 or not. Convex and concave polygons are triangulated. Corners with equal
/// indices become one vertex. Missing normals become smooth normals, shared by all vertices at one
/// position; missing texture positions are 0.
///
/// # Errors
/// Returns [`ObjError`] for the first malformed line, an exceeded limit, or a file without faces
/// (with its last line).
pub fn parse_obj(bytes: &[u8], limits: &ObjLimits) -> Result<ObjFile, ObjError> {
    if bytes.len() > limits.bytes {
        return Err(ObjErrorKind::TooManyBytes { limit: limits.bytes }.at(1));
    }
    let mut warnings = Warnings::default();
    let records = read(bytes, limits, &mut warnings)?;
    let last_line = records.last_line;
    let raw = join(records, limits)?;
    let (parts, repairs) = crate::mesh::assemble(raw);
    warnings.repairs(&repairs, parts.has_uv, last_line);
    let mesh = Mesh::from_parts(parts).map_err(|error| ObjErrorKind::Mesh(error).at(last_line))?;
    Ok(ObjFile { mesh, warnings: warnings.into_list() })
}
