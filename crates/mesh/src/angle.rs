//! Sines and cosines of angles in degrees, and the rotations used by scene descriptions.
//!
//! Quarter turns are exact, so a scene turned by 90 degrees has no stray 1e-17 in its axes.

use glam::{DMat3, DVec3};

/// Returns (sin, cos) of an angle.
///
/// # Units
/// Degrees.
///
/// # Domain
/// Any finite angle; exact at multiples of 90. NaN and infinities give NaN.
#[must_use]
pub fn sin_cos_deg(degrees: f64) -> (f64, f64) {
    let turn = degrees % 360.0;
    let quarters = (turn / 90.0).round();
    let remainder = (turn - 90.0 * quarters) * (std::f64::consts::PI / 180.0);
    let (sin, cos) = (libm::sin(remainder), libm::cos(remainder));
    match quarters as i64 & 3 {
        0 => (sin, cos),
        1 => (cos, -sin),
        2 => (-sin, -cos),
        _ => (-cos, sin),
    }
}

/// Returns the rotation about x, then about y, then about z (right-handed, degrees).
#[must_use]
pub fn rotation_xyz_deg(degrees: [f64; 3]) -> DMat3 {
    let (sx, cx) = sin_cos_deg(degrees[0]);
    let (sz, cz) = sin_cos_deg(degrees[2]);
    let x = DMat3::from_cols(DVec3::X, DVec3::new(0.0, cx, sx), DVec3::new(0.0, -sx, cx));
    let z = DMat3::from_cols(DVec3::new(cz, sz, 0.0), DVec3::new(-sz, cz, 0.0), DVec3::Z);
    z * rotation_y_deg(degrees[1]) * x
}

/// Returns the rotation about y in degrees: from +z towards +x.
#[must_use]
pub fn rotation_y_deg(degrees: f64) -> DMat3 {
    let (s, c) = sin_cos_deg(degrees);
    DMat3::from_cols(DVec3::new(c, 0.0, -s), DVec3::Y, DVec3::new(s, 0.0, c))
}

/// Returns a vector rotated about a unit axis, counterclockwise seen from the axis' end.
///
/// # Units
/// Degrees.
#[must_use]
pub fn rotated_deg(v: DVec3, axis: DVec3, degrees: f64) -> DVec3 {
    let (s, c) = sin_cos_deg(degrees);
    v * c + axis.cross(v) * s + axis * (axis.dot(v) * (1.0 - c))
}

/// Returns the unit vector of an azimuth (0 is +z, 90 is +x) and an elevation above the xz plane,
/// both in degrees.
#[must_use]
pub fn orbit_direction(azimuth_deg: f64, elevation_deg: f64) -> DVec3 {
    let (sa, ca) = sin_cos_deg(azimuth_deg);
    let (se, ce) = sin_cos_deg(elevation_deg);
    DVec3::new(sa * ce, se, ca * ce)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sin_cos_is_exact_when_the_angle_is_a_quarter_turn() {
        let expected = [(0.0, 1.0), (1.0, 0.0), (0.0, -1.0), (-1.0, 0.0)];
        for turn in -9i32..9 {
            let (sin, cos) = sin_cos_deg(90.0 * f64::from(turn));
            assert!((sin, cos) == expected[turn.rem_euclid(4) as usize], "{turn}: {sin} {cos}");
        }
        for degrees in [-359.0f64, -123.4, 12.0, 44.9, 45.1, 300.0, 725.0] {
            let (sin, cos) = sin_cos_deg(degrees);
            assert!((sin - degrees.to_radians().sin()).abs() < 1e-14, "{degrees}");
            assert!((cos - degrees.to_radians().cos()).abs() < 1e-14, "{degrees}");
        }
    }

    #[test]
    fn rotation_applies_x_first_and_z_last() {
        let rotated = rotation_xyz_deg([90.0, 90.0, 90.0]) * DVec3::Y;
        assert!((rotated - DVec3::Y).length() < 1e-15, "y to z, to x, to y: {rotated}");
        assert!((rotation_y_deg(90.0) * DVec3::Z - DVec3::X).length() < 1e-15);
        assert!((orbit_direction(90.0, 0.0) - DVec3::X).length() < 1e-15);
        assert!((orbit_direction(10.0, 90.0) - DVec3::Y).length() < 1e-15);
    }
}
