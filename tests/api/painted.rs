//! Painted materials over HTTP: stored, drawn, bred; refused where a BRDF is needed.

use brood_tests::{TestServer, text_of};
use serde_json::json;

const TEXT: &str = "text/x-brood";
const TOON: &str = "brood 1\n.effect light\npalette #2b1e46 #f2a65a\nbasis step\n";

#[tokio::test(flavor = "multi_thread")]
async fn painted_materials_are_drawn_and_refused_as_brdfs() {
    let server = TestServer::start();
    let stored = server.post_bytes("/v1/genomes", TEXT, TOON).await.expect(201).json();
    let body = json!({"name": "painted", "dialect": {"length": 0}, "thumbnail_px": 32});
    let made = server.post("/v1/lineages", &body).await.expect(201).json();
    let lineage = format!("/v1/lineages/{}", text_of(&made["id"]));
    let body = json!({"genomes": [stored["hash"]], "presets": ["paint-ink"]});
    let made = server.post(&format!("{lineage}/adoptions"), &body).await.expect(201).json();
    let one = &made["individuals"][0];
    let picture = server.get(&text_of(&one["thumbnail"])).await.expect(200).picture();
    let dark = picture.pixels().filter(|pixel| pixel.0 == [0x2b, 0x1e, 0x46, 255]).count();
    assert!(picture.width() == 32 && dark > 20, "{dark} pixels have the dark colour");

    let id = text_of(&one["id"]);
    for path in ["inspection", "slice.png"] {
        let refused = server.get(&format!("/v1/individuals/{id}/{path}")).await.expect(422).json();
        assert_eq!(refused["detail"], "a painted material is not a BRDF", "{path}");
    }
    let path = format!("{lineage}/generations");
    let steered = json!({"parents": [id], "steer": ["warmer"], "seed": 1});
    server.post(&path, &steered).await.expect(422);
    let bred = json!({"parents": [id], "count": 3, "seed": 1, "curation": "diverse"});
    let bred = server.post(&path, &bred).await.expect(201).json();
    assert_eq!(bred["individuals"].as_array().map(Vec::len), Some(3));
}

#[tokio::test(flavor = "multi_thread")]
async fn painted_materials_are_exported_for_lights() {
    let server = TestServer::start();
    let code = server.post_bytes("/v1/exports/wgsl?lights=3", TEXT, TOON).await.expect(200).text();
    assert!(code.contains("fn styled(at: StyledPoint, lights: array<StyledLight,3>)"), "{code}");
    let code = server.post_bytes("/v1/exports/glsl-es-300", TEXT, TOON).await.expect(200).text();
    assert!(code.contains("vec3 styled(StyledPoint at, StyledLight[1] lights)"), "{code}");
    server.post_bytes("/v1/exports/wgsl?lights=9", TEXT, TOON).await.problem(400);
    let toon = server.post_bytes("/v1/exports/vrm-mtoon", TEXT, TOON).await.expect(200).json();
    let toon = &toon["extensions"]["VRMC_materials_mtoon"];
    assert_eq!((&toon["specVersion"], &toon["shadingShiftFactor"]), (&json!("1.0"), &json!(-0.5)));
    let highlight = format!("{TOON}.effect highlight\n");
    let refused = server.post_bytes("/v1/exports/vrm-mtoon", TEXT, highlight).await.problem(422);
    assert_eq!(refused["detail"], "VRM's toon material has no highlight");
}

#[tokio::test(flavor = "multi_thread")]
async fn errors_of_effects_have_lines_and_pointers() {
    let server = TestServer::start();
    let text = "brood 1\n.effect light\nedges 0.9 0.1\n";
    let refused = server.post_bytes("/v1/genomes", TEXT, text).await.expect(422).json();
    assert_eq!((&refused["line"], &refused["column"]), (&json!(3), &json!(7)), "{refused}");
    let effects = json!([{"kind": "light", "parameters": {"from": 1, "to": 0}}]);
    let body = json!({"brood": 1, "dialect": {"length": 0}, "effects": effects});
    let refused = server.post("/v1/genomes", &body).await.expect(422).json();
    assert_eq!(refused["pointer"], "/effects/0/parameters/from", "{refused}");
    let directed = json!({"name": "directed", "dialect": {"opcodes": "directed", "registers": 12}});
    server.post("/v1/lineages", &directed).await.expect(422);
}
