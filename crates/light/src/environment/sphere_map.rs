//! Equal-area map between directions and the unit square.
//!
//! # Source
//! Clarberg 2008, *Fast Equal-Area Mapping of the (Hemi)Sphere using SIMD*: an octahedron unfolded
//! to a square, so that equal areas of the square are equal solid angles.

use std::f64::consts::{FRAC_PI_4, PI};

use glam::DVec3;

/// Coefficients of t, t^3, t^5, ... of 2/pi atan(t) on [0, 1]; the error is at most 1.2e-6.
const ARC: [f32; 6] =
    [0.636_604_3, -0.211_730_31, 0.123_054_61, -0.073_709_14, 0.033_055_565, -0.007_275_004];

/// Returns the angle of a vector in the first quadrant as a share of a quarter turn, within [0, 1].
///
/// # Error
/// At most 1.3e-6.
#[inline(always)]
fn quarter_turns(x: f32, y: f32) -> f32 {
    let (small, large) = if x < y { (x, y) } else { (y, x) };
    let t = small / large.max(f32::MIN_POSITIVE);
    let s = t * t;
    let series = ARC[2] + s * (ARC[3] + s * (ARC[4] + s * ARC[5]));
    let arc = t * (ARC[0] + s * (ARC[1] + s * series));
    if x < y { 1.0 - arc } else { arc }
}

/// Returns the angle of a vector as a share of a full turn, within [0, 1].
#[inline(always)]
pub(super) fn turns(x: f32, y: f32) -> f32 {
    let quarter = quarter_turns(x.abs(), y.abs());
    let half = if x < 0.0 { 2.0 - quarter } else { quarter };
    let turn = if y < 0.0 { 4.0 - half } else { half };
    0.25 * turn
}

/// Maps a direction to the square.
///
/// # Domain
/// A unit vector. Both results are within [0, 1].
///
/// # Error
/// At most 5e-4 near the poles of y, otherwise 1e-5.
#[inline(always)]
pub(super) fn square([x, y, z]: [f32; 3]) -> [f32; 2] {
    let radius = (1.0 - y.abs()).max(0.0).sqrt();
    let arc = quarter_turns(x.abs(), z.abs());
    let v = arc * radius;
    let u = radius - v;
    let (u, v) = if y < 0.0 { (1.0 - v, 1.0 - u) } else { (u, v) };
    [0.5 + 0.5 * u.copysign(x), 0.5 + 0.5 * v.copysign(z)]
}

/// Maps a point of the square to its direction.
///
/// # Domain
/// Both coordinates within [0, 1].
pub(super) fn direction([x, z]: [f64; 2]) -> DVec3 {
    let (u, v) = (2.0 * x - 1.0, 2.0 * z - 1.0);
    let signed = 1.0 - (u.abs() + v.abs());
    let radius = 1.0 - signed.abs();
    let turn = if radius == 0.0 { 1.0 } else { (v.abs() - u.abs()) / radius + 1.0 };
    let angle = turn * FRAC_PI_4;
    let level = radius * (2.0 - radius * radius).max(0.0).sqrt();
    DVec3::new(
        (libm::cos(angle) * level).copysign(u),
        (1.0 - radius * radius).copysign(signed),
        (libm::sin(angle) * level).copysign(v),
    )
}

/// Returns the texel of a square of `side` texels that continues the map beyond its edges.
///
/// # Domain
/// At most one side outside.
pub(super) fn wrapped((x, y): (i64, i64), side: i64) -> (usize, usize) {
    let (mut x, mut y) = (x, y);
    if x < 0 || x >= side {
        x = if x < 0 { -x - 1 } else { 2 * side - 1 - x };
        y = side - 1 - y;
    }
    if y < 0 || y >= side {
        y = if y < 0 { -y - 1 } else { 2 * side - 1 - y };
        x = side - 1 - x;
    }
    let inside = |k: i64| usize::try_from(k).expect("at most one side outside");
    (inside(x), inside(y))
}

/// Angle across a texel of a map of `side` texels, as the root of its solid angle, in radians.
pub(super) fn texel_angle(side: usize) -> f64 {
    (4.0 * PI).sqrt() / side as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn directions_return_to_their_point() {
        let side = 37;
        for k in 0..side * side {
            let at = |k: usize| (k as f64 + 0.5) / side as f64;
            let point = [at(k % side), at(k / side)];
            let found = direction(point);
            assert!((found.length() - 1.0).abs() < 1e-12);
            let back = square(found.as_vec3().to_array());
            for (a, b) in point.iter().zip(back) {
                assert!((a - f64::from(b)).abs() < 1e-3, "{point:?} {back:?}");
            }
        }
        assert!((texel_angle(1).powi(2) / (4.0 * PI) - 1.0).abs() < 1e-12);
    }

    #[test]
    fn texels_beyond_an_edge_are_its_neighbours_on_the_sphere() {
        let side = 64;
        let centre = |(x, y): (usize, usize)| {
            direction([(x as f64 + 0.5) / side as f64, (y as f64 + 0.5) / side as f64])
        };
        for k in 0..side {
            for (outside, inside) in
                [((-1, k), (0, k)), ((k, -1), (k, 0)), ((side, k), (side - 1, k))]
            {
                let neighbour = wrapped(outside, side);
                let own = (usize::try_from(inside.0).unwrap(), usize::try_from(inside.1).unwrap());
                let cos = centre(neighbour).dot(centre(own));
                assert!(cos > 0.99, "{outside:?} {neighbour:?} {cos}");
            }
        }
    }
}
