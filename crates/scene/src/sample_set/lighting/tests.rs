use std::f64::consts::PI;

use glam::DVec3;

use super::*;
use crate::sample_set::frame::ShadedPoint;
use crate::{BuiltinMesh, EnvironmentMap, Mesh, units};

fn lamps(json: &str) -> Vec<Lamp> {
    let scene: Scene = serde_json::from_str(json).unwrap();
    assert_eq!(scene.validate(), Ok(()), "{json}");
    Lamp::all(
        &scene,
        &LightAssets::default(),
        &UnitFrame::new(&Mesh::builtin(BuiltinMesh::Sphere), &scene),
    )
}

/// What arrives from the only light at a place: the directions and irradiances of its samples.
fn arriving(json: &str, place: DVec3) -> Vec<(DVec3, [f64; 3])> {
    let mut all = Vec::new();
    let light = format!(r#"{{"lights": [{json}]}}"#);
    lamps(&light)[0].arrivals(&asking(place, &up()), |_, arrival| {
        all.push((arrival.towards, arrival.irradiance))
    });
    all
}

/// A surface whose normal is z.
fn up() -> ShadedPoint {
    ShadedPoint::facing(DVec3::Z)
}

fn asking(place: DVec3, shaded: &ShadedPoint) -> Receiver<'_> {
    Receiver { place, shaded, seed: 1 }
}

fn near(a: f64, b: f64) -> bool {
    (a - b).abs() <= 1e-12 * (1.0 + b.abs())
}

#[test]
fn point_light_keeps_the_law_of_the_inverse_square_in_every_unit() {
    for (field, expected) in [
        (r#""intensity": 8"#, 8.0),
        (r#""intensity_cd": 1432"#, 8.0),
        (r#""flux_w": 8"#, units::isotropic_intensity(8.0)),
        (r#""flux_lm": 1432"#, units::isotropic_intensity(8.0)),
    ] {
        let light = format!(r#"{{"position": [0, 3, 0], {field}}}"#);
        for (distance, y) in [(3.0, 0.0), (2.0, 1.0), (4.0, -1.0)] {
            let [(towards, [r, g, b])] = arriving(&light, DVec3::Y * y)[..] else { panic!() };
            assert!((towards - DVec3::Y).length() < 1e-15);
            let expected = units::irradiance_at(expected, distance);
            assert!([r, g, b].into_iter().all(|e| near(e, expected)), "{field}: {r} {expected}");
        }
    }
    let dark = r#"{"position": [0, 3, 0], "flux_w": 0}"#;
    assert!(arriving(dark, DVec3::ZERO).is_empty(), "no power, no sample");
}

#[test]
fn lengths_of_the_world_are_those_of_the_object_however_large_it_is() {
    // The unit frame is half as large as the world here: the place of the object's surface is 2 m from its centre.
    let scene = r#"{"scale": 2, "lights": [{"position": [0, 0, 5], "intensity": 9}]}"#;
    lamps(scene)[0].arrivals(&asking(DVec3::Z, &up()), |_, arrival| {
        assert!(near(arrival.irradiance[0], 1.0), "9 W/sr from 3 m: {:?}", arrival.irradiance);
    });
}

#[test]
fn spot_is_full_in_its_hotspot_linear_in_the_cosine_beside_it_and_dark_outside() {
    let light = |extra: &str| {
        format!(
            r#"{{"kind": "spot", "position": [0, 10, 0], "axis": [0, -3, 0], "hotspot_deg": 20,
                "falloff_deg": 40, {extra}}}"#
        )
    };
    // Places on the plane 10 m below, by the angle with the axis.
    let at = |extra: &str, degrees: f64| {
        let place = DVec3::new(10.0 * degrees.to_radians().tan(), 0.0, 0.0);
        let arriving = arriving(&light(extra), place);
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
fn spot_without_axis_or_strength_gives_the_centre_of_the_mesh_what_a_point_light_does() {
    let spot = arriving(r#"{"kind": "spot"}"#, DVec3::ZERO);
    let point = arriving("{}", DVec3::ZERO);
    assert_eq!(spot, point);
    assert!(near(spot[0].1[0], PI));
}

#[test]
fn directional_light_is_the_same_everywhere_and_turns_on_the_circle() {
    let light = r#"{"kind": "directional", "direction": [0, 0, -2], "illuminance_lx": 358}"#;
    for place in [DVec3::ZERO, DVec3::new(3.0, 1.0, -4.0)] {
        assert_eq!(arriving(light, place), [(DVec3::Z, [2.0; 3])]);
    }
    let scene = format!(r#"{{"light_deg": 90, "lights": [{light}]}}"#);
    lamps(&scene)[0].arrivals(&asking(DVec3::ZERO, &up()), |_, arrival| {
        assert!((arrival.towards - DVec3::X).length() < 1e-15, "{:?}", arrival.towards);
    });
    let usual = arriving(r#"{"kind": "directional"}"#, DVec3::ZERO);
    let point = arriving("{}", DVec3::ZERO);
    assert!((usual[0].0 - point[0].0).length() < 1e-15 && usual[0].1 == [PI; 3]);
}

#[test]
fn luminaire_shines_as_its_profile_says_in_its_own_frame() {
    // 90 cd straight down, as many at 90 degrees towards its y, 10 towards its x.
    let text = b"TILT=NONE\n1 -1 1 2 3 1 2 0 0 0\n1 1 60\n0 90\n0 90 180\n90 10\n90 90\n90 10\n";
    let mut assets = LightAssets::default();
    assets.insert_profile("a", std::sync::Arc::new(crate::IesProfile::parse(text).unwrap()));
    let at = |fields: &str, place: DVec3| {
        let json = format!(
            r#"{{"lights": [{{"kind": "ies", "profile": "a", "position": [0, 2, 0], {fields}}}]}}"#
        );
        let scene: Scene = serde_json::from_str(&json).unwrap();
        let frame = UnitFrame::new(&Mesh::builtin(BuiltinMesh::Sphere), &scene);
        let mut found = None;
        Lamp::all(&scene, &assets, &frame)[0].arrivals(&asking(place, &up()), |_, arrival| {
            let squared = (place - DVec3::Y * 2.0).length_squared();
            found = Some(arrival.irradiance[0] * squared * 179.0);
        });
        found
    };
    let beside = |x: f64, z: f64| DVec3::new(x, 2.0, z);
    assert!(near(at(r#""axis": null"#, DVec3::ZERO).unwrap(), 90.0));
    // Downwards, its y goes away from the default camera, to -z, and its x to the right or left.
    assert!(near(at(r#""axis": [0, -1, 0]"#, beside(0.0, -3.0)).unwrap(), 90.0));
    assert!(near(at(r#""axis": [0, -1, 0]"#, beside(5.0, 0.0)).unwrap(), 10.0));
    assert!(near(at(r#""axis": [0, -1, 0], "up": [1, 0, 0]"#, beside(5.0, 0.0)).unwrap(), 90.0));
    assert!(at(r#""axis": [0, -1, 0]"#, DVec3::Y * 3.0).is_none(), "nothing upwards");
    let doubled = at(r#""intensity_cd": 180"#, DVec3::ZERO).unwrap();
    assert!(near(doubled, 180.0), "{doubled}");
    let lumens = assets.profile("a").unwrap().lumens();
    let scaled = at(&format!(r#""flux_lm": {}"#, 3.0 * lumens), DVec3::ZERO).unwrap();
    assert!((scaled - 270.0).abs() < 1e-9, "{scaled}");
}

/// Irradiance of a surface whose normal is z at a place, in red.
fn irradiance(json: &str, place: DVec3) -> f64 {
    arriving(json, place).iter().map(|(towards, e)| e[0] * towards.z.max(0.0)).sum()
}

#[test]
fn sphere_gives_pi_l_sine_squared() {
    for (distance, radius) in [(2.0, 1.9), (3.0, 1.0), (50.0, 0.5), (4.0, 1e-3)] {
        let light = format!(
            r#"{{"kind": "sphere", "position": [0, 0, {distance}], "radius": {radius},
                "radiance_w_m2_sr": 3, "samples": 256}}"#
        );
        let expected = PI * 3.0 * (radius / distance) * (radius / distance);
        let found = irradiance(&light, DVec3::ZERO);
        assert!((found - expected).abs() < 1e-4 * expected, "{distance}: {found} {expected}");
    }
    // The default is irradiance pi at the centre, as of a point.
    let found = irradiance(r#"{"kind": "sphere", "position": [0, 0, 4]}"#, DVec3::ZERO);
    assert!((found - PI).abs() < 1e-3, "{found}");
    let inside = r#"{"kind": "sphere", "position": [0, 0, 1], "radius": 2}"#;
    assert!(arriving(inside, DVec3::ZERO).is_empty(), "it shines outwards");
    let below = r#"{"kind": "sphere", "position": [0, 0, -3]}"#;
    assert!(arriving(below, DVec3::ZERO).is_empty(), "all of it below the horizon");
}

#[test]
fn disk_on_the_axis_gives_pi_l_times_its_share_of_the_sky() {
    for (distance, radius) in [(1.0, 1.0), (5.0, 2.0), (0.5, 4.0)] {
        let light = format!(
            r#"{{"kind": "disk", "position": [0, 0, {distance}], "axis": [0, 0, -1],
                "radius": {radius}, "radiance_w_m2_sr": 2, "samples": 1024}}"#
        );
        let expected = PI * 2.0 * radius * radius / (radius * radius + distance * distance);
        let found = irradiance(&light, DVec3::ZERO);
        assert!((found - expected).abs() < 2e-3 * expected, "{distance}: {found} {expected}");
        assert!(arriving(&light, DVec3::Z * 9.0).is_empty(), "nothing behind it");
    }
}

#[test]
fn rectangle_gives_what_its_form_factor_says() {
    // A place below the middle of a square: four times the corner's factor (Howell, B-3).
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
fn flux_of_an_area_is_what_passes_through_everything_around_it() {
    // Far away every shape is a lambertian point: flux over pi is the intensity of its front, over 4 pi that of a ball.
    for (kind, share) in [("disk", PI), ("rectangle", PI), ("sphere", 4.0 * PI)] {
        let light = format!(r#"{{"kind": "{kind}", "position": [0, 0, 1000], "flux_w": 5e6}}"#);
        let found = irradiance(&light, DVec3::ZERO);
        assert!((found - 5.0 / share).abs() < 1e-5, "{kind}: {found}");
    }
}

#[test]
fn one_sample_of_ambient_light_gives_pi_wherever_it_is_drawn() {
    let mut aslant = up();
    aslant.wo = DVec3::new(0.6, -0.79, 0.125).normalize();
    let lamps = lamps(r#"{"lights": [{"kind": "ambient", "samples": 1}]}"#);
    for seed in 0..500 {
        let receiver = Receiver { place: DVec3::ZERO, shaded: &aslant, seed };
        let mut sum = 0.0;
        lamps[0].arrivals(&receiver, |_, arrival| {
            sum += arrival.irradiance[0] * arrival.towards.z.max(0.0);
        });
        assert!((sum - PI).abs() < 1e-12, "{seed}: {sum}");
    }
}

#[test]
fn ambient_light_gives_pi_and_an_even_environment_nearly_so() {
    let found = irradiance(r#"{"kind": "ambient", "samples": 64}"#, DVec3::ZERO);
    assert!((found - PI).abs() < 1e-12, "{found}");
    let scene: Scene = serde_json::from_str(
        r#"{"lights": [{"kind": "environment", "image": "a", "scale": [2, 1, 1], "samples": 1024}]}"#,
    )
    .unwrap();
    let frame = UnitFrame::new(&Mesh::builtin(BuiltinMesh::Sphere), &scene);
    let mut assets = LightAssets::default();
    assert!(!Lamp::all(&scene, &assets, &frame)[0].is_soft(), "dark without its picture");
    let map = EnvironmentMap::new(8, 4, vec![[1.0; 3]; 32]).unwrap();
    assets.insert_environment("a", std::sync::Arc::new(map));
    let (mut sum, mut above) = (0.0, 0);
    Lamp::all(&scene, &assets, &frame)[0].arrivals(&asking(DVec3::ZERO, &up()), |_, arrival| {
        sum += arrival.irradiance[0] * arrival.towards.z.max(0.0);
        above += u32::from(arrival.towards.z > 0.0);
    });
    assert!((sum - 2.0 * PI).abs() < 1e-2, "{sum}");
    assert!(above > 700, "of its own directions one half is above: {above}");
}

#[test]
fn environment_turns_with_its_rotation_and_on_the_circle() {
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
    ] {
        let scene: Scene = serde_json::from_str(scene).unwrap();
        let frame = UnitFrame::new(&Mesh::builtin(BuiltinMesh::Sphere), &scene);
        Lamp::all(&scene, &assets, &frame)[0].arrivals(
            &asking(DVec3::ZERO, &up()),
            |_, arrival| {
                assert!(arrival.towards.dot(expected) > 0.99, "{}", arrival.towards);
            },
        );
    }
}
