use glam::{DVec2, DVec3};
use proptest::prelude::*;

use super::assemble::{RawMesh, assemble};
use super::{BuiltinMesh, Mesh, MeshError, MeshParts};

fn triangle() -> MeshParts {
    MeshParts {
        positions: vec![DVec3::ZERO, DVec3::X, DVec3::Y],
        normals: vec![DVec3::Z; 3],
        uvs: vec![DVec2::ZERO; 3],
        tangents: vec![DVec3::X; 3],
        triangles: vec![[0, 1, 2]],
        has_uv: false,
    }
}

#[test]
fn mesh_is_refused_when_its_arrays_are_invalid() {
    type Change = fn(&mut MeshParts);
    let cases: [(Change, MeshError); 10] = [
        (|parts| parts.triangles.clear(), MeshError::NoTriangle),
        (|parts| parts.positions = vec![DVec3::ONE; 3], MeshError::NoExtent),
        (|parts| parts.uvs.truncate(2), MeshError::Lengths),
        (|parts| parts.normals.push(DVec3::Z), MeshError::Lengths),
        (|parts| parts.triangles.push([0, 3, 1]), MeshError::Corner(1)),
        (|parts| parts.positions[1].y = f64::NAN, MeshError::NotFinite(1)),
        (|parts| parts.uvs[2].x = 1e39, MeshError::NotFinite(2)),
        (|parts| parts.normals[0] = DVec3::ZERO, MeshError::Frame(0)),
        (|parts| parts.tangents[1] = DVec3::Z, MeshError::Frame(1)),
        (|parts| parts.tangents[2].x = f64::NAN, MeshError::Frame(2)),
    ];
    assert!(Mesh::from_parts(triangle()).is_ok());
    for (change, error) in cases {
        let mut parts = triangle();
        change(&mut parts);
        let bytes = postcard::to_stdvec(&parts).unwrap();
        assert!(
            postcard::from_bytes::<Mesh>(&bytes).is_err(),
            "{error} not detected by Deserialize"
        );
        assert_eq!(Mesh::from_parts(parts), Err(error));
    }
}

#[test]
fn mesh_round_trips_through_postcard_bit_for_bit() {
    for builtin in BuiltinMesh::ALL {
        let mesh = Mesh::builtin(builtin);
        let back: Mesh = postcard::from_bytes(&postcard::to_stdvec(&mesh).unwrap()).unwrap();
        assert_eq!(back, mesh);
        assert_eq!(back.content_hash(), mesh.content_hash());
    }
}

#[test]
fn content_hash_differs_when_any_array_differs() {
    type Change = fn(&mut MeshParts);
    let changes: [Change; 6] = [
        |parts| parts.positions[0].x = -0.5,
        |parts| parts.normals[1] = DVec3::NEG_Z,
        |parts| parts.uvs[2].y = 0.25,
        |parts| parts.tangents[0] = DVec3::Y,
        |parts| parts.triangles[0] = [0, 2, 1],
        |parts| parts.has_uv = true,
    ];
    let mut hashes = vec![Mesh::from_parts(triangle()).unwrap().content_hash()];
    for change in changes {
        let mut parts = triangle();
        change(&mut parts);
        hashes.push(Mesh::from_parts(parts).unwrap().content_hash());
    }
    hashes.sort_unstable();
    hashes.dedup();
    assert_eq!(hashes.len(), 7);
}

#[test]
fn builtin_meshes_are_closed_and_face_outwards() {
    for builtin in BuiltinMesh::ALL.into_iter().chain([BuiltinMesh::SphereZ]) {
        let mesh = Mesh::builtin(builtin);
        let parts = mesh.parts();
        assert!(mesh.has_uv() && mesh.triangle_count() > 10_000, "{}", builtin.name());
        let mut volume = 0.0;
        let mut face_sum = DVec3::ZERO;
        for triangle in &parts.triangles {
            let [a, b, c] = triangle.map(|corner| parts.positions[corner as usize]);
            let cross = (b - a).cross(c - a);
            assert!(cross.length() > 0.0, "{} has an empty triangle", builtin.name());
            volume += a.dot(b.cross(c)) / 6.0;
            face_sum += cross;
            for corner in triangle {
                let cosine = parts.normals[*corner as usize].dot(cross.normalize());
                assert!(cosine > 0.9, "{} {triangle:?} {cosine}", builtin.name());
            }
        }
        assert!(face_sum.length() < 1e-9, "{} is not closed: {face_sum}", builtin.name());
        let pi = std::f64::consts::PI;
        let expected = match builtin {
            BuiltinMesh::Sphere | BuiltinMesh::SphereZ => 4.0 / 3.0 * pi,
            BuiltinMesh::Torus => 2.0 * pi * pi * 0.16,
            // Core box, six slabs, twelve quarter cylinders and a ball.
            BuiltinMesh::Cube => {
                1.728 + 6.0 * 1.44 * 0.2 + 3.0 * pi * 0.04 * 1.2 + 4.0 / 3.0 * pi * 0.008
            }
            BuiltinMesh::Ball | BuiltinMesh::Knob | BuiltinMesh::Ground => continue,
        };
        assert!((volume / expected - 1.0).abs() < 2e-3, "{} {volume} {expected}", builtin.name());
    }
}

#[test]
fn builtin_texture_coordinates_are_right_handed() {
    // n x u is the direction in which v grows: no face is mirrored.
    for builtin in BuiltinMesh::ALL {
        let parts = super::builtin::build(builtin);
        for triangle in &parts.triangles {
            let [a, b, c] = triangle.map(|corner| parts.uvs[corner as usize]);
            assert!((b - a).perp_dot(c - a) > 0.0, "{} {triangle:?}", builtin.name());
        }
    }
}

#[test]
fn sphere_with_pole_z_has_the_texture_of_mitsubas_sphere() {
    let parts = super::builtin::build(BuiltinMesh::SphereZ);
    let turn = std::f64::consts::TAU;
    for (vertex, place) in parts.positions.iter().enumerate() {
        let (uv, tangent) = (parts.uvs[vertex], parts.tangents[vertex]);
        // The position at u and v, and its derivative by u.
        let (phi, theta) = (uv.x * turn, uv.y * 0.5 * turn);
        let expected = DVec3::new(theta.sin() * phi.cos(), theta.sin() * phi.sin(), theta.cos());
        assert!((*place - expected).length() < 1e-12, "{place} {uv}");
        assert!((parts.normals[vertex] - expected).length() < 1e-12, "{place} {uv}");
        let along_u = DVec3::new(-phi.sin(), phi.cos(), 0.0);
        assert!((tangent - along_u).length() < 1e-12, "{place} {uv} {tangent}");
    }
    assert_eq!(BuiltinMesh::from_name(BuiltinMesh::SphereZ.name()), Some(BuiltinMesh::Sphere));
}

#[test]
fn exact_tangents_of_the_sphere_agree_with_least_squares() {
    let parts = super::builtin::build(BuiltinMesh::Sphere);
    let (fitted, fixed) =
        super::tangent::tangents(&parts.positions, &parts.normals, &parts.uvs, &parts.triangles);
    // At each pole the vertex of one column has no triangle.
    assert_eq!(fixed, 2);
    for (vertex, exact) in parts.tangents.iter().enumerate() {
        // Near the poles the neighbours reach around the axis.
        if parts.positions[vertex].y.abs() < 0.99 {
            let cosine = exact.dot(fitted[vertex]);
            assert!(cosine > 0.999, "{} {cosine}", parts.positions[vertex]);
        }
    }
}

fn awkward() -> impl Strategy<Value = f64> {
    prop::sample::select(vec![0.0, -0.0, 1.0, -1.0, 0.5, 1e-30, -1e-30, 3e38, -3e38, 1e-45, 1.0])
}

fn vertex() -> impl Strategy<Value = (DVec3, Option<DVec3>, Option<DVec2>)> {
    let vector = || (awkward(), awkward(), awkward()).prop_map(|(x, y, z)| DVec3::new(x, y, z));
    let uv = (awkward(), awkward()).prop_map(|(u, v)| DVec2::new(u, v));
    (vector(), prop::option::of(vector()), prop::option::of(uv))
}

proptest! {
    #[test]
    fn frames_are_unit_and_finite_when_input_is_degenerate(
        vertices in prop::collection::vec(vertex(), 3..12),
        corners in prop::collection::vec((0u32..12, 0u32..12, 0u32..12), 1..20),
    ) {
        let count = vertices.len() as u32;
        let raw = RawMesh {
            positions: vertices.iter().map(|vertex| vertex.0).collect(),
            normals: vertices.iter().map(|vertex| vertex.1).collect(),
            uvs: vertices.iter().map(|vertex| vertex.2).collect(),
            smooth_group: (0..count).collect(),
            smooth_groups: vertices.len(),
            triangles: corners.iter().map(|(a, b, c)| [a % count, b % count, c % count]).collect(),
        };
        let (parts, _) = assemble(raw);
        match Mesh::from_parts(parts) {
            Ok(_) | Err(MeshError::NoExtent) => {}
            Err(error) => prop_assert!(false, "{error}"),
        }
    }
}
