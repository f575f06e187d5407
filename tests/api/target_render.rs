//! Measured targets rendered in any scene and light, and individuals at their exposure.

use brood_tests::{TestLineage, TestServer, ids, text_of};
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
