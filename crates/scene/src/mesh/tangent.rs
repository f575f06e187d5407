//! Tangents: the direction in which the texture coordinate u grows, per vertex.
//!
//! Owns the least-squares fit over the edges of a vertex and the fixed tangent that stands in where it is singular.

use glam::{DVec2, DVec3};
use rayon::prelude::*;

/// 1 - r^2 of the neighbours' texture offsets under which they count as lying on one line.
const COLLINEAR: f64 = 1e-9;
/// Length of the numerator, relative to the neighbours' distances, under which its terms count as cancelling.
const CANCELLED: f64 = 1e-9;

/// Tangents of all vertices, and how many of them had to be the fixed one.
///
/// # Shapes
/// All slices per vertex but `triangles`; the result per vertex.
///
/// # Domain
/// Unit normals, coordinates within the range of f32, valid corners. The result is always unit and perpendicular to
/// the normal: where the texture offsets of the neighbours lie on one line or vanish, [`fixed_tangent`].
///
/// # Source
/// Meyer-Spradow and Loviscach, *Evolutionary Design of BRDFs*, section 3: minimise
/// sum_k |x0 + (u_k - u0) u + (v_k - v0) b - x_k|^2 over u and b in the tangent plane, the neighbours k along edges.
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

/// A tangent that depends on the normal alone: level, to the right seen from outside, where there is such a direction.
pub(crate) fn fixed_tangent(n: DVec3) -> DVec3 {
    // On a sphere this is the direction of growing azimuth, so that stand-in frames turn smoothly except at the poles.
    let level = DVec3::new(n.z, 0.0, -n.x);
    if level.length_squared() > 1e-12 {
        return level.normalize();
    }
    (DVec3::X - n * n.x).normalize()
}

/// Edges in both directions, each once, ordered.
fn directed_edges(triangles: &[[u32; 3]]) -> Vec<(u32, u32)> {
    let mut edges: Vec<(u32, u32)> = triangles
        .iter()
        .flat_map(|&[a, b, c]| [(a, b), (b, a), (b, c), (c, b), (c, a), (a, c)])
        .collect();
    edges.par_sort_unstable();
    edges.dedup();
    edges
}

/// The unit u of the fit; `None` where it is not determined.
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
    // Cramer's rule, over the positive denominator and with u and v measured in their own spreads, so that no product
    // leaves the range: only the direction is wanted.
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

    /// A fan around the origin in the plane z = 0 with u and v an affine function of the place.
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
            // The direction along which u grows and v stays.
            let expected = DVec2::new(v.y, -v.x) * u.perp_dot(v).signum();
            let got = least_squares(DVec3::Z, fan(u, v).into_iter()).unwrap();
            assert!((got - expected.normalize().extend(0.0)).length() < 1e-12, "{u} {v}: {got}");
        }
    }

    #[test]
    fn tangent_is_not_determined_when_texture_offsets_lie_on_a_line_or_vanish() {
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
