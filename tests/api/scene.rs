//! Scenes: stored with all defaults filled in, and refused with a pointer.

use brood_tests::{TestLineage, TestServer, text_of};
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

#[tokio::test(flavor = "multi_thread")]
async fn surroundings_are_refused_with_a_pointer_when_a_value_is_invalid() {
    let server = TestServer::start();
    let object = |value: serde_json::Value| json!({"objects": [{}, value]});
    let hash = "0".repeat(64);
    let rows = [
        (422, object(json!({"scale": 0})), "/objects/1/scale"),
        (422, object(json!({"position": [0, 1e9, 0]})), "/objects/1/position"),
        (422, object(json!({"mesh": "teapot"})), "/objects/1/mesh"),
        (422, object(json!({"stands": true})), "/objects/1/stands"),
        (422, object(json!({"material": "no-such-preset"})), "/objects/1/material"),
        (404, object(json!({"material": hash})), "/objects/1/material"),
        (422, json!({"objects": vec![json!({}); 9]}), "/objects"),
        (404, json!({"ground": {"material": hash}}), "/ground/material"),
        (422, json!({"ground": {"height": 1e9}}), "/ground/height"),
        (400, json!({"ground": {"depth": 1}}), "/ground"),
        (400, object(json!({"colour": "red"})), "/objects"),
    ];
    for (status, body, pointer) in rows {
        let problem = server.post("/v1/scenes", &body).await.problem(status);
        let found = problem["pointer"].as_str().unwrap_or_default();
        assert!(found.contains(pointer), "{body}: {problem}");
    }
}

/// Mean code of green in a column of pixels.
fn mean_green(picture: &image::RgbaImage, rows: std::ops::Range<u32>) -> f64 {
    let pixels = rows.flat_map(|y| (0..picture.width()).map(move |x| (x, y)));
    let codes: Vec<f64> = pixels.map(|(x, y)| f64::from(picture.get_pixel(x, y).0[1])).collect();
    codes.iter().sum::<f64>() / codes.len() as f64
}

#[tokio::test(flavor = "multi_thread")]
async fn objects_and_ground_are_in_pictures_and_survive_their_makers() {
    let server = TestServer::start();
    // The material comes from another lineage.
    let maker = TestLineage::new(&server).await;
    let adopted = server
        .post(&maker.path("/adoptions"), &json!({"presets": ["gold"]}))
        .await
        .expect(201)
        .json();
    let gold = text_of(&adopted["individuals"][0]["hash"]);
    let scene = json!({
        "shadows": true,
        "objects": [{"mesh": "cube", "material": gold, "scale": 0.4, "position": [1, 0, 0.4], "stands": true}],
        "ground": {},
    });
    let scene = server.post("/v1/scenes", &scene).await.expect(201).json();
    let body = json!({"name": "among others", "scene": scene["id"], "thumbnail_px": 48});
    let lineage = TestLineage::with(&server, body).await;
    let bred = lineage.random(3).await;
    let path = text_of(&bred["individuals"][0]["thumbnail"]);
    let picture = server.get(&path).await.expect(200).picture();
    let corners = [(0, 47), (47, 47), (0, 24)].map(|(x, y)| picture.get_pixel(x, y).0[3]);
    assert_eq!(corners, [255; 3], "the ground is around the object");
    let id = text_of(&bred["individuals"][0]["id"]);
    let exr = format!("/v1/individuals/{id}/render.exr?size=32&scene={}", text_of(&scene["id"]));
    server.get(&exr).await.expect(200);

    // The material is kept when the lineage that bred it is removed for good.
    let purge = format!("{}?purge=true", maker.path(""));
    server.delete(&purge).await.expect(204);
    let larger = format!("/v1/individuals/{id}/render.png?size=64");
    let picture = server.get(&larger).await.expect(200).picture();
    assert!(mean_green(&picture, 48..64) > 20.0, "the ground is lit");

    // A lineage file takes the material along.
    let file = server.get(&lineage.path("/file")).await.expect(200);
    assert!(file.json()["genomes"][&gold].is_string());
    let other = TestServer::start();
    let kind = file.header("content-type");
    let imported = other.post_bytes("/v1/lineages/import", &kind, file.body.clone()).await;
    let imported = imported.expect(201).json();
    let read = other.get(&format!("/v1/scenes/{}", text_of(&imported["scene"]))).await.expect(200);
    assert_eq!(read.json()["objects"], scene["objects"]);
    let mut changed = file.json();
    changed["genomes"].as_object_mut().unwrap().remove(&gold);
    let problem = TestServer::start().post("/v1/lineages/import", &changed).await.problem(422);
    assert_eq!(problem["pointer"], "/scene/objects/0/material");
}
