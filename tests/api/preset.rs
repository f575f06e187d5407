//! Presets, and adoption of genomes into a lineage.

use brood_tests::{TestLineage, TestServer, text_of};
use serde_json::{Value, json};

async fn presets(server: &TestServer) -> Vec<Value> {
    server.get("/v1/presets").await.expect(200).json().as_array().unwrap().clone()
}

async fn lineage_of(server: &TestServer, dialect: &Value) -> String {
    let body = json!({"name": "presets", "dialect": dialect, "thumbnail_px": 16});
    let lineage = server.post("/v1/lineages", &body).await.expect(201).json();
    format!("/v1/lineages/{}", text_of(&lineage["id"]))
}

#[tokio::test(flavor = "multi_thread")]
async fn every_preset_can_be_adopted_and_bred() {
    let server = TestServer::start();
    let presets = presets(&server).await;
    assert!(presets.len() >= 12);
    for preset in presets {
        let lineage = lineage_of(&server, &preset["dialect"]).await;
        let body = json!({"presets": [preset["name"]]});
        let made = server.post(&format!("{lineage}/adoptions"), &body).await.expect(201).json();
        let one = &made["individuals"][0];
        assert_eq!((&one["operator"], &one["slot"]), (&json!("adopt"), &json!(0)));
        assert_eq!((&made["parents"], &made["centre"]), (&json!([]), &Value::Null));
        server.get(&text_of(&one["thumbnail"])).await.expect(200).picture();
        let body = json!({"parents": [one["id"]], "count": 3, "seed": 1});
        let bred = server.post(&format!("{lineage}/generations"), &body).await.expect(201).json();
        assert_eq!(bred["centre"]["id"], one["id"]);
        assert_eq!(bred["individuals"].as_array().unwrap().len(), 3);
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn adopted_genomes_are_padded_to_the_lineage_and_exported_with_it() {
    let server = TestServer::start();
    let lineage = TestLineage::new(&server).await;
    let short = "brood 1\n.dialect paper smooth registers 7\nSIN R0.xyz, R0.x\n";
    let saved = server.post_bytes("/v1/genomes", "text/x-brood", short).await.expect(201).json();
    let body = json!({"genomes": [saved["hash"]], "presets": ["gold"]});
    let path = lineage.path("/adoptions");
    let made = server.post(&path, &body).await.expect(201).json();
    let individuals = made["individuals"].as_array().unwrap();
    assert_eq!(individuals.len(), 2);
    assert_ne!(individuals[0]["hash"], saved["hash"], "a padded genome has another hash");
    let long = format!("/v1/genomes/{}", text_of(&individuals[0]["hash"]));
    let long = server.get(&long).await.expect(200).json();
    assert_eq!(long["dialect"]["length"], json!(100));
    let file = server.get(&lineage.path("/file")).await.expect(200);
    let other = TestServer::start();
    let imported = other.post_bytes("/v1/lineages/import", "application/json", file.body).await;
    let id = text_of(&imported.expect(201).json()["id"]).to_owned();
    let there = other.get(&format!("/v1/lineages/{id}/generations")).await.expect(200).json();
    let hashes = |generation: &Value| -> Vec<Value> {
        let individuals = generation["individuals"].as_array().unwrap();
        individuals.iter().map(|one| json!([one["hash"], one["operator"]])).collect()
    };
    assert_eq!(hashes(&there["items"][0]), hashes(&made));
}

#[tokio::test(flavor = "multi_thread")]
async fn genomes_that_cannot_be_adopted_are_refused_with_a_pointer() {
    let server = TestServer::start();
    let lineage = TestLineage::new(&server).await;
    let path = lineage.path("/adoptions");
    let rows = [
        (json!({}), 422, "/genomes"),
        (json!({"presets": ["gold", "lead"]}), 404, "/presets/1"),
        (json!({"presets": ["brushed-metal"]}), 422, "/presets/0"),
        (json!({"genomes": ["gold"]}), 422, "/genomes/0"),
        (json!({"genomes": ["0".repeat(64)]}), 404, "/genomes/0"),
    ];
    for (body, status, pointer) in rows {
        let problem = server.post(&path, &body).await.problem(status);
        assert_eq!(problem["pointer"], json!(pointer), "{problem}");
    }
    let list = server.get(&lineage.path("/generations")).await.expect(200).json();
    assert_eq!(list["items"], json!([]), "a refused request stores nothing");
}
