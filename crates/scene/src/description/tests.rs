use super::{
    BuiltinMesh, Camera, Exposure, Light, MeshRef, Normals, PointLight, Quantity, Scene, SpotLight,
    Strength, Tone,
};

/// Lights of every kind, with all fields.
pub(super) const LIGHTS: [&str; 13] = [
    r#"{"kind":"sphere","position":null,"radius":null,"radiance_w_m2_sr":null,"samples":16}"#,
    r#"{"kind":"disk","position":[1.0,2.0,3.0],"axis":null,"radius":0.5,"flux_lm":[9.0,9.0,9.0],"samples":7}"#,
    r#"{"kind":"rectangle","position":null,"axis":null,"up":[0.0,0.0,1.0],"width":2.0,"height":null,"luminance_nit":[1.0,2.0,3.0],"samples":1}"#,
    r#"{"kind":"environment","image":"sky.hdr","rotation_deg":90.0,"scale":[2.0,2.0,2.0],"samples":256}"#,
    r#"{"kind":"ambient","radiance_w_m2_sr":[0.5,0.5,0.5],"samples":64}"#,
    r#"{"kind":"ies","position":null,"axis":[0.0,-1.0,0.0],"up":null,"profile":"a.ies","flux_lm":[9.0,9.0,9.0]}"#,
    r#"{"kind":"point","position":[3.0,4.0,5.0],"intensity":[1.0,0.5,0.25]}"#,
    r#"{"kind":"point","position":null,"flux_lm":[800.0,800.0,800.0]}"#,
    r#"{"kind":"point","position":null,"intensity_cd":[9.0,8.0,7.0]}"#,
    r#"{"kind":"directional","direction":[0.0,-1.0,0.5],"illuminance_lx":[1e5,1e5,1e5]}"#,
    r#"{"kind":"directional","direction":null,"irradiance_w_m2":null}"#,
    r#"{"kind":"spot","position":[0.0,5.0,0.0],"axis":null,"hotspot_deg":10.0,"falloff_deg":15.0,"flux_w":[4.0,4.0,4.0]}"#,
    r#"{"kind":"spot","position":null,"axis":[0.0,-2.0,0.0],"hotspot_deg":5.0,"falloff_deg":5.0,"intensity":null}"#,
];

#[test]
fn light_round_trips_through_json() {
    for json in LIGHTS {
        let light: Light = serde_json::from_str(json).unwrap();
        let written: serde_json::Value = serde_json::to_value(&light).unwrap();
        assert_eq!(written, serde_json::from_str::<serde_json::Value>(json).unwrap());
        assert_eq!(written["kind"], light.kind());
    }
    let short = r#"{"lights": [{"kind": "spot", "flux_lm": 900}, {"intensity": 3}]}"#;
    let scene = read(short).unwrap();
    let expected = SpotLight {
        strength: Some(Strength::white(Quantity::FluxLm, 900.0)),
        ..SpotLight::default()
    };
    assert_eq!(scene.lights[0], Light::Spot(expected));
    let point = PointLight {
        strength: Some(Strength::white(Quantity::Intensity, 3.0)),
        ..PointLight::default()
    };
    assert_eq!(scene.lights[1], Light::Point(point));
}

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
fn scene_round_trips_through_json_and_binary() {
    let mut scenes = vec![Scene::default()];
    let cameras = [
        Camera::Orbit { orbit_deg: [-20.0, 90.0], distance: Some(3.25), fov_y_deg: 45.0 },
        Camera::LookAt {
            eye: [1.0, 2.0, 3.0],
            target: [0.1, 0.0, 0.0],
            up: [0.0, 0.0, 1.0],
            fov_y_deg: 12.5,
        },
        Camera::Orthographic { orthographic: 1.05 },
    ];
    for camera in cameras {
        let mut scene = Scene { camera, scale: 0.5, ..Scene::default() }.with_light_deg(45.0);
        scene.mesh = MeshRef::from("0199-ab");
        scene.film.exposure = Exposure::Ev(-1.5);
        scene.shadows = !scenes.len().is_multiple_of(2);
        scene.normals = if scenes.len() == 2 { Normals::Plain } else { Normals::Curved };
        scene.lights.extend(LIGHTS.map(|json| serde_json::from_str(json).unwrap()));
        scenes.push(scene);
    }
    for scene in scenes {
        let json = serde_json::to_string(&scene).unwrap();
        assert_eq!(read(&json).unwrap(), scene, "{json}");
        let bytes = postcard::to_stdvec(&scene).unwrap();
        assert_eq!(postcard::from_bytes::<Scene>(&bytes).unwrap(), scene, "{json}");
        assert_eq!(scene.validate(), Ok(()));
    }
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
        (r#"{"lights": [{"kind": "laser"}]}"#, "unknown variant `laser`, expected one of `point`"),
        (r#"{"lights": [{"kind": "ies"}]}"#, "a light of kind ies needs a profile"),
        (r#"{"lights": [{"hotspot_deg": 5}]}"#, "a light of kind point has no field `hotspot_deg`"),
        (
            r#"{"lights": [{"kind": "directional", "flux_w": 5}]}"#,
            "a light of kind directional has no field `flux_w`",
        ),
        (
            r#"{"lights": [{"intensity": 5, "flux_lm": 5}]}"#,
            "given once, not by both intensity and flux_lm",
        ),
        (r#"{"lights": [{"intensity": [1, 2]}]}"#, "a number or [red, green, blue]"),
        (r#"{"lights": [{"power": 1}]}"#, "unknown field `power`"),
        (r#"{"scale": 1, "scale": 2}"#, "duplicate field `scale`"),
        (r#"{"rotation_deg": [1, 2]}"#, "invalid length 2"),
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
        (read(r#"{"lights": []}"#).unwrap(), "/lights"),
        (read(r#"{"lights": [{}, {"position": [0, 1e39, 0]}]}"#).unwrap(), "/lights/1/position"),
        (read(r#"{"lights": [{"intensity": [0, -1, 0]}]}"#).unwrap(), "/lights/0/intensity"),
        (read(r#"{"film": {"exposure": 65}}"#).unwrap(), "/film/exposure"),
    ];
    let lights = [
        (r#"{"flux_w": -1}"#, "/lights/0/flux_w"),
        (r#"{"intensity_cd": 1e39}"#, "/lights/0/intensity_cd"),
        (r#"{"kind": "directional", "direction": [0, 0, 0]}"#, "/lights/0/direction"),
        (r#"{"kind": "directional", "illuminance_lx": -1}"#, "/lights/0/illuminance_lx"),
        (r#"{"kind": "sphere", "radius": 0}"#, "/lights/0/radius"),
        (r#"{"kind": "disk", "samples": 0}"#, "/lights/0/samples"),
        (r#"{"kind": "rectangle", "height": -1}"#, "/lights/0/height"),
        (r#"{"kind": "rectangle", "samples": 1025}"#, "/lights/0/samples"),
        (r#"{"kind": "environment", "image": ""}"#, "/lights/0/image"),
        (r#"{"kind": "environment", "image": "a", "scale": -1}"#, "/lights/0/scale"),
        (r#"{"kind": "ambient", "luminance_nit": -1}"#, "/lights/0/luminance_nit"),
        (r#"{"kind": "ies", "profile": ""}"#, "/lights/0/profile"),
        (r#"{"kind": "ies", "profile": "a", "up": [0, 0, 0]}"#, "/lights/0/up"),
        (r#"{"kind": "spot", "position": [0, 1e40, 0]}"#, "/lights/0/position"),
        (r#"{"kind": "spot", "axis": [0, 0, 0]}"#, "/lights/0/axis"),
        (r#"{"kind": "spot", "hotspot_deg": 16}"#, "/lights/0/hotspot_deg"),
        (r#"{"kind": "spot", "hotspot_deg": -1}"#, "/lights/0/hotspot_deg"),
        (r#"{"kind": "spot", "falloff_deg": 181}"#, "/lights/0/falloff_deg"),
        (r#"{"kind": "spot", "hotspot_deg": 0, "falloff_deg": 0}"#, "/lights/0/falloff_deg"),
    ];
    for (json, pointer) in lights {
        cases.push((read(&format!(r#"{{"lights": [{json}]}}"#)).unwrap(), pointer));
    }
    let wrong = PointLight {
        strength: Some(Strength::white(Quantity::LuminanceNit, 1.0)),
        ..PointLight::default()
    };
    let wrong = Scene { lights: vec![Light::Point(wrong)], ..Scene::default() };
    cases.push((wrong, "/lights/0/luminance_nit"));
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
        r#"{"lights": [{"kind": "disk", "samples": 1024}]}"#,
        r#"{"lights": [{"kind": "spot", "hotspot_deg": 0, "falloff_deg": 180}]}"#,
        &lights,
    ];
    for json in cases {
        assert_eq!(read(json).unwrap().validate(), Ok(()), "{json}");
    }
}
