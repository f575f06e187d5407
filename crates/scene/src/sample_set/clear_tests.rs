//! Tests of clear bodies against formulas of the sphere.

use brood_light::LightAssets;
use brood_mesh::BuiltinMesh;

use super::*;
use crate::{PixelArea, Raster, Sampling, Scene};

const SIDE: u32 = 96;

fn points(mesh: &Mesh, json: &str) -> SampleSet {
    let scene: Scene = serde_json::from_str(json).unwrap();
    let (size_px, area) = (SIDE.into(), PixelArea::whole(SIDE));
    let raster = Raster { size_px, sampling: Sampling::Fixed(1), area };
    SampleSet::render_clear_points(mesh, &scene, &LightAssets::default(), raster)
}

/// Share at a quantile of values.
fn quantile(mut values: Vec<f64>, share: f64) -> f64 {
    values.sort_by(f64::total_cmp);
    values[(share * (values.len() - 1) as f64) as usize]
}

#[test]
fn ways_through_a_sphere_are_those_of_a_ball() {
    let mesh = Mesh::builtin(BuiltinMesh::Sphere);
    let set = points(&mesh, "{}");
    for index in [1.0, 1.33, 1.5, 2.0] {
        let ways = set.ways_out(&Stage::from(&mesh), index);
        let (mut angles, mut lengths, mut shares) = (Vec::new(), Vec::new(), Vec::new());
        for (point, ways) in set.seen.iter().zip(&ways) {
            let way = ways[0].expect("light enters a denser body");
            // In the plane of eye and normal, light turns by the same angle at both walls.
            let inside = (point.n.cross(point.eye).length() / index).asin();
            let outside = point.n.angle_between(point.eye);
            let axis = point.eye.cross(point.n).normalize_or(DVec3::Y);
            let turn = glam::DQuat::from_axis_angle(axis, 2.0 * (outside - inside));
            let expected = turn * -point.eye;
            angles.push(way.leaving.ray.direction.angle_between(expected).to_degrees());
            lengths.push((way.length - 2.0 * inside.cos()).abs());
            let (s, p) = by_angles(inside, outside);
            let mirrored = 0.5 * (s + p);
            let second = mirrored * (1.0 - mirrored);
            let expected = (1.0 - mirrored) / (1.0 - mirrored + second);
            shares.push((way.share - expected).abs());
            let sum: f64 = ways.iter().flatten().map(|way| way.share).sum();
            assert!((sum - 1.0).abs() < 1e-12, "{sum}");
        }
        assert!(quantile(angles.clone(), 0.9) < 0.05, "{index}: {:?}", quantile(angles, 0.9));
        assert!(quantile(lengths.clone(), 0.9) < 2e-3, "{index}: {}", quantile(lengths, 0.9));
        assert!(quantile(shares.clone(), 0.9) < 2e-3, "{index}: {}", quantile(shares, 0.9));
    }
}

/// Squares of Fresnel's amplitudes by the sines and tangents of the angles.
fn by_angles(inside: f64, outside: f64) -> (f64, f64) {
    if inside + outside < 1e-6 {
        return (0.0, 0.0);
    }
    let (minus, plus) = (inside - outside, inside + outside);
    ((minus.sin() / plus.sin()).powi(2), (minus.tan() / plus.tan()).powi(2))
}

#[test]
fn walls_mirror_by_fresnel() {
    for index in [0.5, 0.9, 1.05, 1.33, 1.5, 2.0f64] {
        for k in 1..90 {
            let inside = (f64::from(k) - 0.37).to_radians();
            let sine = index * inside.sin();
            let found = mirrored_share(inside.cos(), index);
            if sine >= 1.0 {
                assert!((found - 1.0).abs() < 1e-12, "{index} {k}");
                continue;
            }
            let (s, p) = by_angles(inside, sine.asin());
            assert!((found - 0.5 * (s + p)).abs() < 1e-9, "{index} {k}: {found}");
        }
    }
    let straight = ((1.5f64 - 1.0) / 2.5).powi(2);
    assert!((mirrored_share(1.0, 1.5) - straight).abs() < 1e-12);
}

#[test]
fn thinner_bodies_mirror_everything_at_the_limb() {
    let mesh = Mesh::builtin(BuiltinMesh::Sphere);
    let set = points(&mesh, "{}");
    let ways = set.ways_out(&Stage::from(&mesh), 0.5);
    let critical = 0.5f64.asin();
    for (point, ways) in set.seen.iter().zip(&ways) {
        let angle = point.n.angle_between(point.eye);
        if (angle - critical).abs() > 0.01 {
            assert_eq!(ways[0].is_some(), angle < critical, "{angle}");
        }
    }
}

#[test]
fn mirrored_rays_leave_the_surface_at_the_angle_of_the_eye() {
    for name in [BuiltinMesh::Sphere, BuiltinMesh::Knob, BuiltinMesh::Torus] {
        let mesh = Mesh::builtin(name);
        let set = points(&mesh, r#"{"rotation_deg": [20, 30, 0]}"#);
        let (mut by_shading, mut all) = (0, 0);
        for point in &set.seen {
            let direction = point.wall().mirrored(-point.eye).direction;
            assert!(direction.dot(point.face) > 0.0 && (direction.length() - 1.0).abs() < 1e-12);
            let expected = 2.0 * point.n.dot(point.eye) * point.n - point.eye;
            by_shading += u32::from((direction - expected).length() < 1e-9);
            all += 1;
        }
        assert!(all > 1000 && by_shading > all * 95 / 100, "{by_shading} of {all}");
    }
}

/// Rays that meet the body again are followed through it, unless another object is before it.
#[test]
fn ways_pass_through_the_body_that_they_meet_again() {
    let on_body = |mesh: &Mesh, ray: Ray| mesh.tracer().trace(ray, &mut Stack::default()).is_some();
    let torus = Mesh::builtin(BuiltinMesh::Torus);
    let json = r#"{"mesh": "torus", "rotation_deg": [60, 10, 0],
        "objects": [{"mesh": "sphere", "scale": 0.2}]}"#;
    let set = points(&torus, json);
    let alone = Stage::from(&torus);
    let mirrored = set.mirrored_ways(&alone, 1.5);
    let met = set.seen.iter().map(|point| on_body(&torus, point.wall().mirrored(-point.eye)));
    let met: Vec<bool> = met.collect();
    let (mut again, mut through, mut kept) = (0, 0, 0);
    for (met, way) in met.iter().zip(&mirrored) {
        assert!(*met || way.length == 0.0);
        again += u32::from(*met);
        through += u32::from(way.length > 0.0);
        kept += u32::from(on_body(&torus, way.leaving.ray));
    }
    assert!(again > 250 && through * 2 > again && kept * 20 < again, "{again} {through} {kept}");
    let ways = set.ways_out(&alone, 1.5);
    let stays = ways.iter().flatten().flatten().filter(|way| on_body(&torus, way.leaving.ray));
    assert!(stays.count() * 100 < ways.len());

    let scene: Scene = serde_json::from_str(json).unwrap();
    let sphere = Mesh::builtin(BuiltinMesh::Sphere);
    let among = set.mirrored_ways(&Stage::new(&scene, &torus, &[&sphere]), 1.5);
    let ends = |ways: &[WayOut]| ways.iter().filter(|way| on_body(&torus, way.leaving.ray)).count();
    assert!(ends(&among) > ends(&mirrored) + 20, "{} {}", ends(&among), ends(&mirrored));

    let sphere_points = points(&sphere, "{}");
    let ways = sphere_points.mirrored_ways(&Stage::from(&sphere), 1.5);
    assert!(ways.iter().all(|way| way.length == 0.0 && way.share == 1.0));
}

/// Ways leave closed meshes; a plane is no body.
#[test]
fn ways_leave_every_built_in_body() {
    for name in [BuiltinMesh::Ball, BuiltinMesh::Cube, BuiltinMesh::Torus, BuiltinMesh::Knob] {
        let mesh = Mesh::builtin(name);
        let set = points(&mesh, r#"{"rotation_deg": [20, 30, 0]}"#);
        let ways = set.ways_out(&Stage::from(&mesh), 1.33);
        let (mut left, mut long) = (0, 0);
        for way in ways.iter().flatten().flatten() {
            assert!(way.length >= 0.0, "{}", way.length);
            long += usize::from(way.length > 14.0);
            assert!((0.0..=1.0).contains(&way.share));
            assert!(way.leaving.ray.direction.is_normalized());
            left += 1;
        }
        assert!(left > set.len(), "{name:?}: {left} of {}", set.len());
        assert!(long * 100 < left, "{name:?}: {long} of {left} ways are long");
    }
}
