//! The shader ball: a sphere with a groove and a flat, leaning to the camera, on a turned base.

use glam::{DVec2, DVec3};

use super::parts::MeshParts;
use super::revolution::{ProfilePoint, bezier_profile, lean, line, revolve};
use crate::angle::sin_cos_deg;

/// Angle by which the axis of the sphere leans from +y towards +z, so that the default view sees
/// flat and groove.
const LEAN_DEG: f64 = 35.0;
/// Height of the flat above the centre of the sphere, and radius of the edge around it.
const FLAT: f64 = 0.86;
const EDGE: f64 = 0.06;
/// Latitude of the middle of the groove, half of its width, width of its walls, and depth.
const GROOVE_DEG: f64 = 14.0;
const GROOVE_HALF_DEG: f64 = 8.0;
const GROOVE_WALL_DEG: f64 = 4.0;
const GROOVE_DEPTH: f64 = 0.09;
const COLUMNS: u32 = 192;

/// Builds the arrays. The sphere ends inside the base: both surfaces are closed and intersect.
pub(super) fn ball() -> MeshParts {
    let mut parts = revolve(&grooved_sphere(), COLUMNS);
    lean(&mut parts, LEAN_DEG);
    let base = revolve(&bezier_profile(&base(), 12), COLUMNS);
    let first = u32::try_from(parts.positions.len()).expect("a built-in mesh is small");
    parts.positions.extend(base.positions);
    parts.normals.extend(base.normals.into_iter().map(DVec3::normalize));
    parts.tangents.extend(base.tangents);
    parts.uvs.extend(base.uvs);
    parts.triangles.extend(base.triangles.iter().map(|corners| corners.map(|at| at + first)));
    parts
}

/// Depth of the groove at a latitude, and its derivative per degree: a level bottom between walls
/// shaped like a cosine.
fn groove(latitude_deg: f64) -> (f64, f64) {
    let from_wall = (latitude_deg - GROOVE_DEG).abs() - (GROOVE_HALF_DEG - GROOVE_WALL_DEG);
    let t = from_wall / GROOVE_WALL_DEG;
    if t >= 1.0 {
        return (0.0, 0.0);
    }
    if t <= 0.0 {
        return (GROOVE_DEPTH, 0.0);
    }
    let (sin, cos) = sin_cos_deg(180.0 * t);
    let outwards = (latitude_deg - GROOVE_DEG).signum();
    let slope = -90.0_f64.to_radians() / GROOVE_WALL_DEG * sin * outwards;
    (0.5 * GROOVE_DEPTH * (1.0 + cos), GROOVE_DEPTH * slope)
}

/// Profile of the sphere from its lower pole to the middle of the flat.
fn grooved_sphere() -> Vec<ProfilePoint> {
    // The edge is a circle that touches sphere and flat from inside.
    let (reach, height) = (1.0 - EDGE, FLAT - EDGE);
    let centre = DVec2::new((reach * reach - height * height).sqrt(), height);
    let edge_deg = libm::atan2(centre.y, centre.x).to_degrees();
    let mut profile: Vec<ProfilePoint> = Vec::new();
    let mut push = |position: DVec2, normal: DVec2| {
        let v = profile.last().map_or(0.0, |last| last.v + (position - last.position).length());
        profile.push(ProfilePoint { position, normal: normal.normalize(), v });
    };
    let groove_from = GROOVE_DEG - GROOVE_HALF_DEG;
    let groove_to = GROOVE_DEG + GROOVE_HALF_DEG;
    let spans = [(-90.0, groove_from, 60), (groove_from, groove_to, 48), (groove_to, edge_deg, 26)];
    for (span, (from, to, steps)) in spans.into_iter().enumerate() {
        for step in u32::from(span > 0)..=steps {
            let latitude = from + (to - from) * f64::from(step) / f64::from(steps);
            // Exact on the axis.
            let (sin, cos) = if latitude == -90.0 { (-1.0, 0.0) } else { sin_cos_deg(latitude) };
            let (depth, per_degree) = groove(latitude);
            let outwards = DVec2::new(cos, sin);
            let along = DVec2::new(-sin, cos);
            let slope = -per_degree.to_degrees();
            let tangent = outwards * slope + along * (1.0 - depth);
            push(outwards * (1.0 - depth), DVec2::new(tangent.y, -tangent.x));
        }
    }
    let steps = 12;
    for step in 1..=steps {
        let angle = edge_deg + (90.0 - edge_deg) * f64::from(step) / f64::from(steps);
        let (sin, cos) = if step == steps { (1.0, 0.0) } else { sin_cos_deg(angle) };
        let normal = DVec2::new(cos, sin);
        push(centre + EDGE * normal, normal);
    }
    let steps = 8;
    for step in 1..=steps {
        let x = centre.x * (1.0 - f64::from(step) / f64::from(steps));
        push(DVec2::new(x, FLAT), DVec2::Y);
    }
    let length = profile.last().map_or(1.0, |last| last.v);
    for point in &mut profile {
        point.v /= length;
    }
    profile
}

/// Profile of the base: a disc with a round rim, a flat top, and a fillet that rises into the
/// sphere.
fn base() -> [[DVec2; 4]; 5] {
    let p = DVec2::new;
    [
        line(p(0.0, -1.14), p(0.66, -1.14)),
        [p(0.66, -1.14), p(0.73, -1.14), p(0.73, -1.04), p(0.66, -1.04)],
        line(p(0.66, -1.04), p(0.56, -1.04)),
        [p(0.56, -1.04), p(0.44, -1.04), p(0.36, -0.98), p(0.36, -0.86)],
        [p(0.36, -0.86), p(0.36, -0.78), p(0.20, -0.74), p(0.0, -0.74)],
    ]
}
