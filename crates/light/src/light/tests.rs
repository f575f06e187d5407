use utoipa::PartialSchema;

use super::{Light, PointLight, Quantity, SpotLight, Strength};

/// Lights of every kind, with all fields.
const LIGHTS: [&str; 14] = [
    r#"{"kind":"sphere","position":null,"radius":null,"radiance_w_m2_sr":null,"samples":16}"#,
    r#"{"kind":"disk","position":[1.0,2.0,3.0],"axis":null,"radius":0.5,"flux_lm":[9.0,9.0,9.0],"samples":7}"#,
    r#"{"kind":"rectangle","position":null,"axis":null,"up":[0.0,0.0,1.0],"width":2.0,"height":null,"luminance_nit":[1.0,2.0,3.0],"samples":1}"#,
    r#"{"kind":"environment","image":"sky.hdr","rotation_deg":90.0,"scale":[2.0,2.0,2.0],"samples":256}"#,
    r#"{"kind":"environment","image":"studio","rotation_deg":0.0,"scale":[1.0,1.0,1.0],"samples":64,"fixed":true}"#,
    r#"{"kind":"ambient","radiance_w_m2_sr":[0.5,0.5,0.5],"samples":64}"#,
    r#"{"kind":"ies","position":null,"axis":[0.0,-1.0,0.0],"up":null,"profile":"a.ies","flux_lm":[9.0,9.0,9.0]}"#,
    r#"{"kind":"point","position":[3.0,4.0,5.0],"intensity":[1.0,0.5,0.25]}"#,
    r#"{"kind":"point","position":null,"flux_lm":[800.0,800.0,800.0]}"#,
    r#"{"kind":"point","position":null,"intensity_cd":[9.0,8.0,7.0]}"#,
    r#"{"kind":"directional","direction":[0.0,-1.0,0.5],"illuminance_lx":[100000.0,100000.0,100000.0]}"#,
    r#"{"kind":"directional","direction":null,"irradiance_w_m2":null}"#,
    r#"{"kind":"spot","position":[0.0,5.0,0.0],"axis":null,"hotspot_deg":10.0,"falloff_deg":15.0,"flux_w":[4.0,4.0,4.0]}"#,
    r#"{"kind":"spot","position":null,"axis":[0.0,-2.0,0.0],"hotspot_deg":5.0,"falloff_deg":5.0,"intensity":null}"#,
];

fn read(json: &str) -> Result<Light, String> {
    serde_json::from_str(json).map_err(|error| error.to_string())
}

#[test]
fn light_round_trips_through_json() {
    for json in LIGHTS {
        let light = read(json).unwrap();
        // Ids and picture keys hash this text, so the order of the fields matters.
        assert_eq!(serde_json::to_string(&light).unwrap(), json);
        assert!(json.starts_with(&format!(r#"{{"kind":"{}""#, light.kind())), "{json}");
        assert_eq!(light.validate(""), Ok(()), "{json}");
    }
    let expected = SpotLight {
        strength: Some(Strength::white(Quantity::FluxLm, 900.0)),
        ..SpotLight::default()
    };
    assert_eq!(read(r#"{"kind": "spot", "flux_lm": 900}"#), Ok(Light::Spot(expected)));
    let point = PointLight {
        strength: Some(Strength::white(Quantity::Intensity, 3.0)),
        ..PointLight::default()
    };
    assert_eq!(read(r#"{"intensity": 3}"#), Ok(Light::Point(point)));
}

#[test]
fn light_is_rejected_with_a_readable_reason_when_json_is_wrong() {
    let cases = [
        (r#"{"kind": "laser"}"#, "/kind: unknown variant `laser`, expected one of `point`, `dir"),
        (r#"{"kind": 7}"#, "/kind: must be the name of a kind of light"),
        (r#"{"kind": "ies"}"#, "missing field `profile`"),
        (r#"{"hotspot_deg": 5}"#, "/hotspot_deg: a light of kind point has no field `hotspot_deg`"),
        (r#"{"flux_w": 5, "kind": "directional"}"#, "of kind directional has no field `flux_w`"),
        (r#"{"kind": "environment", "image": "a", "flux_w": 5}"#, "has no field `flux_w`"),
        (r#"{"intensity": 5, "flux_lm": 5}"#, "given once, not by both flux_lm and intensity"),
        (r#"{"intensity": [1, 2]}"#, "/intensity: invalid length 2, expected a number or [red,"),
        (r#"{"position": [1, "x", 2]}"#, "/position/1: invalid type: string \"x\", expected f64"),
        (r#"{"power": 1}"#, "/power: a light of kind point has no field `power`"),
        (r#"{"strength": 1}"#, "/strength: a light of kind point has no field `strength`"),
        (r#"{"flux_w": 1, "flux_w": 1}"#, "duplicate field `flux_w`"),
        ("[]", "invalid type: sequence, expected a light object"),
    ];
    for (json, expected) in cases {
        let error = read(json).unwrap_err();
        assert!(error.contains(expected), "{json}: {error}");
    }
}

#[test]
fn light_is_rejected_with_a_pointer_when_a_number_is_out_of_range() {
    let cases = [
        (r#"{"intensity": [0, -1, 0]}"#, "/intensity"),
        (r#"{"flux_w": -1}"#, "/flux_w"),
        (r#"{"intensity_cd": 1e39}"#, "/intensity_cd"),
        (r#"{"kind": "directional", "direction": [0, 0, 0]}"#, "/direction"),
        (r#"{"kind": "directional", "illuminance_lx": -1}"#, "/illuminance_lx"),
        (r#"{"kind": "sphere", "radius": 0}"#, "/radius"),
        (r#"{"kind": "disk", "samples": 0}"#, "/samples"),
        (r#"{"kind": "rectangle", "height": -1}"#, "/height"),
        (r#"{"kind": "rectangle", "samples": 1025}"#, "/samples"),
        (r#"{"kind": "environment", "image": ""}"#, "/image"),
        (r#"{"kind": "environment", "image": "a", "scale": -1}"#, "/scale"),
        (r#"{"kind": "ambient", "luminance_nit": -1}"#, "/luminance_nit"),
        (r#"{"kind": "ies", "profile": ""}"#, "/profile"),
        (r#"{"kind": "ies", "profile": "a", "up": [0, 0, 0]}"#, "/up"),
        (r#"{"kind": "spot", "position": [0, 1e40, 0]}"#, "/position"),
        (r#"{"kind": "spot", "axis": [0, 0, 0]}"#, "/axis"),
        (r#"{"kind": "spot", "hotspot_deg": 16}"#, "/hotspot_deg"),
        (r#"{"kind": "spot", "hotspot_deg": -1}"#, "/hotspot_deg"),
        (r#"{"kind": "spot", "falloff_deg": 181}"#, "/falloff_deg"),
        (r#"{"kind": "spot", "hotspot_deg": 0, "falloff_deg": 0}"#, "/falloff_deg"),
    ];
    for (json, pointer) in cases {
        let error = read(json).unwrap().validate("/lights/3").unwrap_err();
        assert_eq!(error.pointer, format!("/lights/3{pointer}"), "{json}");
    }
    let wrong = PointLight {
        strength: Some(Strength::white(Quantity::LuminanceNit, 1.0)),
        ..PointLight::default()
    };
    assert_eq!(Light::Point(wrong).validate("").unwrap_err().pointer, "/luminance_nit");
}

#[test]
fn light_is_accepted_when_numbers_are_at_the_ends_of_their_ranges() {
    let cases = [
        r#"{"kind": "disk", "samples": 1024}"#,
        r#"{"kind": "spot", "hotspot_deg": 0, "falloff_deg": 180}"#,
    ];
    for json in cases {
        assert_eq!(read(json).unwrap().validate(""), Ok(()), "{json}");
    }
}

#[test]
fn null_stands_for_an_omitted_field() {
    let null =
        r#"{"kind": "spot", "axis": null, "hotspot_deg": null, "flux_w": null, "flux_lm": 2}"#;
    assert_eq!(read(null), read(r#"{"kind": "spot", "flux_lm": 2}"#));
    let unknown = serde_json::from_str::<Light>(r#"{"kind": "spot", "colour": null}"#);
    let error = unknown.unwrap_err().to_string();
    assert!(error.contains("a light of kind spot has no field `colour`"), "{error}");
    let null = r#"{"kind": "environment", "image": "a", "scale": null, "samples": null}"#;
    let expected = r#"{"kind":"environment","image":"a","rotation_deg":0.0,"scale":[1.0,1.0,1.0],"samples":64}"#;
    assert_eq!(read(null), read(expected));
}

#[test]
fn schema_has_every_field_of_a_serialised_light() {
    let schema = serde_json::to_value(Light::schema()).unwrap();
    let forms = schema["oneOf"].as_array().unwrap();
    for form in forms {
        assert_eq!(form["additionalProperties"], false, "{form}");
    }
    assert!(forms[0]["required"].is_null(), "{schema}");
    for json in LIGHTS {
        let written: serde_json::Value = serde_json::from_str(json).unwrap();
        let of_kind =
            |form: &&serde_json::Value| form["properties"]["kind"]["enum"][0] == written["kind"];
        let form = forms.iter().find(of_kind).unwrap();
        for field in written.as_object().unwrap().keys() {
            assert!(form["properties"][field].is_object(), "{field}: {form}");
        }
    }
}
