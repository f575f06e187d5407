//! Painted materials over HTTP: stored, drawn, bred; refused where a BRDF is needed.

use brood_tests::{TestServer, text_of};
use serde_json::{Value, json};

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

#[tokio::test(flavor = "multi_thread")]
async fn toon_shapes_of_brdfs_are_bred_in_both_halves_and_not_exported() {
    let server = TestServer::start();
    let brdf = "brood 1\n.model conductor\nroughness 0.3\n";
    let effects = ".effect light\npalette #000000 #00ff00\nbasis step\nby brdf\nto 0.4\n";
    let metal = server.post_bytes("/v1/genomes", TEXT, brdf).await.expect(201).json();
    let body = json!({"name": "toon", "dialect": {"length": 0}, "thumbnail_px": 48});
    let made = server.post("/v1/lineages", &body).await.expect(201).json();
    let lineage = format!("/v1/lineages/{}", text_of(&made["id"]));
    let adoptions = format!("{lineage}/adoptions");
    let body = json!({"genomes": [metal["hash"]]});
    let parent = server.post(&adoptions, &body).await.expect(201).json();
    let parent = text_of(&parent["individuals"][0]["id"]);
    let text = format!("{brdf}{effects}");
    let toon = server.post_bytes("/v1/genomes", TEXT, text.clone()).await.expect(201).json();
    let body = json!({"genomes": [toon["hash"]], "parent": parent});
    let child = server.post(&adoptions, &body).await.expect(201).json();
    let child = &child["individuals"][0];
    assert_eq!(child["layers"], json!(["conductor"]));
    let picture = server.get(&text_of(&child["thumbnail"])).await.expect(200).picture();
    for color in [[0, 0, 0, 255], [0, 255, 0, 255]] {
        let count = picture.pixels().filter(|pixel| pixel.0 == color).count();
        assert!(count > 100, "{count} pixels are {color:?}");
    }
    let id = text_of(&child["id"]);
    for path in ["inspection", "exports/glsl-es-300"] {
        server.get(&format!("/v1/individuals/{id}/{path}")).await.expect(422);
    }
    let refused = server.post_bytes("/v1/exports/wgsl", TEXT, text).await.problem(422);
    assert!(text_of(&refused["detail"]).contains("`by brdf` is not exported"), "{refused}");

    let path = format!("{lineage}/generations");
    for parents in [[&id, &parent], [&parent, &id]] {
        let mixed = json!({"parents": parents, "count": 3, "seed": 1});
        let mixed = server.post(&path, &mixed).await.expect(201).json();
        for one in mixed["individuals"].as_array().unwrap() {
            let genome = server.get(&format!("/v1/genomes/{}", text_of(&one["hash"]))).await;
            assert_eq!(genome.expect(200).json()["effects"][0]["parameters"]["by"], "brdf");
            server.get(&text_of(&one["thumbnail"])).await.expect(200);
        }
    }
    let still = json!({"parents": [parent, toon["hash"]], "mutation": 0, "recombination": 0});
    let refused = server.post(&path, &still).await.problem(422);
    assert_eq!(refused["pointer"], "/recombination");
    let paint = server.post_bytes("/v1/genomes", TEXT, TOON).await.expect(201).json();
    for parents in [[&metal["hash"], &paint["hash"]], [&paint["hash"], &metal["hash"]]] {
        let still = json!({"parents": parents, "mutation": 0});
        assert_eq!(server.post(&path, &still).await.problem(422)["pointer"], "/mutation");
        let steered = json!({"parents": parents, "steer": ["warmer"]});
        assert_eq!(server.post(&path, &steered).await.problem(422)["pointer"], "/steer");
        let painted = json!({"parents": parents, "count": 2});
        server.post(&path, &painted).await.expect(201);
    }
    let bred = json!({"parents": [id], "count": 4, "seed": 1, "mutation": 0.6,
        "curation": "diverse", "energy_limit": true, "locks": {"effects": ["light"]}});
    let bred = server.post(&path, &bred).await.expect(201).json();
    let mut models = Vec::new();
    for one in bred["individuals"].as_array().unwrap() {
        let hash = text_of(&one["hash"]);
        let genome = server.get(&format!("/v1/genomes/{hash}")).await.expect(200).json();
        assert_eq!(genome["limit"], json!(true));
        assert_eq!(genome["effects"][0]["parameters"]["by"], "brdf");
        assert_eq!(genome["effects"][0]["parameters"]["to"], 0.4);
        models.push(genome["layers"].clone());
        server.get(&text_of(&one["thumbnail"])).await.expect(200);
    }
    assert!(models.iter().any(|layers| *layers != models[0]), "{models:?}");
    let none = server.post_bytes("/v1/genomes", TEXT, format!("brood 1\n{effects}"));
    let refused = none.await.expect(422).json();
    assert_eq!((&refused["line"], &refused["column"]), (&json!(5), &json!(4)), "{refused}");
}

#[tokio::test(flavor = "multi_thread")]
async fn scenes_with_more_than_eight_lights_are_refused_for_paint_alone() {
    let server = TestServer::start();
    let words = "a scene of painted materials must have at most 8 lights, got 9";
    let scene = |lights: usize| json!({"mesh": "sphere", "lights": vec![json!({}); lights]});
    let [few, many] = [8, 9].map(scene);
    let few = server.post("/v1/scenes", &few).await.expect(201).json()["id"].clone();
    let many = server.post("/v1/scenes", &many).await.expect(201).json()["id"].clone();
    let body = |scene: &Value, start: &str| json!({"name": "x", "start": start, "scene": scene});
    let refused = server.post("/v1/lineages", &body(&many, "painted")).await.problem(422);
    assert_eq!((&refused["pointer"], &refused["detail"]), (&json!("/scene"), &json!(words)));
    let painted = server.post("/v1/lineages", &body(&few, "painted")).await.expect(201).json();
    let painted = format!("/v1/lineages/{}", text_of(&painted["id"]));
    let patched = server.patch(&painted, Some("\"1\""), &json!({"scene": many})).await.problem(422);
    assert_eq!(patched["pointer"], "/scene");
    let bred = json!({"parents": [], "count": 1, "seed": 1});
    let bred = server.post(&format!("{painted}/generations"), &bred).await.expect(201).json();
    let child = &bred["individuals"][0];
    server.get(&text_of(&child["thumbnail"])).await.expect(200);

    let path = format!("/v1/individuals/{}/render.png?scene=", text_of(&child["id"]));
    server.get(&format!("{path}{}", text_of(&few))).await.expect(200);
    let refused = server.get(&format!("{path}{}", text_of(&many))).await.problem(422);
    assert_eq!(refused["detail"], words);
    let path = format!("/v1/render.png?scene={}", text_of(&many));
    assert_eq!(server.post_bytes(&path, TEXT, TOON).await.problem(422)["detail"], words);

    // A lineage of BRDFs may have such a scene, and adopts no paint then.
    let models = server.post("/v1/lineages", &body(&many, "models")).await.expect(201).json();
    let path = format!("/v1/lineages/{}/adoptions", text_of(&models["id"]));
    let refused = server.post(&path, &json!({"presets": ["paint-ink"]})).await.problem(422);
    assert_eq!(refused["detail"], words);
    server.post(&path, &json!({"presets": ["model-gold"]})).await.expect(201);
}

#[tokio::test(flavor = "multi_thread")]
async fn paint_under_too_many_lights_fails_no_other_picture() {
    let server = TestServer::start();
    let scene = json!({"mesh": "sphere", "lights": vec![json!({}); 9]});
    let many = server.post("/v1/scenes", &scene).await.expect(201).json()["id"].clone();
    let lineage = json!({"name": "x", "start": "models"});
    let lineage = server.post("/v1/lineages", &lineage).await.expect(201).json();
    let lineage = format!("/v1/lineages/{}", text_of(&lineage["id"]));
    let names = ["paint-ink", "model-gold", "gold", "moon-dust", "matt-clay", "model-porcelain"];
    let both = json!({"presets": names});
    let adopted = format!("{lineage}/adoptions");
    let generation = server.post(&adopted, &both).await.expect(201).json();
    server.patch(&lineage, Some("\"1\""), &json!({"scene": many})).await.expect(200);
    let path = format!("/v1/generations/{}", text_of(&generation["id"]));
    let shown = server.get(&path).await.expect(200).json();
    let pictures: Vec<String> = shown["individuals"]
        .as_array()
        .unwrap()
        .iter()
        .map(|one| text_of(&one["thumbnail"]).to_owned())
        .collect();
    // Requested together, most share a job.
    let answers = futures::future::join_all(pictures.iter().map(|one| server.get(one))).await;
    let mut answers = answers.into_iter();
    let paint = answers.next().unwrap();
    let words = "a scene of painted materials must have at most 8 lights, got 9";
    assert_eq!(paint.problem(422)["detail"], words);
    assert_eq!(answers.len(), names.len() - 1);
    for other in answers {
        other.expect(200);
    }
}
