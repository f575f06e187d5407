//! Validated triangle meshes with a normal, a texture position and a tangent per vertex.
//!
//! Validity is checked in the constructor and on deserialisation, so later code cannot meet a NaN
//! or an index out of range. Meshes are stored as given, not normalised in size. Independent of
//! file formats and cameras.

mod assemble;
mod ball;
mod builtin;
mod normal;
mod parts;
mod revolution;
mod tangent;
#[cfg(test)]
mod tests;

use std::sync::{Arc, OnceLock};

use glam::DVec3;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

pub(crate) use assemble::{RawMesh, Repairs, assemble};
pub use builtin::{BuiltinMesh, GROUND_RADII};
pub use parts::MeshParts;
pub use tangent::fixed_tangent;

use crate::trace::Tracer;

/// Largest absolute coordinate. Within the range of f32, squares and products stay finite in f64.
pub(crate) const COORDINATE_MAX: f64 = f32::MAX as f64;
/// Smallest radius of the bounding sphere; keeps ratios to it finite.
const RADIUS_MIN: f64 = 1e-30;
/// Tolerance on the squared length of stored normals and tangents and on their dot product.
const FRAME_TOLERANCE: f64 = 1e-6;

/// Valid mesh with its bounding sphere.
#[derive(Debug, Clone)]
pub struct Mesh {
    parts: MeshParts,
    centre: DVec3,
    radius: f64,
    /// Ray tracing structure, built at the first render.
    tracer: OnceLock<Arc<Tracer>>,
}

/// Reason why arrays are not a valid mesh.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum MeshError {
    /// The mesh has no triangle.
    #[error("the mesh has no triangle")]
    NoTriangle,
    /// All vertices are at one position.
    #[error("the mesh has no extent")]
    NoExtent,
    /// The per-vertex arrays differ in length.
    #[error("the per-vertex arrays differ in length")]
    Lengths,
    /// More than 2^32 - 1 vertices or triangles.
    #[error("the mesh has more than 2^32 - 1 vertices or triangles")]
    TooLarge,
    /// A triangle refers to a vertex that does not exist.
    #[error("triangle {0} refers to a vertex that does not exist")]
    Corner(usize),
    /// A coordinate is not finite or beyond the range of f32.
    #[error("a coordinate of vertex {0} is not finite or beyond the range of 32-bit floats")]
    NotFinite(usize),
    /// Normal and tangent are not unit vectors at a right angle.
    #[error("normal and tangent of vertex {0} are not unit vectors at a right angle")]
    Frame(usize),
}

impl Mesh {
    /// Creates a mesh from arrays, which are kept bit for bit.
    ///
    /// # Errors
    /// Returns [`MeshError`] for the first violation found.
    pub fn from_parts(parts: MeshParts) -> Result<Self, MeshError> {
        let count = parts.positions.len();
        if [parts.normals.len(), parts.uvs.len(), parts.tangents.len()] != [count; 3] {
            return Err(MeshError::Lengths);
        }
        let limit = u32::MAX as usize;
        if count > limit || parts.triangles.len() > limit {
            return Err(MeshError::TooLarge);
        }
        if parts.triangles.is_empty() {
            return Err(MeshError::NoTriangle);
        }
        let exists = |corner: &u32| (*corner as usize) < count;
        if let Some(index) = parts.triangles.iter().position(|t| !t.iter().all(exists)) {
            return Err(MeshError::Corner(index));
        }
        for vertex in 0..count {
            check_vertex(&parts, vertex)?;
        }
        let (centre, radius) = bounding_sphere(&parts.positions);
        if radius < RADIUS_MIN {
            return Err(MeshError::NoExtent);
        }
        Ok(Self { parts, centre, radius, tracer: OnceLock::new() })
    }

    /// Creates a built-in mesh.
    #[must_use]
    pub fn builtin(mesh: BuiltinMesh) -> Self {
        Self::from_parts(builtin::build(mesh)).expect("built-in meshes are valid")
    }

    /// Arrays of the mesh.
    #[must_use]
    pub fn parts(&self) -> &MeshParts {
        &self.parts
    }

    /// Number of vertices.
    #[must_use]
    pub fn vertex_count(&self) -> usize {
        self.parts.positions.len()
    }

    /// Number of triangles.
    #[must_use]
    pub fn triangle_count(&self) -> usize {
        self.parts.triangles.len()
    }

    /// True if any vertex has a texture position; otherwise u and v are 0 everywhere.
    #[must_use]
    pub fn has_uv(&self) -> bool {
        self.parts.has_uv
    }

    /// Centre of the bounding box and of the bounding sphere.
    #[must_use]
    pub fn centre(&self) -> DVec3 {
        self.centre
    }

    /// Radius of the bounding sphere: the largest distance of a vertex from the centre.
    #[must_use]
    pub fn radius(&self) -> f64 {
        self.radius
    }

    /// Hash of all arrays; meshes with bit-identical arrays have equal hashes.
    #[must_use]
    pub fn content_hash(&self) -> [u8; 32] {
        let parts = &self.parts;
        let mut hasher = blake3::Hasher::new();
        hasher.update(b"brood mesh 1\0");
        hasher.update(&[u8::from(parts.has_uv)]);
        hasher.update(&(parts.positions.len() as u64).to_le_bytes());
        hasher.update(&(parts.triangles.len() as u64).to_le_bytes());
        for vertex in 0..parts.positions.len() {
            let mut bytes = [0u8; 88];
            let coordinates = parts.positions[vertex]
                .to_array()
                .into_iter()
                .chain(parts.normals[vertex].to_array())
                .chain(parts.uvs[vertex].to_array())
                .chain(parts.tangents[vertex].to_array());
            for (slot, coordinate) in bytes.chunks_exact_mut(8).zip(coordinates) {
                slot.copy_from_slice(&coordinate.to_le_bytes());
            }
            hasher.update(&bytes);
        }
        for corner in parts.triangles.iter().flatten() {
            hasher.update(&corner.to_le_bytes());
        }
        *hasher.finalize().as_bytes()
    }

    /// Returns the ray tracing structure, built on first use.
    #[must_use]
    pub fn tracer(&self) -> &Tracer {
        self.tracer.get_or_init(|| {
            Arc::new(Tracer::new(
                &self.parts.positions,
                &self.parts.triangles,
                self.centre,
                self.radius,
            ))
        })
    }
}

impl PartialEq for Mesh {
    fn eq(&self, other: &Self) -> bool {
        self.parts == other.parts
    }
}

impl TryFrom<MeshParts> for Mesh {
    type Error = MeshError;

    fn try_from(parts: MeshParts) -> Result<Self, MeshError> {
        Self::from_parts(parts)
    }
}

impl Serialize for Mesh {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        self.parts.serialize(serializer)
    }
}

impl<'de> Deserialize<'de> for Mesh {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        Self::from_parts(MeshParts::deserialize(deserializer)?).map_err(serde::de::Error::custom)
    }
}

fn check_vertex(parts: &MeshParts, vertex: usize) -> Result<(), MeshError> {
    let in_range = |number: f64| number.abs() <= COORDINATE_MAX;
    let position = parts.positions[vertex].to_array().into_iter().all(in_range);
    if !position || !parts.uvs[vertex].to_array().into_iter().all(in_range) {
        return Err(MeshError::NotFinite(vertex));
    }
    let (n, u) = (parts.normals[vertex], parts.tangents[vertex]);
    let unit = |w: DVec3| (w.length_squared() - 1.0).abs() <= FRAME_TOLERANCE;
    // This form of the comparison rejects NaN.
    if unit(n) && unit(u) && n.dot(u).abs() <= FRAME_TOLERANCE {
        return Ok(());
    }
    Err(MeshError::Frame(vertex))
}

/// Returns the centre of the bounding box and the largest distance of a position from it.
fn bounding_sphere(positions: &[DVec3]) -> (DVec3, f64) {
    let low = positions.iter().fold(DVec3::INFINITY, |low, p| low.min(*p));
    let high = positions.iter().fold(DVec3::NEG_INFINITY, |high, p| high.max(*p));
    let centre = 0.5 * low + 0.5 * high;
    let farthest = positions.iter().fold(0.0f64, |r, p| r.max((*p - centre).length_squared()));
    (centre, farthest.sqrt())
}
