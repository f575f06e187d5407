//! Lineages: created, listed, changed under `If-Match`, hidden, purged, exported and imported.

use brood_tests::{TestLineage, TestServer, hashes, ids, text_of};
use serde_json::{Value, json};

#[tokio::test(flavor = "multi_thread")]
async fn lineage_has_defaults_when_only_a_name_is_given() {
    let server = TestServer::start();
    let answer = server.post("/v1/lineages", &json!({"name": "first"})).await.expect(201);
    let lineage = answer.json();
    assert_eq!(answer.header("location"), format!("/v1/lineages/{}", text_of(&lineage["id"])));
    assert_eq!(lineage["name"], "first");
    assert_eq!(lineage["thumbnail_px"], 256);
    assert_eq!(lineage["generations"], 0);
    let dialect = json!({
        "opcodes": "paper", "parametrisation": "smooth", "registers": 7, "length": 100,
        "isotropic": false, "homogeneous": false,
    });
    assert_eq!(lineage["dialect"], dialect);
    let read = server.get(&format!("/v1/lineages/{}", text_of(&lineage["id"]))).await.expect(200);
    assert_eq!(read.json(), lineage);
}

#[tokio::test(flavor = "multi_thread")]
async fn lineage_is_refused_when_a_field_is_invalid() {
    let server = TestServer::start();
    let unknown = "01900000-0000-7000-8000-000000000000";
    let rows = [
        (400, json!({})),
        (400, json!({"name": 7})),
        (400, json!({"name": "a", "dialect": {"opcodes": "modern"}})),
        (422, json!({"name": ""})),
        (422, json!({"name": "x".repeat(201)})),
        (422, json!({"name": "a", "thumbnail_px": 15})),
        (422, json!({"name": "a", "thumbnail_px": 100_000})),
        (422, json!({"name": "a", "saturation": 2})),
        (422, json!({"name": "a", "dialect": {"registers": 3}})),
        (422, json!({"name": "a", "dialect": {"length": 1025}})),
        (404, json!({"name": "a", "scene": unknown})),
    ];
    for (status, body) in rows {
        let answer = server.post("/v1/lineages", &body).await;
        assert_eq!(answer.status, status, "{body}: {}", answer.text());
        answer.problem(status);
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn patch_needs_the_current_version() {
    let server = TestServer::start();
    let lineage = TestLineage::new(&server).await;
    let path = lineage.path("");
    let tag = server.get(&path).await.expect(200).header("etag");
    assert!(tag.starts_with('"'), "a strong tag: {tag}");
    server.patch(&path, None, &json!({"name": "second"})).await.problem(428);
    let changed = server.patch(&path, Some(&tag), &json!({"name": "second"})).await.expect(200);
    assert_eq!(changed.json()["name"], "second");
    assert_ne!(changed.header("etag"), tag);
    server.patch(&path, Some(&tag), &json!({"name": "third"})).await.problem(412);
    assert_eq!(server.get(&path).await.expect(200).json()["name"], "second");
    let tag = changed.header("etag");
    server.patch(&path, Some(&tag), &json!({"id": "x"})).await.problem(400);
}

/// Creates lineages; returns their ids.
async fn lineages(server: &TestServer, count: u32) -> Vec<String> {
    let mut made = Vec::new();
    for number in 0..count {
        let body = json!({"name": format!("lineage {number}"), "thumbnail_px": 32});
        made.push(TestLineage::with(server, body).await.id);
    }
    made
}

#[tokio::test(flavor = "multi_thread")]
async fn list_is_read_in_pages_when_there_are_many() {
    let server = TestServer::start();
    let mut made = lineages(&server, 5).await;
    let mut seen = Vec::new();
    let mut path = "/v1/lineages?limit=2".to_owned();
    loop {
        let page = server.get(&path).await.expect(200).json();
        let items = page["items"].as_array().unwrap();
        assert!(items.len() <= 2);
        seen.extend(items.iter().map(|lineage| text_of(&lineage["id"])));
        match &page["next"] {
            Value::Null => break,
            cursor => path = format!("/v1/lineages?limit=2&cursor={}", text_of(cursor)),
        }
    }
    seen.sort();
    made.sort();
    assert_eq!(seen, made, "each one once");
}

#[tokio::test(flavor = "multi_thread")]
async fn list_continues_when_the_last_item_of_a_page_is_purged() {
    let server = TestServer::start();
    let made = lineages(&server, 3).await;
    let first = server.get("/v1/lineages?limit=2").await.expect(200).json();
    let last = text_of(&first["items"][1]["id"]);
    server.delete(&format!("/v1/lineages/{last}?purge=true")).await.expect(204);
    let path = format!("/v1/lineages?limit=2&cursor={}", text_of(&first["next"]));
    let rest = server.get(&path).await.expect(200).json();
    let rest: Vec<_> =
        rest["items"].as_array().unwrap().iter().map(|one| text_of(&one["id"])).collect();
    assert_eq!(rest, made[..1]);
    server.get(&format!("/v1/lineages?cursor={last}")).await.problem(400);
}

#[tokio::test(flavor = "multi_thread")]
async fn generations_are_read_oldest_first_when_paged() {
    let server = TestServer::start();
    let lineage = TestLineage::new(&server).await;
    for seed in 0..5 {
        lineage.random(seed).await;
    }
    let first = server.get(&lineage.path("/generations?limit=3")).await.expect(200).json();
    let cursor = text_of(&first["next"]);
    let path = lineage.path(&format!("/generations?limit=3&cursor={cursor}"));
    let second = server.get(&path).await.expect(200).json();
    assert_eq!(second["next"], Value::Null);
    let pages = [first, second];
    let indices: Vec<u64> = pages
        .iter()
        .flat_map(|page| page["items"].as_array().unwrap())
        .map(|generation| generation["index"].as_u64().unwrap())
        .collect();
    assert_eq!(indices, [0, 1, 2, 3, 4]);
    let one = &pages[0]["items"][1];
    let alone = server.get(&format!("/v1/generations/{}", text_of(&one["id"]))).await.expect(200);
    assert_eq!(alone.json(), *one);
}

#[tokio::test(flavor = "multi_thread")]
async fn lineage_is_unlisted_when_hidden_and_removed_when_purged() {
    let server = TestServer::start();
    let lineage = TestLineage::new(&server).await;
    let generation = lineage.random(1).await;
    server.delete(&lineage.path("")).await.expect(204);
    let listed = server.get("/v1/lineages").await.expect(200).json();
    assert_eq!(listed["items"], json!([]));
    let child = format!("/v1/individuals/{}", ids(&generation)[0]);
    server.get(&child).await.expect(200);
    // Both are in the server's caches now, and must be gone after the purge all the same.
    let genome = format!("/v1/genomes/{}", hashes(&generation)[0]);
    let thumbnail = text_of(&generation["individuals"][0]["thumbnail"]);
    server.get(&genome).await.expect(200);
    server.get(&thumbnail).await.expect(200);
    server.delete(&lineage.path("?purge=true")).await.expect(204);
    for gone in [&lineage.path(""), &child, &genome, &thumbnail] {
        server.get(gone).await.problem(404);
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn lineage_has_the_same_hashes_when_imported_on_another_server() {
    let server = TestServer::start();
    let lineage = TestLineage::new(&server).await;
    let first = lineage.random(1).await;
    lineage.breed(json!({"parents": [ids(&first)[0]], "count": 3, "seed": 2})).await;
    let file = server.get(&lineage.path("/file")).await.expect(200);

    let other = TestServer::start();
    let kind = file.header("content-type");
    let imported = other.post_bytes("/v1/lineages/import", &kind, file.body).await.expect(201);
    let id = text_of(&imported.json()["id"]);
    let path = format!("/v1/lineages/{id}/generations");
    let there = other.get(&path).await.expect(200).json();
    let here = server.get(&lineage.path("/generations")).await.expect(200).json();
    let all = |list: &Value| -> Vec<Vec<String>> {
        list["items"].as_array().unwrap().iter().map(hashes).collect()
    };
    assert_eq!(all(&there), all(&here));
    let second = &there["items"][1];
    assert_eq!(second["parents"], json!([ids(&there["items"][0])[0]]), "parents have the new ids");
    let kind = "application/json";
    other.post_bytes("/v1/lineages/import", kind, "{\"brood\": 1}").await.problem(400);
}

#[tokio::test(flavor = "multi_thread")]
async fn file_is_refused_when_breeding_could_not_have_made_its_history() {
    let server = TestServer::start();
    let lineage = TestLineage::new(&server).await;
    let first = lineage.random(1).await;
    lineage.breed(json!({"parents": [ids(&first)[0]], "count": 3, "seed": 2})).await;
    let file = server.get(&lineage.path("/file")).await.expect(200).json();
    server.post("/v1/lineages/import", &file).await.expect(201);

    let other = file["generations"][0]["individuals"][1]["id"].clone();
    let rows = [
        ("/generations/1/parents", json!([]), "/generations/1/centre"),
        ("/generations/1/centre", other, "/generations/1/centre"),
        (
            "/generations/1/individuals/2/operator",
            json!("recombine"),
            "/generations/1/individuals/2/operator",
        ),
        (
            "/generations/0/parents",
            json!([file["genomes"].as_object().unwrap().keys().next()]),
            "/generations/0/individuals/0/operator",
        ),
    ];
    for (pointer, value, at) in rows {
        let mut changed = file.clone();
        *changed.pointer_mut(pointer).unwrap() = value;
        let answer = server.post("/v1/lineages/import", &changed).await;
        assert_eq!(answer.status, 422, "{pointer}: {}", answer.text());
        assert_eq!(answer.json()["pointer"], at, "{}", answer.text());
    }
    let mut changed = file.clone();
    changed["generations"][1]["steer"] = json!(["warmer", "cooler"]);
    let answer = server.post("/v1/lineages/import", &changed).await;
    assert_eq!(answer.problem(422)["pointer"], "/generations/1/steer");
}

#[tokio::test(flavor = "multi_thread")]
async fn thumbnails_change_when_the_scene_of_a_lineage_changes() {
    let server = TestServer::start();
    let lineage = TestLineage::new(&server).await;
    let generation = lineage.random(1).await;
    let scene = server.post("/v1/scenes", &json!({"mesh": "torus"})).await.expect(201).json();
    let tag = server.get(&lineage.path("")).await.expect(200).header("etag");
    let change = json!({"scene": scene["id"]});
    server.patch(&lineage.path(""), Some(&tag), &change).await.expect(200);
    let path = format!("/v1/generations/{}", text_of(&generation["id"]));
    let now = server.get(&path).await.expect(200).json();
    assert_eq!(hashes(&now), hashes(&generation));
    let url = |it: &Value| text_of(&it["individuals"][0]["thumbnail"]);
    assert_ne!(url(&now), url(&generation));
    let sphere = server.get(&url(&generation)).await.expect(200).picture();
    let torus = server.get(&url(&now)).await.expect(200).picture();
    assert_ne!(sphere, torus);
}
