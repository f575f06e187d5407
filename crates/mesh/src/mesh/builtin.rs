//! Built-in meshes: shader ball, sphere, torus, rounded cube and knob.

use glam::{DVec2, DVec3};

use super::assemble::{RawMesh, assemble};
use super::ball::ball;
use super::parts::MeshParts;
use super::revolution::{ProfilePoint, bezier_profile, lean, line, revolve};
use crate::angle::sin_cos_deg;

/// Procedural mesh.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum BuiltinMesh {
    /// Shader ball: a sphere with a groove and a flat on a turned base.
    Ball,
    /// Unit sphere.
    Sphere,
    /// Unit sphere whose texture has its poles on the z axis. It has no name of its own: scenes
    /// select it by `sphere_pole`.
    SphereZ,
    /// Torus.
    Torus,
    /// Cube with rounded edges.
    Cube,
    /// Turned knob with concave and convex curvature, grazing angles, a bead and a flange.
    Knob,
    /// Level square with sides of 2. It has no name: it is the ground of scenes.
    Ground,
}

impl BuiltinMesh {
    /// All built-in meshes that have a name.
    pub const ALL: [Self; 5] = [Self::Ball, Self::Sphere, Self::Torus, Self::Cube, Self::Knob];

    /// Returns the name in scenes.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Ball => "ball",
            Self::Sphere | Self::SphereZ => "sphere",
            Self::Torus => "torus",
            Self::Cube => "cube",
            Self::Knob => "knob",
            Self::Ground => "ground",
        }
    }

    /// Returns the mesh of that name.
    #[must_use]
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|mesh| mesh.name() == name)
    }
}

/// Steps around the axis: at 512 pixels a silhouette deviates from its circle by under 0.04 pixels.
const COLUMNS: u32 = 192;

/// Builds the arrays of a built-in mesh.
pub(super) fn build(mesh: BuiltinMesh) -> MeshParts {
    match mesh {
        BuiltinMesh::Ball => ball(),
        BuiltinMesh::Sphere => sphere(),
        BuiltinMesh::SphereZ => sphere_z(),
        BuiltinMesh::Torus => torus(),
        BuiltinMesh::Cube => rounded_cube(),
        BuiltinMesh::Knob => knob(),
        BuiltinMesh::Ground => ground(),
    }
}

/// Sphere of radius 1; u is the azimuth, v the polar angle from the bottom over half a turn.
fn sphere() -> MeshParts {
    let rows = 96u32;
    let profile: Vec<ProfilePoint> = (0..=rows)
        .map(|row| {
            let v = f64::from(row) / f64::from(rows);
            let (sin, cos) = sin_cos_deg(180.0 * v);
            let position = DVec2::new(sin, -cos);
            ProfilePoint { position, normal: position, v }
        })
        .collect();
    revolve(&profile, COLUMNS)
}

/// Sphere of radius 1; u is the azimuth from +x over +y, v the polar angle from +z over half a
/// turn.
///
/// # Source
/// The shape `sphere` of Mitsuba 3.
fn sphere_z() -> MeshParts {
    let mut parts = sphere();
    // A rotation, so that triangles keep their orientation; u begins at +x.
    let turned = |w: DVec3| DVec3::new(-w.z, -w.x, w.y);
    for array in [&mut parts.positions, &mut parts.normals, &mut parts.tangents] {
        for vector in array {
            *vector = turned(*vector);
        }
    }
    for uv in &mut parts.uvs {
        uv.y = 1.0 - uv.y;
    }
    parts
}

/// Half the side of the ground, in radii of the object that stands on it.
pub const GROUND_RADII: f64 = 1000.0;

/// Square in the plane y = 0. Its texture repeats after two radii of the object, from a corner
/// below the object's centre.
fn ground() -> MeshParts {
    let corners = [DVec2::new(-1.0, 1.0), DVec2::ONE, DVec2::new(1.0, -1.0), -DVec2::ONE];
    MeshParts {
        positions: corners.map(|at| DVec3::new(at.x, 0.0, at.y)).to_vec(),
        normals: vec![DVec3::Y; 4],
        uvs: corners.map(|at| DVec2::new(at.x, -at.y) * (0.5 * GROUND_RADII)).to_vec(),
        tangents: vec![DVec3::X; 4],
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        has_uv: true,
    }
}

/// Torus of radii 1 and 0.4 about the y axis, leaning towards +z so that the default view sees the
/// hole.
fn torus() -> MeshParts {
    let rows = 96u32;
    let profile: Vec<ProfilePoint> = (0..=rows)
        .map(|row| {
            let v = f64::from(row) / f64::from(rows);
            // The order inside, bottom, outside, top makes v grow upwards on the outside.
            let (sin, cos) = sin_cos_deg(360.0 * v - 180.0);
            let normal = DVec2::new(cos, sin);
            ProfilePoint { position: DVec2::new(1.0, 0.0) + 0.4 * normal, normal, v }
        })
        .collect();
    let mut parts = revolve(&profile, COLUMNS);
    lean(&mut parts, TORUS_LEAN_DEG);
    parts
}

const TORUS_LEAN_DEG: f64 = 35.0;

/// Cube of edge length 1.6 with edges rounded at radius 0.2. Each face has the texture square
/// [0, 1]^2, upright.
fn rounded_cube() -> MeshParts {
    // (n, u, v) of each face with n = u x v; v points up where the face allows it.
    let faces = [
        (DVec3::Z, DVec3::X, DVec3::Y),
        (DVec3::X, DVec3::NEG_Z, DVec3::Y),
        (DVec3::NEG_Z, DVec3::NEG_X, DVec3::Y),
        (DVec3::NEG_X, DVec3::Z, DVec3::Y),
        (DVec3::Y, DVec3::X, DVec3::NEG_Z),
        (DVec3::NEG_Y, DVec3::X, DVec3::Z),
    ];
    let steps = cube_steps();
    let side = u32::try_from(steps.len()).expect("a face has few steps");
    let mut raw = RawMesh::default();
    for (face, (n, u, v)) in (0u32..).zip(faces) {
        for t in &steps {
            for s in &steps {
                let on_cube = n * CUBE_HALF + u * *s + v * *t;
                let core = on_cube.clamp(DVec3::splat(-CUBE_CORE), DVec3::splat(CUBE_CORE));
                let normal = (on_cube - core).normalize();
                raw.positions.push(core + normal * (CUBE_HALF - CUBE_CORE));
                raw.normals.push(Some(normal));
                raw.uvs.push(Some(DVec2::new(*s, *t) / (2.0 * CUBE_HALF) + DVec2::splat(0.5)));
            }
        }
        for row in 0..side - 1 {
            for column in 0..side - 1 {
                let a = face * side * side + row * side + column;
                let (b, c, d) = (a + 1, a + side, a + side + 1);
                raw.triangles.extend([[a, b, d], [a, d, c]]);
            }
        }
    }
    raw.smooth_group = (0u32..).take(raw.positions.len()).collect();
    raw.smooth_groups = raw.positions.len();
    assemble(raw).0
}

const CUBE_HALF: f64 = 0.8;
const CUBE_CORE: f64 = 0.6;

/// Steps along an edge of a face: equal angles over the rounding, equal lengths between.
fn cube_steps() -> Vec<f64> {
    let (rounding, flat) = (12i32, 12i32);
    let bend = |k: i32| {
        let (sin, cos) = sin_cos_deg(45.0 * f64::from(k) / f64::from(rounding));
        CUBE_CORE + (CUBE_HALF - CUBE_CORE) * sin / cos
    };
    let low = (1..=rounding).rev().map(|k| -bend(k));
    let middle = (0..=flat).map(|k| CUBE_CORE * f64::from(2 * k - flat) / f64::from(flat));
    low.chain(middle).chain((1..=rounding).map(bend)).collect()
}

/// Turned knob: a flange, a bead, a slim neck and a bulb.
fn knob() -> MeshParts {
    let p = DVec2::new;
    let curves = [
        line(p(0.0, -1.0), p(0.74, -1.0)),
        [p(0.74, -1.0), p(0.80, -1.0), p(0.84, -0.96), p(0.84, -0.90)],
        [p(0.84, -0.90), p(0.84, -0.84), p(0.80, -0.80), p(0.74, -0.79)],
        [p(0.74, -0.79), p(0.56, -0.76), p(0.40, -0.68), p(0.36, -0.54)],
        // The bead.
        [p(0.36, -0.54), p(0.352, -0.512), p(0.37, -0.50), p(0.40, -0.49)],
        [p(0.40, -0.49), p(0.46, -0.47), p(0.46, -0.37), p(0.40, -0.35)],
        [p(0.40, -0.35), p(0.34, -0.33), p(0.28, -0.28), p(0.28, -0.18)],
        // Neck and bulb.
        [p(0.28, -0.18), p(0.28, 0.02), p(0.72, 0.04), p(0.72, 0.46)],
        [p(0.72, 0.46), p(0.72, 0.84), p(0.42, 1.02), p(0.0, 1.02)],
    ];
    let mut parts = revolve(&bezier_profile(&curves, 20), COLUMNS);
    // Rotating unit profile normals leaves rounding errors in their length; points on the axis must
    // keep exact positions.
    for normal in &mut parts.normals {
        *normal = normal.normalize();
    }
    parts
}
