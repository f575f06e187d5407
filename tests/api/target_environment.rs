//! Image targets in environments and under several lights: models are fitted to their pixels.

use brood_tests::{TestServer, text_of};
use serde_json::{Value, json};

use crate::light::environment;
use crate::target_picture::photographed_in;

fn scene(lights: &Value) -> Value {
    json!({"mesh": "sphere", "camera": {"orbit_deg": [25, 30], "fov_y_deg": 28}, "lights": lights})
}

#[tokio::test(flavor = "multi_thread")]
async fn material_is_found_in_an_uploaded_environment() {
    let server = TestServer::start();
    let map = server.post_bytes("/v1/environments", "image/x-exr", environment()).await;
    let map = map.expect(201).json();
    let sky = json!([{"kind": "environment", "image": map["id"], "samples": 64}]);
    let (_, picture) = photographed_in(&server, &scene(&sky), "64").await;
    let spec = json!({"kind": "image", "scene": scene(&sky)});
    let target = server.post_target(&spec, &picture).await.expect(201).json();
    let pixels = &target["views"][0]["pixels"];
    assert_eq!((&pixels["used"], &pixels["unlit"]), (&json!(0), &json!(0)), "{pixels}");
    assert!(pixels["several_lights"].as_u64() > Some(1000), "{pixels}");
    assert_eq!(target["samples"], pixels["several_lights"]);
    let shown = format!("/v1/targets/{}/views/0/scene.png", text_of(&target["id"]));
    server.get(&shown).await.expect(200).picture();
    let mut body = json!({"kind": "fit", "target": target["id"], "threads": 1, "generations": 1});
    for strategy in ["hybrid", "lobes", "gp"] {
        body["strategy"] = json!(strategy);
        let problem = server.post("/v1/jobs", &body).await.problem(422);
        assert_eq!(problem["pointer"], "/strategy");
        assert!(text_of(&problem["detail"]).contains("use analytic, which also fits the"));
    }
    body["strategy"] = json!("auto");
    let job = text_of(&server.post("/v1/jobs", &body).await.expect(202).json()["id"]);
    let ended = server.job_once(&job, |job| job["ended_ms"].is_i64()).await;
    assert_eq!((&ended["state"], &ended["strategy"]), (&json!("succeeded"), &json!("analytic")));
    let front = server.get(&format!("/v1/jobs/{job}/front")).await.expect(200).json();
    let best = &front["items"][0];
    let spread = &front["spread"];
    assert_eq!((&spread["cells"], spread["seen"].as_array().unwrap().len()), (&json!(30), 900));
    assert!(spread["e_log"].as_f64() > Some(0.0), "{spread}");
    // The environment would be turned.
    let next = &spread["next"];
    assert!(next.is_null() || next["light_deg"].is_null(), "{next}");
    assert!(best["e_log"].as_f64() < Some(8e-3), "{best}");
    let view = &best["views"][0];
    // The picture has noise.
    assert!(view["rmse"].as_f64().unwrap() < 0.06, "{view}");
}

#[tokio::test(flavor = "multi_thread")]
async fn scenes_with_an_environment_cannot_be_corrected() {
    let server = TestServer::start();
    let sky = json!([{"kind": "environment", "image": "studio"}]);
    let (_, picture) = photographed_in(&server, &scene(&sky), "32").await;
    let spec = json!({"kind": "image", "scene": scene(&sky), "refine": {"light_deg": 2}});
    let problem = server.post_target(&spec, &picture).await.problem(422);
    assert_eq!(problem["pointer"], "/refine");
    assert!(text_of(&problem["detail"]).contains("cannot be corrected yet"), "{problem}");
}

#[tokio::test(flavor = "multi_thread")]
async fn pixels_under_two_lamps_count() {
    let server = TestServer::start();
    let lamps = json!([
        {"kind": "point", "position": [3, 3, 3]}, {"kind": "point", "position": [-3, 2, 1]},
    ]);
    let (_, picture) = photographed_in(&server, &scene(&lamps), "64").await;
    let spec = json!({"kind": "image", "scene": scene(&lamps)});
    let target = server.post_target(&spec, &picture).await.expect(201).json();
    let pixels = &target["views"][0]["pixels"];
    let count = |name: &str| pixels[name].as_u64().unwrap();
    assert!(count("used") > 100 && count("several_lights") > 100, "{pixels}");
    assert_eq!(target["samples"], count("used") + count("several_lights"));
    // Enough pixels for every strategy are lit by one lamp.
    let body = json!({
        "kind": "fit", "target": target["id"], "threads": 1, "generations": 1, "strategy": "gp",
    });
    server.post("/v1/jobs", &body).await.expect(202);
}
