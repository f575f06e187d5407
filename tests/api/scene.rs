//! Scenes: stored with all defaults filled in, and refused with a pointer.

use brood_tests::{TestServer, text_of};
use serde_json::json;

#[tokio::test(flavor = "multi_thread")]
async fn scene_has_every_field_when_only_a_mesh_is_given() {
    let server = TestServer::start();
    let made = server.post("/v1/scenes", &json!({"mesh": "knob"})).await.expect(201).json();
    let default = server.get("/v1/scenes/default").await.expect(200).json();
    for field in ["rotation_deg", "scale", "camera", "lights", "film"] {
        assert!(!made[field].is_null(), "{field} in {made}");
        assert_eq!(made[field], default[field], "{field}");
    }
    assert_eq!(made["film"]["exposure"], "auto");
    assert_eq!(made["camera"]["fov_y_deg"], 30.0);
    let read = server.get(&format!("/v1/scenes/{}", text_of(&made["id"]))).await.expect(200).json();
    assert_eq!(read, made);
}

#[tokio::test(flavor = "multi_thread")]
async fn scene_is_refused_with_a_pointer_when_a_value_is_invalid() {
    let server = TestServer::start();
    let point = json!({"kind": "point"});
    let rows = [
        (422, json!({"scale": 0}), "/scale"),
        (422, json!({"scale": -1}), "/scale"),
        (422, json!({"camera": {"fov_y_deg": 180}}), "/camera"),
        (422, json!({"lights": []}), "/lights"),
        (422, json!({"lights": vec![point; 17]}), "/lights"),
        (422, json!({"film": {"exposure": 1000}}), "/film/exposure"),
        (400, json!({"rotation_deg": [0, 0]}), "/rotation_deg"),
        (400, json!({"lights": [{"kind": "laser"}]}), "/lights"),
        (400, json!({"film": {"tone": "loud"}}), "/film"),
        (400, json!({"fog": 1}), "fog"),
    ];
    for (status, body, pointer) in rows {
        let answer = server.post("/v1/scenes", &body).await;
        assert_eq!(answer.status, status, "{body}: {}", answer.text());
        let problem = answer.problem(status);
        let found = problem["pointer"].as_str().unwrap_or_default();
        assert!(found.contains(pointer), "{body}: {problem}");
    }
    let unknown = json!({"mesh": "01900000-0000-7000-8000-000000000000"});
    let answer = server.post("/v1/scenes", &unknown).await;
    assert!(matches!(answer.status, 404 | 422), "{}", answer.text());
}
