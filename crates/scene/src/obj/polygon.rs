//! Cuts polygons into triangles: convex ones into a fan, concave ones by clipping ears.

use glam::{DVec2, DVec3};

/// How many corner tests the concave polygons of one file may take: seconds at most, and far beyond what files of
/// real models need, while a hostile file of a few megabytes could ask for days.
pub(super) const TESTS_MAX: u64 = 500_000_000;

/// The polygons of a file take more than [`TESTS_MAX`] tests.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct TooComplicated;

/// Cuts the polygon of `count` corners into `count - 2` triangles of corner numbers, in the polygon's own sense.
///
/// # Domain
/// At least 3 corners. Planar simple polygons are cut into triangles that do not overlap; others (twisted, crossing
/// themselves, of no area) into as many triangles of the same corners. Tests done are taken off `tests_left`.
pub(super) fn cut(
    count: usize,
    place: impl Fn(usize) -> DVec3,
    triangles: &mut Vec<[usize; 3]>,
    tests_left: &mut u64,
) -> Result<(), TooComplicated> {
    if count == 3 {
        triangles.push([0, 1, 2]);
        return Ok(());
    }
    let points = flatten(count, place);
    let mut ring: Vec<usize> = (0..count).collect();
    let mut from = 0;
    while ring.len() > 3 {
        let sticks_in = |k: &usize| !is_convex(&points, &ring, *k);
        let reflex: Vec<usize> = (0..ring.len()).filter(sticks_in).map(|k| ring[k]).collect();
        if reflex.is_empty() {
            break;
        }
        let mut candidates = (0..ring.len()).map(|step| (from + step) % ring.len());
        let found = candidates.position(|k| is_ear(&points, &ring, k, &reflex));
        let tried = found.unwrap_or(ring.len());
        let tests = ring.len() + (tried + 1) * reflex.len();
        *tests_left = tests_left.checked_sub(tests as u64).ok_or(TooComplicated)?;
        // Where no corner is an ear the polygon crosses itself; any corner is then as good.
        let ear = (from + found.unwrap_or(0)) % ring.len();
        triangles.push(around(&ring, ear));
        ring.remove(ear);
        from = ear;
    }
    triangles.extend((1..ring.len() - 1).map(|k| [ring[0], ring[k], ring[k + 1]]));
    Ok(())
}

/// The polygon seen along the axis closest to its normal, counter-clockwise.
fn flatten(count: usize, place: impl Fn(usize) -> DVec3) -> Vec<DVec2> {
    let origin = place(0);
    let points: Vec<DVec3> = (0..count).map(|k| place(k) - origin).collect();
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

/// The corner and its neighbours in the ring.
fn around(ring: &[usize], k: usize) -> [usize; 3] {
    [ring[(k + ring.len() - 1) % ring.len()], ring[k], ring[(k + 1) % ring.len()]]
}

/// Positive where a, b, c turn left.
fn turn(a: DVec2, b: DVec2, c: DVec2) -> f64 {
    (b - a).perp_dot(c - a)
}

fn is_convex(points: &[DVec2], ring: &[usize], k: usize) -> bool {
    let [a, b, c] = around(ring, k).map(|corner| points[corner]);
    turn(a, b, c) >= 0.0
}

/// Whether the corner sticks out and no reflex corner lies in its triangle.
fn is_ear(points: &[DVec2], ring: &[usize], k: usize, reflex: &[usize]) -> bool {
    let corners = around(ring, k);
    let [a, b, c] = corners.map(|corner| points[corner]);
    if turn(a, b, c) <= 0.0 {
        return false;
    }
    reflex.iter().all(|other| {
        let p = points[*other];
        let inside = turn(a, b, p) >= 0.0 && turn(b, c, p) >= 0.0 && turn(c, a, p) >= 0.0;
        // A corner at the place of one of the ear's own does not hinder it: holes are cut in with such pairs.
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

    /// Triangles of a simple polygon cover it exactly when their areas all have one sign and sum to its own.
    fn check(points: &[DVec3], expected: f64) {
        for shift in 0..points.len() {
            let mut ring = points.to_vec();
            ring.rotate_left(shift);
            for _ in 0..2 {
                let mut triangles = Vec::new();
                cut(ring.len(), |k| ring[k], &mut triangles, &mut TESTS_MAX.clone()).unwrap();
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
    fn polygon_is_covered_once_when_it_is_convex_or_concave() {
        check(&in_plane(&[(0.0, 0.0), (2.0, 0.0), (2.0, 1.0), (0.0, 1.0)]), 2.0);
        check(&in_plane(&[(0.0, 0.0), (2.0, 0.0), (0.5, 0.5), (0.0, 2.0)]), 1.0);
        // An L, with a corner on a straight side.
        let l =
            [(0.0, 0.0), (1.0, 0.0), (2.0, 0.0), (2.0, 1.0), (1.0, 1.0), (1.0, 2.0), (0.0, 2.0)];
        check(&in_plane(&l), 3.0);
        // A star of five points, and a comb.
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
    fn polygon_is_cut_into_the_same_number_of_triangles_when_it_has_no_area() {
        for points in [vec![DVec3::ONE; 7], (0..9).map(|k| DVec3::X * f64::from(k % 4)).collect()] {
            let mut triangles = Vec::new();
            cut(points.len(), |k| points[k], &mut triangles, &mut TESTS_MAX.clone()).unwrap();
            assert_eq!(triangles.len(), points.len() - 2);
        }
    }

    #[test]
    fn polygon_is_refused_when_it_takes_too_many_tests() {
        // A spiral of reflex corners that crosses itself, so that no ear is found for long.
        let place = |k: usize| {
            let angle = (k * k) as f64;
            DVec3::new(angle.cos(), angle.sin(), 0.0)
        };
        let mut tests_left = 10_000;
        assert_eq!(cut(300, place, &mut Vec::new(), &mut tests_left), Err(TooComplicated));
    }
}
