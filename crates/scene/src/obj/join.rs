//! Joins the corners of polygons into vertices, one per (v, vt, vn), and cuts polygons into triangles.

use std::collections::HashMap;

use glam::DVec3;

use super::face::{ABSENT, Corner};
use super::polygon::{TESTS_MAX, cut};
use super::reader::Records;
use super::{ObjError, ObjErrorKind, ObjLimits};
use crate::mesh::RawMesh;

/// The mesh of checked records; vertices are in the order of their first corner.
pub(super) fn join(records: Records, limits: &ObjLimits) -> Result<RawMesh, ObjError> {
    let mut raw = RawMesh {
        positions: Vec::new(),
        normals: Vec::new(),
        uvs: Vec::new(),
        smooth_group: Vec::new(),
        smooth_groups: 0,
        triangles: Vec::new(),
    };
    let mut places = Places::default();
    let mut known: HashMap<Corner, u32> = HashMap::new();
    let (mut vertices, mut triangles) = (Vec::new(), Vec::new());
    let (mut start, mut tests_left) = (0, TESTS_MAX);
    for polygon in &records.polygons {
        let corners = &records.corners[start..polygon.end];
        start = polygon.end;
        vertices.clear();
        for corner in corners {
            let next = raw.positions.len();
            let vertex = *known.entry(*corner).or_insert_with(|| {
                raw.positions.push(records.positions[corner.v as usize]);
                raw.normals.push(given(corner.n, &records.normals));
                raw.uvs.push(given(corner.t, &records.uvs));
                raw.smooth_group.push(places.number(records.positions[corner.v as usize]));
                u32::try_from(next).expect("the limit of vertices is below 2^32")
            });
            vertices.push(vertex);
            if raw.positions.len() > limits.vertices.min(u32::MAX as usize) {
                let what = "vertices after joining equal corners";
                return Err(ObjErrorKind::TooMany { what, limit: limits.vertices }.at(polygon.line));
            }
        }
        triangles.clear();
        let place = |k: usize| records.positions[corners[k].v as usize];
        cut(vertices.len(), place, &mut triangles, &mut tests_left)
            .map_err(|_| ObjErrorKind::TooComplicated.at(polygon.line))?;
        raw.triangles.extend(triangles.iter().map(|t| t.map(|k: usize| vertices[k])));
    }
    raw.smooth_groups = places.0.len();
    Ok(raw)
}

/// Numbers places: many files repeat the positions along the borders of their patches, and a smooth normal must not
/// show those borders.
#[derive(Default)]
struct Places(HashMap<[u64; 3], u32>);

impl Places {
    fn number(&mut self, position: DVec3) -> u32 {
        let next = u32::try_from(self.0.len()).expect("the limit of vertices is below 2^32");
        // Adding 0 makes -0 and 0 one number.
        let bits = position.to_array().map(|coordinate| (coordinate + 0.0).to_bits());
        *self.0.entry(bits).or_insert(next)
    }
}

fn given<T: Copy>(index: u32, values: &[T]) -> Option<T> {
    (index != ABSENT).then(|| values[index as usize])
}
