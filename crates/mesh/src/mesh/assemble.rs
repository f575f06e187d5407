//! Completes meshes: fills in missing normals, texture positions and tangents.

use glam::{DVec2, DVec3};

use super::normal::{face_normal, smooth_normals};
use super::parts::MeshParts;
use super::tangent::tangents;

/// Vertices and triangles as read from a file, with optional normals and texture positions.
///
/// # Shapes
/// `positions`, `normals`, `uvs` and `smooth_group` per vertex.
#[derive(Default)]
pub(crate) struct RawMesh {
    /// Positions.
    pub positions: Vec<DVec3>,
    /// Normals of any length; `None` or zero requests a smooth normal.
    pub normals: Vec<Option<DVec3>>,
    /// Texture positions.
    pub uvs: Vec<Option<DVec2>>,
    /// Group of each vertex, below `smooth_groups`; vertices of a group share one smooth normal.
    pub smooth_group: Vec<u32>,
    /// Number of smooth groups.
    pub smooth_groups: usize,
    /// Vertex indices.
    pub triangles: Vec<[u32; 3]>,
}

/// Counts of missing or degenerate data that was replaced.
#[derive(Debug, Default, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Repairs {
    /// Triangles without an area.
    pub empty_triangles: usize,
    /// Vertices with a given normal of length 0.
    pub zero_normals: usize,
    /// Smooth normals that the adjacent faces do not determine.
    pub normals: usize,
    /// Vertices without texture position in a mesh where others have one.
    pub uvs: usize,
    /// Vertices whose texture positions determine no tangent, so the fixed one is used.
    pub tangents: usize,
}

/// Fills in normals, texture positions and tangents.
pub(crate) fn assemble(raw: RawMesh) -> (MeshParts, Repairs) {
    let RawMesh { positions, normals, uvs, smooth_group, smooth_groups, triangles } = raw;
    let has_area =
        |triangle: &[u32; 3]| face_normal(triangle.map(|k| positions[k as usize])).is_some();
    let mut repairs = Repairs {
        empty_triangles: triangles.iter().filter(|triangle| !has_area(triangle)).count(),
        zero_normals: normals.iter().flatten().filter(|n| n.length() == 0.0).count(),
        ..Repairs::default()
    };
    let unit = |n: DVec3| (n.length() > 0.0).then(|| n / n.length());
    let given: Vec<Option<DVec3>> = normals.into_iter().map(|n| n.and_then(unit)).collect();
    let normals = if given.iter().all(Option::is_some) {
        given.into_iter().flatten().collect()
    } else {
        let (smooth, undetermined) =
            grouped_normals(&positions, &triangles, &smooth_group, smooth_groups);
        repairs.normals = undetermined;
        let group = smooth_group.iter().map(|group| smooth[*group as usize]);
        given.into_iter().zip(group).map(|(n, smooth)| n.unwrap_or(smooth)).collect::<Vec<_>>()
    };
    let with_uv = uvs.iter().flatten().count();
    let has_uv = with_uv > 0;
    let complete: Vec<DVec2> = uvs.iter().map(|uv| uv.unwrap_or(DVec2::ZERO)).collect();
    let (tangents, fixed) = tangents(&positions, &normals, &complete, &triangles);
    if has_uv {
        repairs.uvs = uvs.len() - with_uv;
        repairs.tangents = fixed;
    }
    (MeshParts { positions, normals, uvs: complete, tangents, triangles, has_uv }, repairs)
}

/// Returns the smooth normal of each group and the number of undetermined ones. Each triangle
/// contributes to the groups of its corners.
fn grouped_normals(
    positions: &[DVec3],
    triangles: &[[u32; 3]],
    smooth_group: &[u32],
    smooth_groups: usize,
) -> (Vec<DVec3>, usize) {
    let mut group_positions = vec![DVec3::ZERO; smooth_groups];
    for (position, group) in positions.iter().zip(smooth_group) {
        group_positions[*group as usize] = *position;
    }
    let grouped: Vec<[u32; 3]> =
        triangles.iter().map(|triangle| triangle.map(|k| smooth_group[k as usize])).collect();
    smooth_normals(&group_positions, &grouped)
}
