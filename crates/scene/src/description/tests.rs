use brood_light::Light;
use brood_mesh::BuiltinMesh;
use utoipa::PartialSchema;

use super::{
    Camera, Exposure, LookAtCamera, MeshRef, Normals, OrbitCamera, OrthographicCamera, Scene,
    SpherePole, Tangents, Tone,
};

fn read(json: &str) -> Result<Scene, String> {
    serde_json::from_str(json).map_err(|error| error.to_string())
}

#[test]
fn scene_has_a_default_for_every_field_when_the_object_is_empty() {
    let scene = read("{}").unwrap();
    assert_eq!(scene, Scene::default());
    assert_eq!(scene.validate(), Ok(()));
    assert_eq!(read(r#"{"lights": [{}], "film": {}, "camera": {}}"#).unwrap(), scene);
    assert_eq!(read(r#"{"camera": {"distance": null}}"#).unwrap(), scene);
}

#[test]
fn scene_round_trips_through_json() {
    let mut scenes = vec![Scene::default()];
    let cameras = [
        Camera::Orbit(OrbitCamera {
            orbit_deg: [-20.0, 90.0],
            distance: Some(3.25),
            fov_y_deg: 45.0,
        }),
        Camera::LookAt(LookAtCamera {
            eye: [1.0, 2.0, 3.0],
            target: [0.1, 0.0, 0.0],
            up: [0.0, 0.0, 1.0],
            fov_y_deg: 12.5,
        }),
        Camera::Orthographic(OrthographicCamera { orthographic: 1.05 }),
    ];
    for camera in cameras {
        let mut scene = Scene { camera, scale: 0.5, ..Scene::default() }.with_light_deg(45.0);
        scene.mesh = MeshRef::from("0199-ab");
        scene.film.exposure = Exposure::Ev(-1.5);
        scene.shadows = !scenes.len().is_multiple_of(2);
        scene.tangents = if scenes.len() == 1 { Tangents::Triangle } else { Tangents::Vertex };
        scene.normals = if scenes.len() == 2 { Normals::Plain } else { Normals::Curved };
        let spot = r#"{"kind": "spot", "flux_lm": 900}"#;
        scene.lights.push(serde_json::from_str(spot).unwrap());
        scenes.push(scene);
    }
    scenes.push(Scene { sphere_pole: SpherePole::Z, ..Scene::default() });
    for scene in scenes {
        let json = serde_json::to_string(&scene).unwrap();
        assert_eq!(read(&json).unwrap(), scene, "{json}");
        assert_eq!(scene.validate(), Ok(()));
    }
}

#[test]
fn lit_spheres_depend_on_camera_and_environments_alone() {
    let spheres = |json: &str| read(json).unwrap().for_spheres(1);
    let own = spheres(r#"{"lights": [{"kind": "environment", "image": "studio", "fixed": true}]}"#);
    let other = r#"{"mesh": "ball", "rotation_deg": [1, 2, 3], "scale": 2, "light_deg": 40,
        "film": {"exposure": -2, "tone": "filmic"}, "tangents": "triangle",
        "lights": [{}, {"kind": "environment", "image": "studio", "fixed": true}]}"#;
    assert_eq!(spheres(other), own);
    assert_ne!(spheres(&other.replace("studio", "interior")), own);
    assert_ne!(
        spheres(&other.replace(r#"{"mesh""#, r#"{"camera": {"fov_y_deg": 20}, "mesh""#)),
        own
    );
    let backdrop = |kind: &str| other.replacen('{', &format!(r#"{{"backdrop": {kind}, "#), 1);
    assert_eq!(spheres(&backdrop(r#"{"kind": "color", "color": [1, 0, 0]}"#)), own);
    assert_ne!(spheres(&backdrop(r#"{"kind": "environment"}"#)), own);
    let turning = other.replace(r#", "fixed": true"#, "");
    assert_ne!(spheres(&turning), spheres(&turning.replace("40", "50")));
    // Spheres of several turns serve all rotations of the environments as a whole.
    let turned = |json: &str| read(json).unwrap().for_spheres(18);
    assert_eq!(turned(&turning), turned(&turning.replace("40", "50")));
    let with_sky = other.replace("[{}", r#"[{"kind": "environment", "image": "overcast"}"#);
    assert_ne!(turned(&with_sky), turned(&with_sky.replace("40", "50")));
    let lit = r#"{"kind": "environment", "blur_deg": 5}"#;
    assert_eq!(turned(&backdrop(lit)), turned(other));
}

#[test]
fn scene_json_matches_the_api() {
    let json = serde_json::to_value(Scene::default()).unwrap();
    let expected = serde_json::json!({
        "mesh": "sphere", "rotation_deg": [0.0, 0.0, 0.0], "scale": 1.0,
        "camera": {"orbit_deg": [30.0, 20.0], "distance": null, "fov_y_deg": 30.0},
        "lights": [{"kind": "point", "position": null, "intensity": null}],
        "film": {"exposure": "auto", "tone": "none"}, "light_deg": 0.0,
    });
    assert_eq!(json, expected);
    assert_eq!(read(r#"{"film": {"exposure": 2}}"#).unwrap().film.exposure, Exposure::Ev(2.0));
    assert_eq!(Tone::default(), Tone::None);
    for tone in Tone::ALL {
        let json = format!(r#"{{"film": {{"tone": "{}"}}}}"#, tone.name());
        assert_eq!(read(&json).unwrap().film.tone, tone);
    }
    for mesh in BuiltinMesh::ALL {
        assert_eq!(MeshRef::from(mesh.name()), MeshRef::Builtin(mesh));
    }
}

#[test]
fn scene_is_rejected_with_a_readable_reason_when_json_is_wrong() {
    let cases = [
        (r#"{"colour": 1}"#, "unknown field `colour`"),
        (r#"{"camera": {"orbit": 1}}"#, "unknown field `orbit`"),
        (r#"{"camera": {"eye": [0,0,1], "orbit_deg": [1,2]}}"#, "not both orbit_deg and eye"),
        (r#"{"camera": {"target": [0,0,1]}}"#, "needs eye"),
        (r#"{"camera": {"orthographic": 1, "fov_y_deg": 3}}"#, "has no fov_y_deg"),
        (r#"{"camera": 7}"#, "expected a camera object"),
        (r#"{"film": {"exposure": "bright"}}"#, "expected \"auto\" or a number of EV"),
        (r#"{"film": {"exposure": []}}"#, "expected \"auto\" or a number of EV"),
        (r#"{"film": {"tone": "aces"}}"#, "unknown variant `aces`"),
        (r#"{"lights": [{"power": 1}]}"#, "a light of kind point has no field `power`"),
        (r#"{"scale": 1, "scale": 2}"#, "duplicate field `scale`"),
        (r#"{"rotation_deg": [1, 2]}"#, "invalid length 2"),
        (r#"{"tangents": "face"}"#, "unknown variant `face`, expected `vertex` or `triangle`"),
        (r#"{"sphere_pole": "x"}"#, "unknown variant `x`, expected `y` or `z`"),
        (r#"{"backdrop": {"kind": "sky"}}"#, "unknown variant `sky`"),
        (r#"{"backdrop": 3}"#, "expected an object with the field `kind`"),
        (r#"{"backdrop": {"blur_deg": 3}}"#, "missing field `kind`"),
        (r#"{"backdrop": {"kind": "color", "colour": [0, 0, 0]}}"#, "unknown field `colour`"),
    ];
    for (json, expected) in cases {
        let error = read(json).unwrap_err();
        assert!(error.contains(expected), "{json}: {error}");
    }
}

#[test]
fn scene_is_rejected_with_a_pointer_when_a_number_is_out_of_range() {
    let with_camera = |json: &str| read(&format!(r#"{{"camera": {json}}}"#)).unwrap();
    let mut cases = vec![
        (with_camera(r#"{"fov_y_deg": 170}"#), "/camera/fov_y_deg"),
        (with_camera(r#"{"fov_y_deg": 0.1}"#), "/camera/fov_y_deg"),
        (with_camera(r#"{"orbit_deg": [0, 90.5]}"#), "/camera/orbit_deg/1"),
        (with_camera(r#"{"distance": 0}"#), "/camera/distance"),
        (with_camera(r#"{"eye": [0, 0, 0]}"#), "/camera/eye"),
        (with_camera(r#"{"eye": [0, 2, 0]}"#), "/camera/up"),
        (with_camera(r#"{"eye": [0, 0, 1], "up": [0, 0, 0]}"#), "/camera/up"),
        (with_camera(r#"{"orthographic": -1}"#), "/camera/orthographic"),
        (read(r#"{"scale": 0}"#).unwrap(), "/scale"),
        (read(r#"{"scale": 1000.1}"#).unwrap(), "/scale"),
        (read(r#"{"mesh": ""}"#).unwrap(), "/mesh"),
        (read(r#"{"mesh": "knob", "sphere_pole": "z"}"#).unwrap(), "/sphere_pole"),
        (read(r#"{"mesh": "0199-ab", "sphere_pole": "z"}"#).unwrap(), "/sphere_pole"),
        (read(r#"{"lights": []}"#).unwrap(), "/lights"),
        (read(r#"{"backdrop": {"kind": "environment"}}"#).unwrap(), "/backdrop/kind"),
        (
            read(r#"{"backdrop": {"kind": "environment", "blur_deg": 91}}"#).unwrap(),
            "/backdrop/blur_deg",
        ),
        (
            read(r#"{"backdrop": {"kind": "color", "color": [0, 1.1, 0]}}"#).unwrap(),
            "/backdrop/color",
        ),
        (read(r#"{"lights": [{}, {"position": [0, 1e39, 0]}]}"#).unwrap(), "/lights/1/position"),
        (read(r#"{"film": {"exposure": 65}}"#).unwrap(), "/film/exposure"),
    ];
    cases.push((Scene { scale: f64::NAN, ..Scene::default() }, "/scale"));
    cases.push((Scene { rotation_deg: [0.0, f64::NAN, 0.0], ..Scene::default() }, "/rotation_deg"));
    cases.push((Scene::default().with_light_deg(f64::INFINITY), "/light_deg"));
    cases.push((Scene { lights: vec![Light::default(); 17], ..Scene::default() }, "/lights"));
    for (scene, pointer) in cases {
        assert_eq!(scene.validate().unwrap_err().pointer, pointer, "{scene:?}");
    }
}

#[test]
fn scene_is_accepted_when_numbers_are_at_the_ends_of_their_ranges() {
    let lights: Vec<&str> = vec!["{}"; 16];
    let lights = format!(r#"{{"lights": [{}]}}"#, lights.join(","));
    let cases = [
        r#"{"scale": 1000}"#,
        r#"{"scale": 1e-3}"#,
        r#"{"camera": {"fov_y_deg": 169.9}}"#,
        r#"{"camera": {"fov_y_deg": 0.2}}"#,
        r#"{"camera": {"orbit_deg": [720, 90]}}"#,
        r#"{"film": {"exposure": 64}}"#,
        r#"{"film": {"exposure": -64}}"#,
        &lights,
    ];
    for json in cases {
        assert_eq!(read(json).unwrap().validate(), Ok(()), "{json}");
    }
}

#[test]
fn conventions_are_written_only_if_they_differ_from_their_defaults() {
    let plain = serde_json::to_string(&Scene::default()).unwrap();
    let json = r#"{"normals": "curved", "tangents": "vertex", "sphere_pole": "y"}"#;
    assert_eq!(serde_json::to_string(&read(json).unwrap()).unwrap(), plain);
    let json = r#"{"tangents": "triangle", "sphere_pole": "z"}"#;
    let written = serde_json::to_value(read(json).unwrap()).unwrap();
    assert_eq!((&written["tangents"], &written["sphere_pole"]), (&"triangle".into(), &"z".into()));
}

#[test]
fn sphere_pole_selects_the_built_in_sphere() {
    let builtin = |json: &str| read(json).unwrap().builtin();
    assert_eq!(builtin("{}"), Some(BuiltinMesh::Sphere));
    assert_eq!(builtin(r#"{"sphere_pole": "z"}"#), Some(BuiltinMesh::SphereZ));
    assert_eq!(builtin(r#"{"mesh": "knob"}"#), Some(BuiltinMesh::Knob));
    assert_eq!(builtin(r#"{"mesh": "0199-ab"}"#), None);
}

#[test]
fn schema_names_every_field_and_rejects_others() {
    let camera = serde_json::to_value(Camera::schema()).unwrap();
    let forms = camera["oneOf"].as_array().unwrap();
    assert_eq!(forms.len(), 3);
    for form in forms {
        assert_eq!(form["additionalProperties"], false, "{form}");
    }
    assert_eq!(forms[1]["required"], serde_json::json!(["eye"]));
    let scene = serde_json::to_value(Scene::schema()).unwrap();
    let written = serde_json::to_value(Scene::default()).unwrap();
    for field in written.as_object().unwrap().keys() {
        assert!(scene["properties"][field].is_object(), "{field}: {scene}");
    }
    assert!(scene["required"].is_null(), "every field has a default: {scene}");
}

#[test]
fn objects_and_ground_of_another_type_are_refused_in_plain_words() {
    for json in [r#"{"ground": true}"#, r#"{"objects": [7]}"#] {
        let error = read(json).unwrap_err();
        assert!(error.contains("expected an object"), "{error}");
    }
}
