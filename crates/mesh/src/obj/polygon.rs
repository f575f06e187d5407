//! Triangulation of polygons: a fan if convex, ear clipping if concave.

use glam::{DVec2, DVec3};

/// Largest number of corner tests for the concave polygons of one file. Takes seconds at most and
/// is far above the need of real models; a hostile file of a few megabytes could otherwise take
/// days.
pub(super) const TESTS_MAX: u64 = 500_000_000;

/// Error: the polygons of a file need more than [`TESTS_MAX`] tests.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct TooComplicated;

/// Triangulates a polygon of `count` corners into `count - 2` triangles of corner indices with the
/// polygon's orientation.
///
/// # Domain
/// At least 3 corners. Triangles of planar simple polygons do not overlap; other polygons (twisted,
/// self-intersecting, zero area) yield the same number of triangles. Decrements `tests_left` by the
/// tests done.
///
/// # Errors
/// Returns [`TooComplicated`] if `tests_left` does not suffice.
pub(super) fn triangulate(
    count: usize,
    position: impl Fn(usize) -> DVec3,
    triangles: &mut Vec<[usize; 3]>,
    tests_left: &mut u64,
) -> Result<(), TooComplicated> {
    if count == 3 {
        triangles.push([0, 1, 2]);
        return Ok(());
    }
    let points = flatten(count, position);
    let mut ring: Vec<usize> = (0..count).collect();
    let mut from = 0;
    while ring.len() > 3 {
        let is_reflex = |k: &usize| !is_convex(&points, &ring, *k);
        let reflex: Vec<usize> = (0..ring.len()).filter(is_reflex).map(|k| ring[k]).collect();
        if reflex.is_empty() {
            break;
        }
        let mut candidates = (0..ring.len()).map(|step| (from + step) % ring.len());
        let found = candidates.position(|k| is_ear(&points, &ring, k, &reflex));
        let tried = found.unwrap_or(ring.len());
        let tests = ring.len() + (tried + 1) * reflex.len();
        *tests_left = tests_left.checked_sub(tests as u64).ok_or(TooComplicated)?;
        // Without an ear the polygon is self-intersecting, and any corner will do.
        let ear = (from + found.unwrap_or(0)) % ring.len();
        triangles.push(with_neighbours(&ring, ear));
        ring.remove(ear);
        from = ear;
    }
    triangles.extend((1..ring.len() - 1).map(|k| [ring[0], ring[k], ring[k + 1]]));
    Ok(())
}

/// Projects the polygon along the axis closest to its normal, counter-clockwise.
fn flatten(count: usize, position: impl Fn(usize) -> DVec3) -> Vec<DVec2> {
    let origin = position(0);
    let points: Vec<DVec3> = (0..count).map(|k| position(k) - origin).collect();
    let normal =
        (0..count).fold(DVec3::ZERO, |sum, k| sum + points[k].cross(points[(k + 1) % count]));
    let size = normal.abs();
    points
        .into_iter()
        .map(|p| {
            let (flat, sign) = if size.x >= size.y && size.x >= size.z {
                (DVec2::new(p.y, p.z), normal.x)
            } else if size.y >= size.z {
                (DVec2::new(p.z, p.x), normal.y)
            } else {
                (DVec2::new(p.x, p.y), normal.z)
            };
            if sign < 0.0 { DVec2::new(flat.y, flat.x) } else { flat }
        })
        .collect()
}

/// Returns the previous corner, the corner and the next corner of the ring.
fn with_neighbours(ring: &[usize], k: usize) -> [usize; 3] {
    [ring[(k + ring.len() - 1) % ring.len()], ring[k], ring[(k + 1) % ring.len()]]
}

/// Returns twice the signed area of the triangle; positive if counter-clockwise.
fn signed_area2(a: DVec2, b: DVec2, c: DVec2) -> f64 {
    (b - a).perp_dot(c - a)
}

fn is_convex(points: &[DVec2], ring: &[usize], k: usize) -> bool {
    let [a, b, c] = with_neighbours(ring, k).map(|corner| points[corner]);
    signed_area2(a, b, c) >= 0.0
}

/// True if the corner is strictly convex and no reflex corner lies in its triangle.
fn is_ear(points: &[DVec2], ring: &[usize], k: usize, reflex: &[usize]) -> bool {
    let corners = with_neighbours(ring, k);
    let [a, b, c] = corners.map(|corner| points[corner]);
    if signed_area2(a, b, c) <= 0.0 {
        return false;
    }
    reflex.iter().all(|other| {
        let p = points[*other];
        let inside = signed_area2(a, b, p) >= 0.0
            && signed_area2(b, c, p) >= 0.0
            && signed_area2(c, a, p) >= 0.0;
        // Corners that coincide with a corner of the ear are allowed: bridges to holes repeat
        // corners.
        !inside || corners.contains(other) || p == a || p == b || p == c
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn area(points: &[DVec3], triangles: &[[usize; 3]]) -> (f64, f64) {
        let areas = triangles.iter().map(|t| {
            let [a, b, c] = t.map(|k| points[k]);
            0.5 * (b - a).cross(c - a)
        });
        let total: DVec3 = areas.clone().sum();
        (total.length(), areas.map(DVec3::length).sum())
    }

    /// Triangles cover a simple polygon exactly if their areas have one sign and sum to its area.
    fn check(points: &[DVec3], expected: f64) {
        for shift in 0..points.len() {
            let mut ring = points.to_vec();
            ring.rotate_left(shift);
            for _ in 0..2 {
                let mut triangles = Vec::new();
                triangulate(ring.len(), |k| ring[k], &mut triangles, &mut TESTS_MAX.clone())
                    .unwrap();
                assert_eq!(triangles.len(), ring.len() - 2);
                let (signed, absolute) = area(&ring, &triangles);
                assert!((signed - expected).abs() < 1e-9 * expected, "{shift} {signed}");
                assert!((absolute - expected).abs() < 1e-9 * expected, "{shift} {absolute}");
                ring.reverse();
            }
        }
    }

    fn in_plane(points: &[(f64, f64)]) -> Vec<DVec3> {
        let (u, v) =
            (DVec3::new(1.0, 2.0, -0.5).normalize(), DVec3::new(2.0, -1.0, 0.0).normalize());
        points.iter().map(|(x, y)| DVec3::new(5.0, 1.0, 2.0) + u * *x + v * *y).collect()
    }

    #[test]
    fn polygon_is_covered_once_when_simple() {
        check(&in_plane(&[(0.0, 0.0), (2.0, 0.0), (2.0, 1.0), (0.0, 1.0)]), 2.0);
        check(&in_plane(&[(0.0, 0.0), (2.0, 0.0), (0.5, 0.5), (0.0, 2.0)]), 1.0);
        // An L, with a corner on a straight side.
        let l =
            [(0.0, 0.0), (1.0, 0.0), (2.0, 0.0), (2.0, 1.0), (1.0, 1.0), (1.0, 2.0), (0.0, 2.0)];
        check(&in_plane(&l), 3.0);
        // A five-pointed star and a comb.
        let star: Vec<(f64, f64)> = (0..10)
            .map(|k| {
                let (sin, cos) = (f64::from(k) * 0.2 * std::f64::consts::PI).sin_cos();
                let radius = if k % 2 == 0 { 1.0 } else { 0.3 };
                (radius * cos, radius * sin)
            })
            .collect();
        check(&in_plane(&star), 5.0 * 0.3 * (0.2 * std::f64::consts::PI).sin());
        let mut comb = vec![(0.0, 0.0), (20.0, 0.0)];
        comb.extend((0..20).rev().map(|k| (f64::from(k), if k % 2 == 0 { 3.0 } else { 1.0 })));
        let shoelace: f64 = (0..comb.len())
            .map(|k| {
                let (a, b) = (comb[k], comb[(k + 1) % comb.len()]);
                0.5 * (a.0 * b.1 - b.0 * a.1)
            })
            .sum();
        check(&in_plane(&comb), shoelace);
    }

    #[test]
    fn polygon_gives_count_minus_2_triangles_when_it_has_no_area() {
        for points in [vec![DVec3::ONE; 7], (0..9).map(|k| DVec3::X * f64::from(k % 4)).collect()] {
            let mut triangles = Vec::new();
            triangulate(points.len(), |k| points[k], &mut triangles, &mut TESTS_MAX.clone())
                .unwrap();
            assert_eq!(triangles.len(), points.len() - 2);
        }
    }

    #[test]
    fn polygon_is_rejected_when_it_takes_too_many_tests() {
        // A self-intersecting spiral of reflex corners, on which the search for ears is slow.
        let position = |k: usize| {
            let angle = (k * k) as f64;
            DVec3::new(angle.cos(), angle.sin(), 0.0)
        };
        let mut tests_left = 10_000;
        assert_eq!(
            triangulate(300, position, &mut Vec::new(), &mut tests_left),
            Err(TooComplicated)
        );
    }
}
