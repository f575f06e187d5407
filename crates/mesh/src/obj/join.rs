//! Joins equal polygon corners into vertices, one per (v, vt, vn), and triangulates polygons.

use std::collections::HashMap;

use glam::DVec3;

use super::face::{ABSENT, Corner};
use super::polygon::{TESTS_MAX, triangulate};
use super::reader::Records;
use super::{ObjError, ObjErrorKind, ObjLimits};
use crate::mesh::RawMesh;

/// Returns the mesh of checked records. Vertices are in the order of their first corner.
///
/// # Errors
/// Returns an error if there are too many vertices or the triangulation takes too long.
pub(super) fn join(records: Records, limits: &ObjLimits) -> Result<RawMesh, ObjError> {
    let mut raw = RawMesh::default();
    let mut position_ids = PositionIds::default();
    let mut vertex_ids: HashMap<Corner, u32> = HashMap::new();
    let (mut vertices, mut triangles) = (Vec::new(), Vec::new());
    let (mut start, mut tests_left) = (0, TESTS_MAX);
    for polygon in &records.polygons {
        let corners = &records.corners[start..polygon.end];
        start = polygon.end;
        vertices.clear();
        for corner in corners {
            let next = raw.positions.len();
            let vertex = *vertex_ids.entry(*corner).or_insert_with(|| {
                raw.positions.push(records.positions[corner.v as usize]);
                raw.normals.push(lookup(corner.n, &records.normals));
                raw.uvs.push(lookup(corner.t, &records.uvs));
                raw.smooth_group.push(position_ids.id(records.positions[corner.v as usize]));
                u32::try_from(next).expect("the limit of vertices is below 2^32")
            });
            vertices.push(vertex);
            if raw.positions.len() > limits.vertices.min(u32::MAX as usize) {
                let what = "vertices after joining equal corners";
                return Err(ObjErrorKind::TooMany { what, limit: limits.vertices }.at(polygon.line));
            }
        }
        triangles.clear();
        let position = |k: usize| records.positions[corners[k].v as usize];
        triangulate(vertices.len(), position, &mut triangles, &mut tests_left)
            .map_err(|_| ObjErrorKind::TooComplicated.at(polygon.line))?;
        raw.triangles.extend(triangles.iter().map(|t| t.map(|k: usize| vertices[k])));
    }
    raw.smooth_groups = position_ids.0.len();
    Ok(raw)
}

/// Ids of distinct positions. Many files repeat the positions along patch borders; a shared id
/// keeps smooth normals continuous across them.
#[derive(Default)]
struct PositionIds(HashMap<[u64; 3], u32>);

impl PositionIds {
    fn id(&mut self, position: DVec3) -> u32 {
        let next = u32::try_from(self.0.len()).expect("the limit of vertices is below 2^32");
        // Adding 0 maps -0 to 0.
        let bits = position.to_array().map(|coordinate| (coordinate + 0.0).to_bits());
        *self.0.entry(bits).or_insert(next)
    }
}

fn lookup<T: Copy>(index: u32, values: &[T]) -> Option<T> {
    (index != ABSENT).then(|| values[index as usize])
}
