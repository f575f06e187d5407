//! Image targets whose scenes are known roughly: searches correct them within their uncertainties.

use brood_tests::{TestServer, text_of};
use serde_json::{Value, json};

use crate::target_picture::photographed_in;

/// Scene with a point light at a position.
fn scene(position: [f64; 3]) -> Value {
    json!({
        "mesh": "cube", "rotation_deg": [20, 35, 10], "shadows": true,
        "camera": {"orbit_deg": [25, 30], "fov_y_deg": 28},
        "lights": [{"kind": "point", "position": position, "intensity": 60}],
    })
}

#[tokio::test(flavor = "multi_thread")]
async fn search_corrects_the_light_of_a_picture() {
    let server = TestServer::start();
    // The light is turned by about 3 degrees.
    let (stated, taken) = (scene([3.0, 3.5, 2.5]), scene([3.1, 3.5, 2.25]));
    let (_, picture) = photographed_in(&server, &taken, "64").await;
    let refine = json!({"light_deg": 3});
    let spec = json!({"kind": "image", "scene": stated, "refine": refine});
    let target = server.post_target(&spec, &picture).await.expect(201).json();
    let path = format!("/v1/targets/{}", text_of(&target["id"]));
    assert_eq!(target["views"][0]["refine"]["light_deg"], 3.0);
    assert_eq!(target["views"][0]["corrected"], Value::Null);
    let corrected = format!("{path}/views/0/scene.png?corrected=true");
    let problem = server.get(&corrected).await.problem(404);
    assert!(text_of(&problem["detail"]).contains("no search"), "{problem}");
    let body = json!({
        "kind": "fit", "target": target["id"], "threads": 1, "generations": 2, "strategy": "auto",
    });
    let job = text_of(&server.post("/v1/jobs", &body).await.expect(202).json()["id"]);
    let ended = server.job_once(&job, |job| job["ended_ms"].is_i64()).await;
    assert_eq!((&ended["state"], &ended["strategy"]), (&json!("succeeded"), &json!("analytic")));
    let view = server.get(&path).await.expect(200).json()["views"][0].clone();
    assert_eq!(view["scene"]["lights"], target["views"][0]["scene"]["lights"]);
    let place = &view["corrected"]["scene"]["lights"][0]["position"];
    let off = |k: usize, wanted: f64| (place[k].as_f64().unwrap() - wanted).abs();
    // Its distance stays as stated.
    assert!(off(0, 3.1) < 0.05 && off(1, 3.5) < 0.1 && off(2, 2.25) < 0.05, "{place}");
    let names: Vec<&str> = view["corrected"]["corrections"]
        .as_array()
        .unwrap()
        .iter()
        .map(|one| one["name"].as_str().unwrap())
        .collect();
    assert_eq!(names, ["lights/0/right_deg", "lights/0/up_deg"]);
    // Pictures: the scene as corrected differs from that as stated, and the best material is
    // drawn in the corrected one.
    let shown = server.get(&corrected).await.expect(200).picture();
    let before = server.get(&format!("{path}/views/0/scene.png")).await.expect(200).picture();
    assert!(shown != before && shown.dimensions() == before.dimensions());
    let front = server.get(&format!("/v1/jobs/{job}/front")).await.expect(200).json();
    let next = &front["spread"]["next"];
    assert_eq!(next["light_deg"].as_array().map(Vec::len), Some(2), "{}", front["spread"]);
    assert!(next["e_log"].as_f64() < front["spread"]["e_log"].as_f64());
    server.post("/v1/scenes", &next["scene"]).await.expect(201);
    // The material could be darker or brighter in it, at every pixel.
    assert_eq!(front["spread"]["pictures"], true);
    let extreme = async |name: &str| {
        server.get(&format!("/v1/jobs/{job}/{name}.png")).await.expect(200).picture()
    };
    let (darkest, brightest) = (extreme("darkest").await, extreme("brightest").await);
    assert_eq!(darkest.dimensions(), brightest.dimensions());
    assert!(darkest != brightest && darkest.iter().zip(brightest.iter()).all(|(a, b)| a <= b));
    let rmse = front["items"][0]["views"][0]["rmse"].as_f64().unwrap();
    assert!(rmse < 0.02, "{rmse}");
}

#[tokio::test(flavor = "multi_thread")]
async fn uncertainties_out_of_range_are_refused() {
    let server = TestServer::start();
    let (_, picture) = photographed_in(&server, &scene([3.0, 3.5, 2.5]), "64").await;
    for (pointer, words, spec) in [
        ("/refine/light_deg", "0 to 15 degrees", json!({"refine": {"light_deg": 20}})),
        ("/refine/fov", "0 to 0.5", json!({"refine": {"fov": -1}})),
        ("/refine", "light_deg", json!({"refine": {"lights": 1}})),
        ("/refine", "only a picture", json!({"kind": "merl", "refine": {"fov": 0.1}})),
        ("/refine", "for itself", json!({"refine": {"fov": 0.1}, "views": []})),
    ] {
        let mut whole = json!({"kind": "image"});
        for (name, value) in spec.as_object().unwrap() {
            whole[name] = value.clone();
        }
        let answer = server.post_target(&whole, &picture).await;
        assert!([400, 422].contains(&answer.status), "{spec}: {}", answer.status);
        let status = answer.status;
        let problem = answer.problem(status);
        assert!(text_of(&problem["detail"]).contains(words), "{spec}: {problem}");
        if status == 422 {
            assert_eq!(problem["pointer"], pointer, "{spec}: {problem}");
        }
    }
}
