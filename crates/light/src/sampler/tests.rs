use std::f64::consts::PI;

use glam::DVec3;

use brood_mesh::{BuiltinMesh, LocalFrame, Mesh, UnitFrame};
use serde::Deserialize;

use super::*;
use crate::{EnvironmentMap, units};

/// Fields of a scene that lights depend on.
#[derive(Deserialize)]
#[serde(default, deny_unknown_fields)]
struct Lit {
    lights: Vec<Light>,
    light_deg: f64,
    scale: f64,
}

impl Default for Lit {
    fn default() -> Self {
        Self { lights: vec![Light::default()], light_deg: 0.0, scale: 1.0 }
    }
}

fn samplers_with(json: &str, assets: &LightAssets) -> Vec<LightSampler> {
    let Lit { lights, light_deg, scale } = serde_json::from_str(json).unwrap();
    for light in &lights {
        assert_eq!(light.validate(""), Ok(()), "{json}");
    }
    let frame = UnitFrame::new(&Mesh::builtin(BuiltinMesh::Sphere), scale, [0.0; 3]);
    LightSampler::all(&lights, light_deg, assets, &frame)
}

fn samplers(json: &str) -> Vec<LightSampler> {
    samplers_with(json, &LightAssets::default())
}

/// Returns directions and irradiances of the samples of a scene's only light at a position.
fn light_samples(json: &str, position: DVec3) -> Vec<(DVec3, [f64; 3])> {
    let mut all = Vec::new();
    let light = format!(r#"{{"lights": [{json}]}}"#);
    samplers(&light)[0].for_each_sample(&receiver(position), |_, light_sample| {
        all.push((light_sample.towards, light_sample.irradiance))
    });
    all
}

/// Surface with normal z, seen from above.
fn receiver(position: DVec3) -> Receiver {
    let frame = LocalFrame::new(DVec3::Z, DVec3::X);
    Receiver { position, frame, wo: DVec3::Z, seed: 1 }
}

fn near(a: f64, b: f64) -> bool {
    (a - b).abs() <= 1e-12 * (1.0 + b.abs())
}

#[test]
fn point_light_follows_inverse_square_law_in_every_unit() {
    for (field, expected) in [
        (r#""intensity": 8"#, 8.0),
        (r#""intensity_cd": 1432"#, 8.0),
        (r#""flux_w": 8"#, units::isotropic_intensity(8.0)),
        (r#""flux_lm": 1432"#, units::isotropic_intensity(8.0)),
    ] {
        let light = format!(r#"{{"position": [0, 3, 0], {field}}}"#);
        for (distance, y) in [(3.0, 0.0), (2.0, 1.0), (4.0, -1.0)] {
            let [(towards, [r, g, b])] = light_samples(&light, DVec3::Y * y)[..] else { panic!() };
            assert!((towards - DVec3::Y).length() < 1e-15);
            let expected = units::irradiance_at(expected, distance);
            assert!([r, g, b].into_iter().all(|e| near(e, expected)), "{field}: {r} {expected}");
        }
    }
    let dark = r#"{"position": [0, 3, 0], "flux_w": 0}"#;
    assert!(
        light_samples(dark, DVec3::ZERO).is_empty(),
        "a light without power must have no samples"
    );
}

#[test]
fn irradiance_uses_world_lengths_when_object_is_scaled() {
    // A length of 1 in the unit frame is 2 m here: the surface is 2 m from the object's centre.
    let scene = r#"{"scale": 2, "lights": [{"position": [0, 0, 5], "intensity": 9}]}"#;
    samplers(scene)[0].for_each_sample(&receiver(DVec3::Z), |_, light_sample| {
        assert!(
            near(light_sample.irradiance[0], 1.0),
            "9 W/sr from 3 m: {:?}",
            light_sample.irradiance
        );
    });
}

#[test]
fn spot_factor_is_one_in_hotspot_then_linear_in_cosine_then_zero() {
    let light = |extra: &str| {
        format!(
            r#"{{"kind": "spot", "position": [0, 10, 0], "axis": [0, -3, 0], "hotspot_deg": 20,
                "falloff_deg": 40, {extra}}}"#
        )
    };
    // Positions on the plane 10 m below the light, by their angle with the axis.
    let at = |extra: &str, degrees: f64| {
        let position = DVec3::new(10.0 * degrees.to_radians().tan(), 0.0, 0.0);
        let arriving = light_samples(&light(extra), position);
        let squared = 100.0 / degrees.to_radians().cos().powi(2);
        arriving.first().map(|(_, irradiance)| irradiance[0] * squared)
    };
    let cos = |degrees: f64| degrees.to_radians().cos();
    for degrees in [0.0, 10.0, 19.999] {
        assert!(near(at(r#""intensity": 5"#, degrees).unwrap(), 5.0), "{degrees}");
    }
    for degrees in [21.0, 30.0, 39.9] {
        let expected = 5.0 * (cos(degrees) - cos(40.0)) / (cos(20.0) - cos(40.0));
        assert!(near(at(r#""intensity": 5"#, degrees).unwrap(), expected), "{degrees}");
    }
    assert_eq!(at(r#""intensity": 5"#, 40.001), None);
    let peak = units::spot_intensity(1000.0 / 179.0, cos(20.0), cos(40.0));
    assert!(near(at(r#""flux_lm": 1000"#, 0.0).unwrap(), peak));
}

#[test]
fn default_spot_equals_default_point_light_at_centre_of_mesh() {
    let spot = light_samples(r#"{"kind": "spot"}"#, DVec3::ZERO);
    let point = light_samples("{}", DVec3::ZERO);
    assert_eq!(spot, point);
    assert!(near(spot[0].1[0], PI));
}

#[test]
fn directional_light_is_equal_everywhere_and_turns_with_light_deg() {
    let light = r#"{"kind": "directional", "direction": [0, 0, -2], "illuminance_lx": 358}"#;
    for position in [DVec3::ZERO, DVec3::new(3.0, 1.0, -4.0)] {
        assert_eq!(light_samples(light, position), [(DVec3::Z, [2.0; 3])]);
    }
    let scene = format!(r#"{{"light_deg": 90, "lights": [{light}]}}"#);
    samplers(&scene)[0].for_each_sample(&receiver(DVec3::ZERO), |_, light_sample| {
        assert!((light_sample.towards - DVec3::X).length() < 1e-15, "{:?}", light_sample.towards);
    });
    let default = light_samples(r#"{"kind": "directional"}"#, DVec3::ZERO);
    let point = light_samples("{}", DVec3::ZERO);
    assert!((default[0].0 - point[0].0).length() < 1e-15 && default[0].1 == [PI; 3]);
}

#[test]
fn ies_light_follows_its_profile_in_its_own_frame() {
    // 90 cd straight down, 90 cd at 90 degrees towards its y, 10 cd towards its x.
    let text = b"TILT=NONE\n1 -1 1 2 3 1 2 0 0 0\n1 1 60\n0 90\n0 90 180\n90 10\n90 90\n90 10\n";
    let mut assets = LightAssets::default();
    assets.insert_profile("a", std::sync::Arc::new(crate::IesProfile::parse(text).unwrap()));
    let at = |fields: &str, position: DVec3| {
        let json = format!(
            r#"{{"lights": [{{"kind": "ies", "profile": "a", "position": [0, 2, 0], {fields}}}]}}"#
        );
        let mut found = None;
        samplers_with(&json, &assets)[0].for_each_sample(&receiver(position), |_, light_sample| {
            let squared = (position - DVec3::Y * 2.0).length_squared();
            found = Some(light_sample.irradiance[0] * squared * 179.0);
        });
        found
    };
    let beside = |x: f64, z: f64| DVec3::new(x, 2.0, z);
    assert!(near(at(r#""axis": null"#, DVec3::ZERO).unwrap(), 90.0));
    // If the axis points down, its y points to -z, away from the default camera, and its x to +-x.
    assert!(near(at(r#""axis": [0, -1, 0]"#, beside(0.0, -3.0)).unwrap(), 90.0));
    assert!(near(at(r#""axis": [0, -1, 0]"#, beside(5.0, 0.0)).unwrap(), 10.0));
    assert!(near(at(r#""axis": [0, -1, 0], "up": [1, 0, 0]"#, beside(5.0, 0.0)).unwrap(), 90.0));
    assert!(at(r#""axis": [0, -1, 0]"#, DVec3::Y * 3.0).is_none(), "the profile is 0 upwards");
    let doubled = at(r#""intensity_cd": 180"#, DVec3::ZERO).unwrap();
    assert!(near(doubled, 180.0), "{doubled}");
    let lumens = assets.profile("a").unwrap().lumens();
    let scaled = at(&format!(r#""flux_lm": {}"#, 3.0 * lumens), DVec3::ZERO).unwrap();
    assert!((scaled - 270.0).abs() < 1e-9, "{scaled}");
}

/// Type C, all planes different: vertical angles 0, 30, 60 and 90, horizontal ones 0 to 360 in
/// steps of 45 degrees.
const ASYMMETRIC_C: &str = "IESNA:LM-63-2002\nTILT=NONE\n1 -1 1 4 9 1 2 0 0 0\n1 1 60\n0 30 60 90
0 45 90 135 180 225 270 315 360\n100 190 280 370\n100 232.5 322.5 412.5\n100 235 325 415
100 257.5 347.5 437.5\n100 280 370 460\n100 302.5 392.5 482.5\n100 325 415 505
100 347.5 437.5 527.5\n100 190 280 370\n";

/// Results of Radiance (`ies2rad`, `rtrace`, `source.cal` 2.10) for `ASYMMETRIC_C`: direction, with
/// z up and the luminaire aimed at -z, and candelas.
const RADIANCE_C: [([f64; 3], f64); 12] = [
    ([0.0, 0.0, -1.0], 100.0),
    ([0.5, 0.0, -0.866_025_4], 190.0),
    ([0.353_553_4, 0.353_553_4, -0.866_025_4], 232.5),
    ([0.0, 0.5, -0.866_025_4], 235.0),
    ([-0.353_553_4, 0.353_553_4, -0.866_025_4], 257.5),
    ([-0.5, 0.0, -0.866_025_4], 280.0),
    ([-0.353_553_4, -0.353_553_4, -0.866_025_4], 302.5),
    ([0.0, -0.5, -0.866_025_4], 325.0),
    ([0.353_553_4, -0.353_553_4, -0.866_025_4], 347.5),
    ([0.469_846_3, 0.171_010_1, -0.866_025_4], 208.888_9),
    ([0.813_797_7, 0.296_198_1, -0.5], 298.888_9),
    ([-0.296_198_1, -0.813_797_7, -0.5], 405.0),
];

/// Returns the candelas of a luminaire with the given fields (axis and up) in each direction.
fn candelas(profile: &str, fields: &str, directions: &[DVec3]) -> Vec<f64> {
    let profile = crate::IesProfile::parse(profile.as_bytes()).unwrap();
    let mut assets = LightAssets::default();
    assets.insert_profile("a", std::sync::Arc::new(profile));
    let place = DVec3::new(0.5, 3.0, -1.0);
    let json = format!(
        r#"{{"lights": [{{"kind": "ies", "profile": "a", "position": [0.5, 3, -1]{fields}}}]}}"#
    );
    let lights = samplers_with(&json, &assets);
    let mut found = Vec::new();
    for direction in directions {
        let position = receiver(place + *direction * 2.0);
        lights[0].for_each_sample(&position, |_, sample| {
            found.push(sample.irradiance[0] * 4.0 * 179.0);
        });
    }
    found
}

#[test]
fn ies_type_c_turns_counterclockwise_seen_from_above_as_in_radiance() {
    let expected = RADIANCE_C.map(|(_, candela)| candela);
    let near = |found: &[f64], case: &str| {
        assert_eq!(found.len(), expected.len(), "{case}");
        for (found, expected) in found.iter().zip(expected) {
            assert!((found - expected).abs() < 1e-3, "{case}: {found} {expected}");
        }
    };
    // The world is y up; Radiance's y points away from the default camera.
    let directions = RADIANCE_C.map(|([x, y, z], _)| DVec3::new(x, z, -y));
    near(&candelas(ASYMMETRIC_C, r#", "axis": [0, -1, 0]"#, &directions), "up omitted");
    for [x, y, z] in [[0.0, 0.0, 0.0], [0.0, 90.0, 0.0], [0.0, -130.0, 0.0], [20.0, 50.0, 70.0]] {
        let turn = brood_mesh::angle::rotation_xyz_deg([x, y, z]);
        let [axis, up] = [-DVec3::Y, -DVec3::Z].map(|w| (turn * w).to_array());
        let turned = directions.map(|direction| turn * direction);
        let fields = format!(r#", "axis": {axis:?}, "up": {up:?}"#);
        near(&candelas(ASYMMETRIC_C, &fields, &turned), &fields);
    }
}

#[test]
fn ies_types_a_and_b_turn_clockwise_seen_from_above() {
    // Horizontal angles grow to the right of the aim. Radiance's values for type B with its aim at
    // -z and up at +x, so that -y is on the right: 1150, 850, 1060, 940.
    let root = 0.75f64.sqrt();
    for photometry in [2, 3] {
        let mut profile = format!(
            "IESNA:LM-63-2002\nTILT=NONE\n1 -1 1 3 3 {photometry} 2 0 0 0\n1 1 60\n-90 0 90\n-90 0 90\n"
        );
        for horizontal in [-90.0, 0.0, 90.0] {
            let row = [-90.0, 0.0, 90.0].map(|vertical| 1000.0 + 2.0 * vertical + 5.0 * horizontal);
            profile.push_str(&row.map(|candela| candela.to_string()).join(" "));
            profile.push('\n');
        }
        let [right, up] = [DVec3::X, DVec3::Y];
        let aim = -DVec3::Z;
        let directions = [right, -right, up, -up].map(|side| aim * root + side * 0.5);
        let found = candelas(&profile, r#", "axis": [0, 0, -1]"#, &directions);
        for (found, expected) in found.iter().zip([1150.0, 850.0, 1060.0, 940.0]) {
            assert!((found - expected).abs() < 1e-6, "type {photometry}: {found} {expected}");
        }
        let [right, up] = [DVec3::Z, DVec3::X];
        let directions = [right, -right, up, -up].map(|side| -DVec3::Y * root + side * 0.5);
        let fields = r#", "axis": [0, -1, 0], "up": [1, 0, 0]"#;
        let found = candelas(&profile, fields, &directions);
        for (found, expected) in found.iter().zip([1150.0, 850.0, 1060.0, 940.0]) {
            assert!((found - expected).abs() < 1e-6, "type {photometry}: {found} {expected}");
        }
    }
}

/// Returns red irradiance times cosine at a position of a surface with normal z.
fn irradiance(json: &str, position: DVec3) -> f64 {
    light_samples(json, position).iter().map(|(towards, e)| e[0] * towards.z.max(0.0)).sum()
}

#[test]
fn sphere_irradiance_is_pi_l_sine_squared() {
    for (distance, radius) in [(2.0, 1.9), (3.0, 1.0), (50.0, 0.5), (4.0, 1e-3)] {
        let light = format!(
            r#"{{"kind": "sphere", "position": [0, 0, {distance}], "radius": {radius},
                "radiance_w_m2_sr": 3, "samples": 256}}"#
        );
        let expected = PI * 3.0 * (radius / distance) * (radius / distance);
        let found = irradiance(&light, DVec3::ZERO);
        assert!((found - expected).abs() < 1e-4 * expected, "{distance}: {found} {expected}");
    }
    // The default strength gives irradiance pi at the centre, as for a point light.
    let found = irradiance(r#"{"kind": "sphere", "position": [0, 0, 4]}"#, DVec3::ZERO);
    assert!((found - PI).abs() < 1e-3, "{found}");
    let inside = r#"{"kind": "sphere", "position": [0, 0, 1], "radius": 2}"#;
    assert!(light_samples(inside, DVec3::ZERO).is_empty(), "a sphere emits outwards only");
    let below = r#"{"kind": "sphere", "position": [0, 0, -3]}"#;
    assert!(light_samples(below, DVec3::ZERO).is_empty(), "the light is below the horizon");
}

#[test]
fn disk_irradiance_on_axis_matches_closed_form() {
    for (distance, radius) in [(1.0, 1.0), (5.0, 2.0), (0.5, 4.0)] {
        let light = format!(
            r#"{{"kind": "disk", "position": [0, 0, {distance}], "axis": [0, 0, -1],
                "radius": {radius}, "radiance_w_m2_sr": 2, "samples": 1024}}"#
        );
        let expected = PI * 2.0 * radius * radius / (radius * radius + distance * distance);
        let found = irradiance(&light, DVec3::ZERO);
        assert!((found - expected).abs() < 2e-3 * expected, "{distance}: {found} {expected}");
        assert!(light_samples(&light, DVec3::Z * 9.0).is_empty(), "a disk does not emit backwards");
    }
}

#[test]
fn rectangle_irradiance_matches_form_factor() {
    // A position below the middle of a square: four times the corner's factor (Howell, B-3).
    let (side, distance) = (2.0f64, 1.5f64);
    let half = 0.5 * side / distance;
    let root = (1.0 + half * half).sqrt();
    let factor = 4.0 / (2.0 * PI) * 2.0 * half / root * (half / root).atan();
    let light = format!(
        r#"{{"kind": "rectangle", "position": [0, 0, {distance}], "axis": [0, 0, -1],
            "width": {side}, "height": {side}, "luminance_nit": 179, "samples": 1024}}"#
    );
    let found = irradiance(&light, DVec3::ZERO);
    assert!((found - PI * factor).abs() < 1e-3, "{found} {}", PI * factor);
}

#[test]
fn flux_of_area_light_matches_distant_intensity() {
    // Far away every shape is a Lambertian point: its intensity is flux / pi on the axis of a flat
    // light, flux / (4 pi) for a sphere.
    for (kind, share) in [("disk", PI), ("rectangle", PI), ("sphere", 4.0 * PI)] {
        let light = format!(r#"{{"kind": "{kind}", "position": [0, 0, 1000], "flux_w": 5e6}}"#);
        let found = irradiance(&light, DVec3::ZERO);
        assert!((found - 5.0 / share).abs() < 1e-5, "{kind}: {found}");
    }
}

#[test]
fn single_ambient_sample_has_irradiance_pi_for_any_seed() {
    let wo = DVec3::new(0.6, -0.79, 0.125).normalize();
    let samplers = samplers(r#"{"lights": [{"kind": "ambient", "samples": 1}]}"#);
    for seed in 0..500 {
        let receiver = Receiver { wo, seed, ..receiver(DVec3::ZERO) };
        let mut sum = 0.0;
        samplers[0].for_each_sample(&receiver, |_, light_sample| {
            sum += light_sample.irradiance[0] * light_sample.towards.z.max(0.0);
        });
        assert!((sum - PI).abs() < 1e-12, "{seed}: {sum}");
    }
}

#[test]
fn ambient_irradiance_is_pi_and_uniform_environment_is_close_to_it() {
    let found = irradiance(r#"{"kind": "ambient", "samples": 64}"#, DVec3::ZERO);
    assert!((found - PI).abs() < 1e-12, "{found}");
    let scene = r#"{"lights": [{"kind": "environment", "image": "a", "scale": [2, 1, 1], "samples": 1024}]}"#;
    let mut assets = LightAssets::default();
    assert!(
        !samplers_with(scene, &assets)[0].is_soft(),
        "an environment without its picture must be dark"
    );
    let map = EnvironmentMap::new(8, 4, vec![[1.0; 3]; 32]).unwrap();
    assets.insert_environment("a", std::sync::Arc::new(map));
    let (mut sum, mut above) = (0.0, 0);
    samplers_with(scene, &assets)[0].for_each_sample(&receiver(DVec3::ZERO), |_, light_sample| {
        sum += light_sample.irradiance[0] * light_sample.towards.z.max(0.0);
        above += u32::from(light_sample.towards.z > 0.0);
    });
    assert!((sum - 2.0 * PI).abs() < 1e-2, "{sum}");
    assert!(above > 700, "expected more than 700 samples above the horizon, got {above}");
}

#[test]
fn environment_turns_with_rotation_deg_and_light_deg() {
    let mut pixels = vec![[0.0; 3]; 64 * 32];
    pixels[15 * 64 + 32] = [1.0; 3];
    let mut assets = LightAssets::default();
    let map = EnvironmentMap::new(64, 32, pixels).unwrap();
    assets.insert_environment("a", std::sync::Arc::new(map));
    for (scene, expected) in [
        (r#"{"lights": [{"kind": "environment", "image": "a"}]}"#, DVec3::NEG_Z),
        (
            r#"{"lights": [{"kind": "environment", "image": "a", "rotation_deg": 90}]}"#,
            DVec3::NEG_X,
        ),
        (r#"{"light_deg": 90, "lights": [{"kind": "environment", "image": "a"}]}"#, DVec3::NEG_X),
        (
            r#"{"light_deg": 90, "lights": [{"kind": "environment", "image": "a", "fixed": true}]}"#,
            DVec3::NEG_Z,
        ),
    ] {
        samplers_with(scene, &assets)[0].for_each_sample(
            &receiver(DVec3::ZERO),
            |_, light_sample| {
                assert!(light_sample.towards.dot(expected) > 0.99, "{}", light_sample.towards);
            },
        );
    }
}
