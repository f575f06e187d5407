//! Arrays of a mesh.

use glam::{DVec2, DVec3};
use serde::{Deserialize, Serialize};

/// Arrays of a mesh, all per vertex except `triangles`.
///
/// # Shapes
/// `positions`, `normals`, `uvs` and `tangents` have one entry per vertex; `triangles` index them.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct MeshParts {
    /// Positions, in the mesh's own units, y up.
    pub positions: Vec<DVec3>,
    /// Unit normals.
    pub normals: Vec<DVec3>,
    /// Texture positions, v up; zero if absent.
    pub uvs: Vec<DVec2>,
    /// Unit vectors along increasing u, perpendicular to the normals.
    pub tangents: Vec<DVec3>,
    /// Vertex indices, counter-clockwise seen from outside.
    pub triangles: Vec<[u32; 3]>,
    /// True if any vertex has a texture position; otherwise u and v are 0 everywhere.
    pub has_uv: bool,
}
