//! Exports: formats, source of an individual, and refused requests.

use brood_tests::{TestLineage, TestServer, text_of};

/// A painted material.
const TOON: &str = include_str!("../../crates/genome/presets/paint-toon.brood");

#[tokio::test(flavor = "multi_thread")]
async fn individual_is_exported_in_every_listed_format() {
    let server = TestServer::start();
    let lineage = TestLineage::new(&server).await;
    let id = lineage.random_child(3).await;
    let found = server.get(&format!("/v1/individuals/{id}")).await.expect(200).json();
    let hash = text_of(&found["hash"]);
    let formats = server.get("/v1/exports").await.expect(200).json();
    let formats = formats.as_array().unwrap();
    assert!(formats.len() >= 3);
    for format in formats {
        let name = text_of(&format["name"]);
        let path = format!("/v1/individuals/{id}/exports/{name}");
        for described in ["label", "error", "opened_by", "exactness"] {
            assert!(!text_of(&format[described]).is_empty(), "{format}");
        }
        let answer = server.get(&path).await;
        // MERL's tables have no place for azimuths, and random materials are anisotropic.
        if format["painted"] == true || name == "merl" {
            answer.problem(422);
            continue;
        }
        let answer = answer.expect(200);
        assert_eq!(answer.header("content-type"), text_of(&format["media_type"]));
        let extension = text_of(&format["extension"]);
        let dash = if extension == "py" { '_' } else { '-' };
        let file = format!("brood{dash}{}.{extension}", &hash[..8]);
        assert!(answer.header("content-disposition").contains(&file));
        let has_note = format["exactness"] != "exact";
        assert_eq!(answer.headers.contains_key("brood-note"), has_note, "{format}");
        assert!(!has_note || answer.header("brood-note").contains("mirror direction"), "{format}");
        let etag = answer.header("etag").to_owned();
        let is_archive = format["media_type"] == "application/zip";
        if text_of(&format["exactness"]) == "exact" && !is_archive {
            let text = answer.text();
            assert!(text.contains("evolved("), "{text}");
        }
        let request = server.request(reqwest::Method::GET, &path);
        server.send(request.header("if-none-match", etag)).await.expect(304);
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn export_has_fewer_clamps_when_the_texture_is_bounded_and_bad_bounds_are_refused() {
    let server = TestServer::start();
    let lineage = TestLineage::new(&server).await;
    let generation = lineage.random(20).await;
    let mut clamps = [0, 0];
    for individual in generation["individuals"].as_array().unwrap() {
        let path = format!("/v1/individuals/{}/exports/wgsl", text_of(&individual["id"]));
        for (count, query) in clamps.iter_mut().zip(["", "?uv_within=1"]) {
            let text = server.get(&format!("{path}{query}")).await.expect(200).text();
            *count += text.matches("= brood_limit(").count();
            assert_eq!(text.contains("Texture positions from -1 to 1 only."), !query.is_empty());
        }
        for bad in ["-1", "65505", "inf", "NaN", "x"] {
            server.get(&format!("{path}?uv_within={bad}")).await.problem(400);
        }
    }
    assert!(2 * clamps[1] < clamps[0] + clamps[0] / 2, "{clamps:?}");
}

#[tokio::test(flavor = "multi_thread")]
async fn unknown_formats_and_individuals_are_refused() {
    let server = TestServer::start();
    let lineage = TestLineage::new(&server).await;
    let id = lineage.random_child(1).await;
    let problem = server.get(&format!("/v1/individuals/{id}/exports/cg")).await.problem(404);
    assert!(text_of(&problem["detail"]).contains("glsl-es-300"), "{problem}");
    let unknown = "0197f3c0-0000-7000-8000-000000000000";
    server.get(&format!("/v1/individuals/{unknown}/exports/wgsl")).await.problem(404);
}

#[tokio::test(flavor = "multi_thread")]
async fn materials_of_objects_are_printed_by_their_names() {
    let server = TestServer::start();
    let path = |query: &str| format!("/v1/exports/glsl-es-300?uv_within=2{query}");
    let code = async |query: &str| server.get(&path(query)).await.expect(200).text();
    let grey = code("").await;
    assert!(grey.contains("evolved("), "{grey}");
    let gold = code("&material=gold").await;
    assert_ne!(gold, grey);
    let toon = code("&material=paint-toon&lights=2").await;
    assert!(toon.contains("vec3 styled("), "{toon}");
    let genome = "brood 1\n.model lambert\nalbedo 0.2 0.1 0.4\n";
    let stored = server.post_bytes("/v1/genomes", "text/x-brood", genome).await;
    let hash = text_of(&stored.expect(201).json()["hash"]).to_owned();
    let own = code(&format!("&material={hash}")).await;
    let posted = server.post_bytes(&path(""), "text/x-brood", genome).await;
    assert_eq!(own, posted.expect(200).text());
    server.get(&path("&material=nothing")).await.problem(422);
    server.get(&path(&format!("&material={}", "0".repeat(64)))).await.problem(404);
    server.get(&path("&lights=9&material=paint-toon")).await.problem(400);
}

#[tokio::test(flavor = "multi_thread")]
async fn geometry_is_returned_for_built_in_and_uploaded_meshes() {
    let server = TestServer::start();
    let knob = server.get("/v1/meshes/knob/geometry").await.expect(200);
    assert!(knob.body.starts_with(b"broodgeo"));
    let obj = "v 0 0 0\nv 4 0 0\nv 0 3 0\nf 1 2 3\n";
    let mesh = server.post_bytes("/v1/meshes", "model/obj", obj).await.expect(201).json();
    let path = format!("/v1/meshes/{}/geometry", text_of(&mesh["id"]));
    let triangle = server.get(&path).await.expect(200);
    assert_eq!(triangle.header("content-type"), "application/vnd.brood.geometry");
    assert_eq!(triangle.body.len(), 56 + 3 * 44 + 12);
    server.get("/v1/meshes/teapot/geometry").await.problem(404);
    let ground = server.get("/v1/meshes/ground/geometry").await.expect(200);
    assert_eq!(ground.body.len(), 56 + 4 * 44 + 2 * 12);
    for (id, vertices) in [(text_of(&mesh["id"]), 3), ("torus".to_owned(), 0)] {
        let glb = server.get(&format!("/v1/meshes/{id}/mesh.glb")).await.expect(200);
        assert_eq!(glb.header("content-type"), "model/gltf-binary");
        assert!(glb.body.starts_with(b"glTF") && glb.body.len() > 48 * vertices, "{id}");
    }
    server.get("/v1/meshes/teapot/mesh.glb").await.problem(404);
}

#[tokio::test(flavor = "multi_thread")]
async fn formats_for_path_tracers_have_the_energy_limit_unless_it_is_off() {
    let server = TestServer::start();
    let bright = "brood 1\n.dialect paper smooth registers 7\n.const C0 3 3 3 0\nMOV R0, C0\n";
    let path = "/v1/exports/mitsuba";
    let post = async |query: &str| {
        let path = format!("{path}{query}");
        server.post_bytes(&path, "text/x-brood", bright).await.expect(200).text()
    };
    let limited = post("").await;
    assert!(limited.contains("It reflects at most 1.0000 of the light"), "{limited}");
    // The same material of an object.
    let stored = server.post_bytes("/v1/genomes", "text/x-brood", bright).await.expect(201).json();
    let object = async |query: &str| {
        let path = format!("{path}?material={}{query}", text_of(&stored["hash"]));
        server.get(&path).await.expect(200).text()
    };
    assert_eq!(object("").await, limited);
    assert_eq!(object("&energy_limit=true").await, limited);
    let raw = object("&energy_limit=false").await;
    assert_eq!(raw, post("?energy_limit=false").await);
    assert!(raw.contains("times the light that it receives: the energy limit is off."), "{raw}");
    let lambert = "brood 1\n.model lambert\n";
    let merl = server.post_bytes("/v1/exports/merl", "text/x-brood", lambert).await.expect(200);
    assert_eq!(merl.body.len(), 34_992_012, "the size of MERL's files");
    assert!(merl.header("brood-note").contains("; error 0.000 %"), "{:?}", merl.headers);
    let painted = server.post_bytes(path, "text/x-brood", TOON).await;
    let problem = painted.problem(422);
    assert!(text_of(&problem["detail"]).contains("is a format of BRDFs"), "{problem}");
}
