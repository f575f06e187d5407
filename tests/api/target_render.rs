//! Measured targets rendered in any scene and light, and individuals at their exposure.

use std::time::Duration;

use brood_tests::{ServerOptions, TestLineage, TestServer, ids, text_of};
use reqwest::Method;
use serde_json::json;

fn brightness(picture: &image::RgbaImage) -> f64 {
    let covered = picture.pixels().filter(|pixel| pixel.0[3] == 255);
    let (sum, count) = covered.fold((0.0, 0.0), |(sum, count), pixel| {
        (sum + f64::from(pixel.0[0]) + f64::from(pixel.0[1]), count + 2.0)
    });
    sum / f64::max(count, 1.0)
}

#[tokio::test(flavor = "multi_thread")]
async fn measured_target_is_rendered_in_any_scene_and_light() {
    let server = TestServer::start();
    let id = server.glossy_target().await;
    let place = format!("/v1/targets/{id}/render.png");
    let answer = server.get(&place).await.expect(200);
    assert_eq!(answer.header("cache-control"), "private, max-age=31536000, immutable");
    assert_eq!(answer.picture().dimensions(), (256, 256));
    let request =
        server.request(Method::GET, &place).header("if-none-match", answer.header("etag"));
    assert_eq!(server.send(request).await.status, 304);
    let scene = json!({"mesh": "torus", "film": {"exposure": 0}});
    let scene = server.post("/v1/scenes", &scene).await.expect(201).json();
    let on = format!("{place}?size=48&scene={}", text_of(&scene["id"]));
    let torus = server.get(&on).await.expect(200).picture();
    assert_eq!(torus.dimensions(), (48, 48));
    let turned = server.get(&format!("{on}&light_deg=120")).await.expect(200).picture();
    assert_ne!(torus, turned);
    let dark = server.get(&format!("{on}&exposure_ev=-4")).await.expect(200).picture();
    assert!(brightness(&dark) < 0.6 * brightness(&torus));
    let many = server.get(&format!("{on}&samples=16")).await.expect(200).picture();
    assert_ne!(many, torus);
    for (query, status) in [
        ("size=4", 400),
        ("size=2048&samples=64", 422),
        ("light_deg=NaN", 400),
        ("exposure_ev=1000", 400),
        ("samples=none", 400),
        ("view=0", 422),
        ("colour=red", 400),
        ("scene=01890000-0000-7000-8000-000000000000", 404),
    ] {
        server.get(&format!("{place}?{query}")).await.problem(status);
    }
    server.get(&format!("/v1/targets/{id}/views/0/picture.png")).await.problem(404);
}

#[tokio::test(flavor = "multi_thread")]
async fn individual_has_the_exposure_of_the_target_it_is_compared_with() {
    let server = TestServer::start();
    let id = server.glossy_target().await;
    let lineage = TestLineage::new(&server).await;
    let presets = json!({"presets": ["model-clay"]});
    let made = server.post(&lineage.path("/adoptions"), &presets).await.expect(201).json();
    let individual = ids(&made)[0].clone();
    let own = format!("/v1/individuals/{individual}/render.png?size=64&light_deg=30");
    let beside = format!("{own}&target={id}");
    let answer = server.get(&beside).await.expect(200);
    let request = server.request(Method::GET, &beside);
    let request = request.header("if-none-match", answer.header("etag"));
    assert_eq!(server.send(request).await.status, 304);
    assert_ne!(answer.picture(), server.get(&own).await.expect(200).picture());
    let linear = beside.replace("render.png", "render.exr");
    let exr = server.get(&linear).await.expect(200);
    let plain = server.get(&own.replace("render.png", "render.exr")).await.expect(200);
    assert_eq!(exr.body, plain.body, "radiance does not depend on exposure");
    server.get(&format!("{beside}&view=0")).await.problem(422);
    server.get(&format!("{beside}&backend=cpu")).await.problem(400);
    let unknown = "01890000-0000-7000-8000-000000000000";
    server.get(&format!("{own}&target={unknown}")).await.problem(404);
}

#[tokio::test(flavor = "multi_thread")]
async fn target_is_rendered_once_and_then_served_from_the_picture_cache() {
    let mut server = TestServer::start();
    let place = format!("/v1/targets/{}/render.png?size=48", server.glossy_target().await);
    let first = server.get(&place).await.expect(200).body;
    assert_eq!(server.get(&place).await.expect(200).body, first);
    assert_eq!(server.metric("brood_pictures_rendered_total").await, 1);
    assert_eq!(server.metric("brood_pictures_from_memory_total").await, 1);
    assert_eq!(server.terminate(), 0);
    server.restart();
    assert_eq!(server.get(&place).await.expect(200).body, first);
    assert_eq!(server.metric("brood_pictures_rendered_total").await, 0);
    assert_eq!(server.metric("brood_pictures_from_disk_total").await, 1);
}

#[tokio::test(flavor = "multi_thread")]
async fn picture_of_a_target_is_rendered_when_its_request_was_cancelled() {
    let server = TestServer::start();
    let id = server.glossy_target().await;
    let place = |size: u32| format!("/v1/targets/{id}/render.png?size={size}");
    server.get(&place(32)).await.expect(200);
    let hasty = server.request(Method::GET, &place(800)).timeout(Duration::from_millis(50));
    assert!(server.try_send(hasty).await.is_err(), "it takes longer than 50 ms");
    let picture = server.get(&place(800)).await.expect(200).picture();
    assert_eq!(picture.dimensions(), (800, 800));
    assert_eq!(server.metric("brood_pictures_rendered_total").await, 2);
}

#[tokio::test(flavor = "multi_thread")]
async fn picture_of_a_target_is_503_when_no_worker_runs() {
    let server = TestServer::start_with(ServerOptions { workers: 0, ..ServerOptions::default() });
    let id = server.glossy_target().await;
    let answer = server.get(&format!("/v1/targets/{id}/render.png?size=48")).await.expect(503);
    assert!(!answer.header("retry-after").is_empty(), "{:?}", answer.headers);
}
