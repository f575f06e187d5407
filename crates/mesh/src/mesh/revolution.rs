//! Surfaces of revolution about the y axis, with exact normals and tangents.

use glam::{DVec2, DVec3};

use super::parts::MeshParts;
use crate::angle::{rotation_xyz_deg, sin_cos_deg};

/// Point of the profile of a surface of revolution.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct ProfilePoint {
    /// Distance from the axis and height.
    pub position: DVec2,
    /// Unit normal: component away from the axis, then upwards.
    pub normal: DVec2,
    /// Texture coordinate v.
    pub v: f64,
}

/// Revolves a profile, given from the bottom up with the outside to the right, about the y axis in
/// `columns` steps.
///
/// u grows from 0 to 1 with the azimuth: from -z, where the default view does not see the seam,
/// over -x, +z and +x.
pub(super) fn revolve(profile: &[ProfilePoint], columns: u32) -> MeshParts {
    let rows = u32::try_from(profile.len()).expect("profiles are short");
    let mut parts = MeshParts { has_uv: true, ..MeshParts::default() };
    for point in profile {
        for column in 0..=columns {
            // The last column repeats the positions of the first bit for bit.
            let turn = f64::from(column % columns) / f64::from(columns);
            let (sin, cos) = sin_cos_deg(360.0 * turn - 180.0);
            let around = |w: DVec2| DVec3::new(w.x * sin, w.y, w.x * cos);
            parts.positions.push(around(point.position));
            parts.normals.push(around(point.normal));
            parts.uvs.push(DVec2::new(f64::from(column) / f64::from(columns), point.v));
            parts.tangents.push(DVec3::new(cos, 0.0, -sin));
        }
    }
    for row in 0..rows - 1 {
        for column in 0..columns {
            let a = row * (columns + 1) + column;
            let (b, c, d) = (a + 1, a + columns + 1, a + columns + 2);
            // On the axis a row collapses to one point, and one of the two triangles has no area.
            if profile[row as usize].position.x > 0.0 {
                parts.triangles.push([a, b, d]);
            }
            if profile[row as usize + 1].position.x > 0.0 {
                parts.triangles.push([a, d, c]);
            }
        }
    }
    parts
}

/// Leans a mesh from +y towards +z.
pub(super) fn lean(parts: &mut MeshParts, angle_deg: f64) {
    let rotation = rotation_xyz_deg([angle_deg, 0.0, 0.0]);
    let arrays = [&mut parts.positions, &mut parts.normals, &mut parts.tangents];
    for vector in arrays.into_iter().flatten() {
        *vector = rotation * *vector;
    }
}

/// Straight line as a cubic Bézier curve.
pub(super) fn line(from: DVec2, to: DVec2) -> [DVec2; 4] {
    [from, from.lerp(to, 1.0 / 3.0), from.lerp(to, 2.0 / 3.0), to]
}

/// Samples a chain of cubic Bézier curves as a profile with `steps` points per curve and v by arc
/// length.
///
/// # Domain
/// Curves join with a common tangent, so that every point has one normal; no handle has length 0.
pub(super) fn bezier_profile(curves: &[[DVec2; 4]], steps: u32) -> Vec<ProfilePoint> {
    let mut profile: Vec<ProfilePoint> = Vec::new();
    for (index, curve) in curves.iter().enumerate() {
        for step in u32::from(index > 0)..=steps {
            let (position, direction) = bezier(curve, f64::from(step) / f64::from(steps));
            let d = direction.normalize();
            let v = profile.last().map_or(0.0, |last| last.v + (position - last.position).length());
            profile.push(ProfilePoint { position, normal: DVec2::new(d.y, -d.x), v });
        }
    }
    let length = profile.last().map_or(1.0, |last| last.v);
    for point in &mut profile {
        point.v /= length;
    }
    profile
}

/// Returns the point and the direction of the derivative.
fn bezier([a, b, c, d]: &[DVec2; 4], t: f64) -> (DVec2, DVec2) {
    let s = 1.0 - t;
    let position =
        *a * (s * s * s) + *b * (3.0 * s * s * t) + *c * (3.0 * s * t * t) + *d * (t * t * t);
    let direction = (*b - *a) * (s * s) + (*c - *b) * (2.0 * s * t) + (*d - *c) * (t * t);
    (position, direction)
}
