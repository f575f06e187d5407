//! Bumps: bred, locked, kept by files, exported, drawn.

use brood_tests::{TestLineage, TestServer, hashes, ids, text_of};
use serde_json::{Value, json};

async fn bump(server: &TestServer, hash: &str) -> Value {
    server.get(&format!("/v1/genomes/{hash}")).await.expect(200).json()["bump"].clone()
}

#[tokio::test(flavor = "multi_thread")]
async fn bumps_are_bred_and_kept() {
    let server = TestServer::start();
    let body = json!({"name": "rough", "thumbnail_px": 32, "start": "models"});
    let lineage = TestLineage::with(&server, body).await;
    let constraints = json!({"bumps": true});
    let asked = json!({"parents": [], "count": 4, "seed": 2, "constraints": constraints});
    let first = lineage.breed(asked).await;
    assert_eq!(first["constraints"]["bumps"], json!(true));
    let parent = bump(&server, &hashes(&first)[1]).await;
    assert_eq!(parent["strength"], json!(1.0));
    let children = async |more: Value| {
        let mut asked =
            json!({"parents": [ids(&first)[1]], "count": 4, "seed": 3, "mutation": 0.6});
        asked.as_object_mut().unwrap().extend(more.as_object().unwrap().clone());
        let born = lineage.breed(asked).await;
        let mut bumps = Vec::new();
        for hash in hashes(&born) {
            bumps.push(bump(&server, &hash).await);
        }
        bumps
    };
    assert!(children(json!({})).await.iter().all(|own| own.is_object() && *own != parent));
    let locked = children(json!({"locks": {"bump": true}})).await;
    assert!(locked.iter().all(|own| *own == parent));
    let flat = children(json!({"constraints": {"bumps": false}})).await;
    assert!(flat.iter().all(Value::is_null));
    // The generation is read back, also from a saved lineage.
    let read = server.get(&format!("/v1/generations/{}", text_of(&first["id"]))).await;
    assert_eq!(read.expect(200).json()["constraints"]["bumps"], json!(true));
    let file = server.get(&lineage.path("/file")).await.expect(200).json();
    let copy = server.post("/v1/lineages/import", &file).await.expect(201).json();
    let path = format!("/v1/lineages/{}/file", text_of(&copy["id"]));
    assert!(server.get(&path).await.expect(200).text().contains("\"bump\""));
}

#[tokio::test(flavor = "multi_thread")]
async fn bumps_are_drawn_exported_and_inspected() {
    let server = TestServer::start();
    let body = json!({"name": "rough", "thumbnail_px": 32, "start": "models"});
    let lineage = TestLineage::with(&server, body).await;
    let adopt = json!({"presets": ["model-golf-ball", "model-porcelain"]});
    let adopted = server.post(&lineage.path("/adoptions"), &adopt).await.expect(201).json();
    let [bumped, smooth] = [0, 1].map(|at| ids(&adopted)[at].clone());
    let path = |of: &str, rest: &str| format!("/v1/individuals/{of}/{rest}");
    let export =
        async |of: &str| server.get(&path(of, "exports/glsl-es-300")).await.expect(200).text();
    assert!(export(&bumped).await.contains("vec2 evolved_slopes("));
    assert!(!export(&smooth).await.contains("evolved_slopes"));
    let picture =
        async |of: &str| server.get(&path(of, "render.png?size=64")).await.expect(200).picture();
    assert_ne!(picture(&bumped).await, picture(&smooth).await);
    let found = server.get(&path(&bumped, "inspection")).await.expect(200).json();
    assert!(found["bumps"]["largest"].as_f64().unwrap() > 0.3, "{}", found["bumps"]);
    let found = server.get(&path(&smooth, "inspection")).await.expect(200).json();
    assert_eq!(found["bumps"], Value::Null);
    let text = "brood 1\n.model lambert\n.bump strength 99\n.bump MOV R0, R0\n";
    let refused = server.post_bytes("/v1/genomes", "text/x-brood", text).await.expect(422).json();
    assert!(refused.to_string().contains("from -16 to 16, got `99`"), "{refused}");
}
