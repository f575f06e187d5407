//! Vertex tangents: the direction in which the texture coordinate u grows.
//!
//! Fits each tangent by least squares over the edges of its vertex; where the fit is singular, a
//! fixed tangent replaces it.

use glam::{DVec2, DVec3};
use rayon::prelude::*;

/// Value of 1 - r^2 below which the texture offsets of the neighbours count as collinear.
const COLLINEAR: f64 = 1e-9;
/// Length of the numerator, relative to the neighbours' distances, below which its terms count as
/// cancelled.
const CANCELLED: f64 = 1e-9;

/// Returns the tangents of all vertices and the number of fixed ones.
///
/// # Shapes
/// All slices per vertex except `triangles`; the result per vertex.
///
/// # Domain
/// Unit normals, coordinates within the range of f32, valid vertex indices. The result is always
/// unit and perpendicular to the normal: where the texture offsets of the neighbours are collinear
/// or vanish, it is [`fixed_tangent`].
///
/// # Source
/// Meyer-Spradow and Loviscach, *Evolutionary Design of BRDFs*, section 3: minimise
/// sum_k |x0 + (u_k - u0) u + (v_k - v0) b - x_k|^2 over u and b in the tangent plane, where k runs
/// over the neighbours along edges.
pub(crate) fn tangents(
    positions: &[DVec3],
    normals: &[DVec3],
    uvs: &[DVec2],
    triangles: &[[u32; 3]],
) -> (Vec<DVec3>, usize) {
    let edges = directed_edges(triangles);
    let starts: Vec<usize> = (0..=positions.len())
        .into_par_iter()
        .map(|vertex| edges.partition_point(|edge| (edge.0 as usize) < vertex))
        .collect();
    let fitted: Vec<Option<DVec3>> = (0..positions.len())
        .into_par_iter()
        .map(|vertex| {
            let neighbours = &edges[starts[vertex]..starts[vertex + 1]];
            let offsets = neighbours.iter().map(|edge| {
                let k = edge.1 as usize;
                (uvs[k] - uvs[vertex], positions[k] - positions[vertex])
            });
            least_squares(normals[vertex], offsets)
        })
        .collect();
    let fixed = fitted.iter().filter(|tangent| tangent.is_none()).count();
    let tangents = fitted
        .into_iter()
        .zip(normals)
        .map(|(tangent, n)| tangent.unwrap_or_else(|| fixed_tangent(*n)))
        .collect();
    (tangents, fixed)
}

/// Returns the tangent that depends on the normal alone: horizontal, to the right seen from
/// outside, where such a direction exists.
///
/// # Domain
/// A unit vector.
#[must_use]
pub fn fixed_tangent(n: DVec3) -> DVec3 {
    // On a sphere this is the direction of growing azimuth, so fixed frames vary smoothly except at
    // the poles.
    let horizontal = DVec3::new(n.z, 0.0, -n.x);
    if horizontal.length_squared() > 1e-12 {
        return horizontal.normalize();
    }
    (DVec3::X - n * n.x).normalize()
}

/// Sorted edges in both directions, without duplicates.
fn directed_edges(triangles: &[[u32; 3]]) -> Vec<(u32, u32)> {
    let mut edges: Vec<(u32, u32)> = triangles
        .iter()
        .flat_map(|&[a, b, c]| [(a, b), (b, a), (b, c), (c, b), (c, a), (a, c)])
        .collect();
    edges.par_sort_unstable();
    edges.dedup();
    edges
}

/// Returns the unit u of the fit, or `None` if the fit is singular.
fn least_squares(n: DVec3, offsets: impl Iterator<Item = (DVec2, DVec3)>) -> Option<DVec3> {
    let (mut uu, mut uv, mut vv, mut xx) = (0.0, 0.0, 0.0, 0.0);
    let (mut ux, mut vx) = (DVec3::ZERO, DVec3::ZERO);
    for (d, x) in offsets {
        let in_plane = x - n * x.dot(n);
        xx += x.length_squared();
        uu += d.x * d.x;
        uv += d.x * d.y;
        vv += d.y * d.y;
        ux += in_plane * d.x;
        vx += in_plane * d.y;
    }
    // Cramer's rule over the positive denominator, with u and v scaled by their own spreads so that
    // no product leaves the range; only the direction is needed.
    let (spread_u, spread_v) = (uu.sqrt(), vv.sqrt());
    if spread_u * spread_v == 0.0 {
        return None;
    }
    let correlation = uv / spread_u / spread_v;
    if 1.0 - correlation * correlation <= COLLINEAR {
        return None;
    }
    let numerator = ux / spread_u - vx / spread_v * correlation;
    let length = numerator.length();
    if length <= CANCELLED * xx.sqrt() {
        return None;
    }
    let u = numerator / length;
    let u = u - n * u.dot(n);
    Some(u / u.length())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Fan around the origin in the plane z = 0 where u and v are affine functions of the position.
    fn fan(u: DVec2, v: DVec2) -> Vec<(DVec2, DVec3)> {
        [(1.0, 0.1), (0.2, 1.0), (-1.0, 0.3), (0.1, -0.8)]
            .into_iter()
            .map(|(x, y)| {
                let place = DVec2::new(x, y);
                (DVec2::new(u.dot(place), v.dot(place)), place.extend(0.3 * x * y))
            })
            .collect()
    }

    #[test]
    fn tangent_is_the_direction_of_growing_u_when_the_texture_is_affine() {
        for (u, v) in [
            (DVec2::new(1.0, 0.0), DVec2::new(0.0, 1.0)),
            (DVec2::new(3.0, 1.0), DVec2::new(-1.0, 2.0)),
            (DVec2::new(-1.0, 0.0), DVec2::new(0.0, 1e-5)),
        ] {
            // Direction along which u grows and v is constant.
            let expected = DVec2::new(v.y, -v.x) * u.perp_dot(v).signum();
            let got = least_squares(DVec3::Z, fan(u, v).into_iter()).unwrap();
            assert!((got - expected.normalize().extend(0.0)).length() < 1e-12, "{u} {v}: {got}");
        }
    }

    #[test]
    fn tangent_is_undetermined_when_texture_offsets_are_collinear_or_zero() {
        let line = DVec2::new(0.3, -0.7);
        assert_eq!(least_squares(DVec3::Z, fan(line, 2.0 * line).into_iter()), None);
        assert_eq!(least_squares(DVec3::Z, fan(DVec2::ZERO, DVec2::ZERO).into_iter()), None);
        assert_eq!(least_squares(DVec3::Z, std::iter::empty()), None);
    }

    #[test]
    fn fixed_tangent_is_unit_and_perpendicular_when_the_normal_is_a_pole() {
        for n in [DVec3::Y, -DVec3::Y, DVec3::Z, DVec3::new(1e-7, 1.0, 0.0).normalize()] {
            let u = fixed_tangent(n);
            assert!((u.length() - 1.0).abs() < 1e-12 && u.dot(n).abs() < 1e-12, "{n} {u}");
        }
        assert_eq!(fixed_tangent(DVec3::Z), DVec3::X);
    }
}
