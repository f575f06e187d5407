//! Smooth vertex normals from the adjacent faces, weighted by corner angle.

use glam::DVec3;

/// Length of a sum of weighted normals, relative to the sum of weights, below which the normals
/// cancel.
const CANCELLED: f64 = 1e-6;

/// Returns unit normals of all vertices and the number of vertices that their faces do not
/// determine.
///
/// # Domain
/// Coordinates within the range of f32, valid vertex indices. Faces without area do not contribute.
/// If the faces of a vertex cancel, the normal of the first is returned; if no face has an area,
/// +y.
///
/// # Source
/// Thürmer and Wüthrich 1998, *Computing vertex normals from polygonal facets*: weights are corner
/// angles, so the triangulation of a polygon does not matter.
pub(crate) fn smooth_normals(positions: &[DVec3], triangles: &[[u32; 3]]) -> (Vec<DVec3>, usize) {
    let mut sums = vec![(DVec3::ZERO, 0.0, None); positions.len()];
    for triangle in triangles {
        let corners = triangle.map(|corner| positions[corner as usize]);
        let Some(n) = face_normal(corners) else { continue };
        for (k, &vertex) in triangle.iter().enumerate() {
            let (a, b) = (corners[(k + 1) % 3] - corners[k], corners[(k + 2) % 3] - corners[k]);
            let angle = libm::atan2(a.cross(b).length(), a.dot(b));
            let (sum, weight, first) = &mut sums[vertex as usize];
            *sum += n * angle;
            *weight += angle;
            first.get_or_insert(n);
        }
    }
    let mut undetermined = 0;
    let normals = sums
        .into_iter()
        .map(|(sum, weight, first)| {
            if sum.length() > CANCELLED * weight {
                return sum / sum.length();
            }
            undetermined += 1;
            first.unwrap_or(DVec3::Y)
        })
        .collect();
    (normals, undetermined)
}

/// Unit normal of a counter-clockwise triangle, or `None` if it has no area.
pub(crate) fn face_normal([a, b, c]: [DVec3; 3]) -> Option<DVec3> {
    let cross = (b - a).cross(c - a);
    let length = cross.length();
    (length > 0.0).then(|| cross / length)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn normal_is_independent_of_the_triangulation_of_a_square() {
        // Corner of a cube: three squares, each cut along one or the other diagonal.
        let p = [
            DVec3::ZERO,
            DVec3::X,
            DVec3::Y,
            DVec3::Z,
            DVec3::new(1.0, 1.0, 0.0),
            DVec3::new(0.0, 1.0, 1.0),
            DVec3::new(1.0, 0.0, 1.0),
        ];
        let through_corner = [[0, 4, 1], [0, 2, 4], [0, 5, 2], [0, 3, 5], [0, 1, 6], [0, 6, 3]];
        let across = [[0, 2, 1], [1, 2, 4], [0, 3, 2], [2, 3, 5], [0, 1, 3], [1, 6, 3]];
        let expected = -DVec3::ONE.normalize();
        for triangles in [through_corner, across] {
            let (normals, undetermined) = smooth_normals(&p, &triangles);
            assert!((normals[0] - expected).length() < 1e-12, "{}", normals[0]);
            assert_eq!(undetermined, 0);
        }
    }

    #[test]
    fn normal_is_that_of_the_first_face_when_faces_cancel() {
        let p = [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::ONE];
        let (normals, undetermined) = smooth_normals(&p, &[[0, 1, 2], [0, 2, 1], [0, 0, 1]]);
        assert_eq!(normals, [DVec3::Z, DVec3::Z, DVec3::Z, DVec3::Y]);
        assert_eq!(undetermined, 4);
    }
}
