//! Wavefront OBJ files, from bytes to a mesh.
//!
//! Owns the grammar, its limits and its line numbers. Refuses to open anything: `mtllib` is named in a warning and
//! that is all. What a mesh lacks is filled in by the mesh module.

mod error;
mod face;
mod join;
mod line;
mod number;
mod polygon;
mod reader;
#[cfg(test)]
mod tests;
mod warning;

pub use error::{ObjError, ObjErrorKind};
pub use warning::ObjWarning;

use crate::Mesh;
use join::join;
use reader::read;
use warning::Warnings;

/// What a file may hold at most; beyond it the file is refused.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ObjLimits {
    /// Length of the file.
    pub bytes: usize,
    /// `v`, `vt` and `vn` lines each, and vertices after joining equal corners.
    pub vertices: usize,
    /// Triangles after cutting polygons.
    pub triangles: usize,
    /// Corners of one polygon.
    pub polygon_corners: usize,
}

impl Default for ObjLimits {
    fn default() -> Self {
        Self { bytes: 32 << 20, vertices: 2_000_000, triangles: 2_000_000, polygon_corners: 1000 }
    }
}

/// A file that was understood.
#[derive(Debug, Clone, PartialEq)]
pub struct ObjFile {
    /// The mesh.
    pub mesh: Mesh,
    /// What was odd in it, in the order of lines.
    pub warnings: Vec<ObjWarning>,
}

/// Reads a file: `v`, `vt`, `vn` and `f` with all forms of indices; other statements are ignored, with a warning
/// where something is lost.
///
/// # Domain
/// Any bytes, UTF-8 or not. Polygons are cut into triangles, concave ones too. Corners of equal indices become one
/// vertex. Missing normals become smooth ones per place; missing texture positions are 0.
///
/// # Error
/// The first malformed line, a limit passed, or a file without any face (with its last line).
pub fn parse_obj(bytes: &[u8], limits: &ObjLimits) -> Result<ObjFile, ObjError> {
    if bytes.len() > limits.bytes {
        return Err(ObjErrorKind::TooManyBytes { limit: limits.bytes }.at(1));
    }
    let mut warnings = Warnings::default();
    let records = read(bytes, limits, &mut warnings)?;
    let last_line = records.last_line;
    let raw = join(records, limits)?;
    let (parts, guesses) = crate::mesh::assemble(raw);
    warnings.guesses(&guesses, parts.has_uv, last_line);
    let mesh = Mesh::from_parts(parts).map_err(|error| ObjErrorKind::Mesh(error).at(last_line))?;
    Ok(ObjFile { mesh, warnings: warnings.into_list() })
}
