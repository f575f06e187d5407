//! Uploaded meshes: parsed with warnings, refused with the line, and rendered.

use brood_tests::{TestLineage, TestServer, ids, raw_request, text_of};
use serde_json::json;

const OBJ: &str = "model/obj";

/// Square pyramid without texture coordinates and normals.
const PYRAMID: &str = include_str!("../data/pyramid.obj");

#[tokio::test(flavor = "multi_thread")]
async fn mesh_is_rendered_when_a_scene_names_it() {
    let server = TestServer::start();
    let mesh = server.post_bytes("/v1/meshes", OBJ, PYRAMID).await.expect(201).json();
    assert_eq!(mesh["triangles"], 6);
    assert_eq!(mesh["has_uv"], false);
    let id = text_of(&mesh["id"]);
    let read = server.get(&format!("/v1/meshes/{id}")).await.expect(200).json();
    assert_eq!(read["id"], mesh["id"]);
    let scene = server.post("/v1/scenes", &json!({"mesh": id})).await.expect(201).json();
    let body = json!({"name": "pyramid", "scene": scene["id"], "thumbnail_px": 64});
    let lineage = TestLineage::with(&server, body).await;
    let child = ids(&lineage.random(1).await)[0].clone();
    let path = format!("/v1/individuals/{child}/render.png?size=64");
    let picture = server.get(&path).await.expect(200).picture();
    let covered = picture.pixels().filter(|pixel| pixel.0[3] > 0).count();
    assert!(
        (300..3000).contains(&covered),
        "the pyramid must cover a part of the picture: {covered}"
    );
    let ball = ids(&TestLineage::new(&server).await.random(1).await)[0].clone();
    let path = format!("/v1/individuals/{ball}/render.png?size=64");
    assert_ne!(server.get(&path).await.expect(200).picture(), picture);
}

#[tokio::test(flavor = "multi_thread")]
async fn mesh_has_warnings_with_lines_when_parts_are_ignored() {
    let server = TestServer::start();
    let odd = format!("mtllib ../../secret.mtl\n{PYRAMID}curv 0 1\n");
    let mesh = server.post_bytes("/v1/meshes", OBJ, odd).await.expect(201).json();
    let warnings = mesh["warnings"].as_array().unwrap();
    assert!(warnings.iter().any(|it| it["line"] == 1), "mtllib is ignored: {warnings:?}");
    assert!(warnings.iter().any(|it| it["line"] == 12), "curv is unknown: {warnings:?}");
}

#[tokio::test(flavor = "multi_thread")]
async fn mesh_is_refused_with_its_line_when_it_is_invalid() {
    let server = TestServer::start();
    let rows = [
        ("v 0 0 0\nv 1 nan 0\nv 0 1 0\nf 1 2 3\n", 2),
        ("v 0 0 0\nv 1 inf 0\nv 0 1 0\nf 1 2 3\n", 2),
        ("v 0 0 0\nv 1 1e39 0\nv 0 1 0\nf 1 2 3\n", 2),
        ("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 4\n", 4),
        ("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 0\n", 4),
        ("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 -4\n", 4),
        ("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 99999999999999999999\n", 4),
        ("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2\n", 4),
        ("v 0 0 0\nv 1 0\nv 0 1 0\nf 1 2 3\n", 2),
    ];
    for (text, line) in rows {
        let problem = server.post_bytes("/v1/meshes", OBJ, text).await.problem(422);
        assert_eq!(problem["line"], line, "{text}: {problem}");
    }
    for text in ["", "v 0 0 0\n", "not an obj file at all\n"] {
        server.post_bytes("/v1/meshes", OBJ, text).await.problem(422);
    }
    let bytes: Vec<u8> = (0..=255).collect();
    server.post_bytes("/v1/meshes", OBJ, bytes).await.problem(422);
}

#[tokio::test(flavor = "multi_thread")]
async fn mesh_is_refused_when_it_is_larger_than_32_mib() {
    let server = TestServer::start();
    let line = "# a comment that fills space, as long as any line of an OBJ file would be long\n";
    let large = line.repeat(33 * 1024 * 1024 / line.len() + 1);
    // Refused by the declared length alone, before any of the body arrives.
    let head = format!(
        "POST /v1/meshes HTTP/1.1\r\nHost: {}\r\nContent-Type: {OBJ}\r\nContent-Length: {}\r\n\
         Connection: close\r\n\r\n",
        server.address(),
        large.len()
    );
    let (status, text) = raw_request(server.address(), head.as_bytes()).await;
    assert_eq!(status, 413, "{text}");
    assert!(text.contains("application/problem+json"), "{text}");
    // In one piece, and in chunks without a declared length.
    let declared = reqwest::Body::from(large.clone());
    let pieces = large.into_bytes();
    let pieces: Vec<Vec<u8>> = pieces.chunks(64 * 1024).map(<[u8]>::to_vec).collect();
    let pieces = futures::stream::iter(pieces.into_iter().map(Ok::<_, std::io::Error>));
    for body in [declared, reqwest::Body::wrap_stream(pieces)] {
        let request = server.request(reqwest::Method::POST, "/v1/meshes");
        // A client that is still sending gets the answer as well.
        server.send(request.header("content-type", OBJ).body(body)).await.problem(413);
    }
    let mesh = server.post_bytes("/v1/meshes", OBJ, PYRAMID).await.expect(201).json();
    assert_eq!(mesh["triangles"], 6, "the server goes on");
}

#[tokio::test(flavor = "multi_thread")]
async fn conventions_of_texture_directions_are_fields_of_scenes() {
    let server = TestServer::start();
    let plain = server.get("/v1/meshes/sphere/geometry").await.expect(200).body;
    let same = server.get("/v1/meshes/sphere/geometry?sphere_pole=y").await.expect(200).body;
    let turned = server.get("/v1/meshes/sphere/geometry?sphere_pole=z").await.expect(200).body;
    assert!(same == plain && turned.len() == plain.len() && turned != plain);
    server.get("/v1/meshes/sphere/mesh.glb?sphere_pole=z").await.expect(200);
    for path in ["knob/geometry?sphere_pole=z", "sphere/geometry?sphere_pole=x"] {
        server.get(&format!("/v1/meshes/{path}")).await.problem(400);
    }
    let refused = json!({"mesh": "knob", "sphere_pole": "z"});
    let problem = server.post("/v1/scenes", &refused).await.problem(422);
    assert_eq!(problem["pointer"], "/sphere_pole", "{problem}");
    let mut pictures = Vec::new();
    for fields in [
        json!({}),
        json!({"sphere_pole": "z"}),
        json!({"tangents": "triangle"}),
        json!({"tangents": "vertex", "sphere_pole": "y"}),
    ] {
        let scene = server.post("/v1/scenes", &fields).await.expect(201).json();
        let dialect = json!({"length": 0});
        let body = json!({"name": "brushed", "scene": scene["id"], "dialect": dialect});
        let lineage = TestLineage::with(&server, body).await;
        let adopted = json!({"presets": ["model-copper"]});
        let one = server.post(&lineage.path("/adoptions"), &adopted).await.expect(201).json();
        let child = text_of(&one["individuals"][0]["id"]);
        let path = format!("/v1/individuals/{child}/render.png?size=64");
        pictures.push(server.get(&path).await.expect(200).picture());
    }
    assert_ne!(pictures[0], pictures[1], "another pole turns the highlight");
    assert_eq!(pictures[0], pictures[3], "defaults change nothing");
}
