//! From triangles with some of their data missing to the complete arrays of a mesh.

use glam::{DVec2, DVec3};

use super::MeshParts;
use super::normal::{face_normal, smooth_normals};
use super::tangent::tangents;

/// Vertices as a file gives them.
///
/// # Shapes
/// `positions`, `normals`, `uvs` and `smooth_group` per vertex.
pub(crate) struct RawMesh {
    /// Positions.
    pub positions: Vec<DVec3>,
    /// Normals of any length; `None` or zero where a smooth one is to be made.
    pub normals: Vec<Option<DVec3>>,
    /// Texture positions.
    pub uvs: Vec<Option<DVec2>>,
    /// Vertices of one number share one smooth normal; numbers are below `smooth_groups`.
    pub smooth_group: Vec<u32>,
    /// Number of groups.
    pub smooth_groups: usize,
    /// Corners.
    pub triangles: Vec<[u32; 3]>,
}

/// What had to be guessed.
#[derive(Debug, Default, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Guesses {
    /// Triangles without an area.
    pub empty_triangles: usize,
    /// Vertices whose given normal was zero.
    pub zero_normals: usize,
    /// Smooth normals that the faces around do not determine.
    pub normals: usize,
    /// Vertices without texture position, where others have one.
    pub uvs: usize,
    /// Vertices with a texture position whose tangent is the fixed one.
    pub tangents: usize,
}

/// Fills in normals, texture positions and tangents.
pub(crate) fn assemble(raw: RawMesh) -> (MeshParts, Guesses) {
    let RawMesh { positions, normals, uvs, smooth_group, smooth_groups, triangles } = raw;
    let has_area =
        |triangle: &[u32; 3]| face_normal(triangle.map(|k| positions[k as usize])).is_some();
    let mut guesses = Guesses {
        empty_triangles: triangles.iter().filter(|triangle| !has_area(triangle)).count(),
        zero_normals: normals.iter().flatten().filter(|n| n.length() == 0.0).count(),
        ..Guesses::default()
    };
    let unit = |n: DVec3| (n.length() > 0.0).then(|| n / n.length());
    let given: Vec<Option<DVec3>> = normals.into_iter().map(|n| n.and_then(unit)).collect();
    let normals = if given.iter().all(Option::is_some) {
        given.into_iter().flatten().collect()
    } else {
        let (smooth, guessed) =
            grouped_normals(&positions, &triangles, &smooth_group, smooth_groups);
        guesses.normals = guessed;
        let group = smooth_group.iter().map(|group| smooth[*group as usize]);
        given.into_iter().zip(group).map(|(n, smooth)| n.unwrap_or(smooth)).collect::<Vec<_>>()
    };
    let with_uv = uvs.iter().flatten().count();
    let has_uv = with_uv > 0;
    let complete: Vec<DVec2> = uvs.iter().map(|uv| uv.unwrap_or(DVec2::ZERO)).collect();
    let (tangents, fixed) = tangents(&positions, &normals, &complete, &triangles);
    if has_uv {
        guesses.uvs = uvs.len() - with_uv;
        guesses.tangents = fixed;
    }
    (MeshParts { positions, normals, uvs: complete, tangents, triangles, has_uv }, guesses)
}

/// Smooth normals of the groups: each triangle counts at the groups of its corners.
fn grouped_normals(
    positions: &[DVec3],
    triangles: &[[u32; 3]],
    smooth_group: &[u32],
    smooth_groups: usize,
) -> (Vec<DVec3>, usize) {
    let mut place = vec![DVec3::ZERO; smooth_groups];
    for (position, group) in positions.iter().zip(smooth_group) {
        place[*group as usize] = *position;
    }
    let grouped: Vec<[u32; 3]> =
        triangles.iter().map(|triangle| triangle.map(|k| smooth_group[k as usize])).collect();
    smooth_normals(&place, &grouped)
}
