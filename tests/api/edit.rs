//! Edited genomes: adoption as a child.

use brood_tests::{TestLineage, TestServer, text_of};
use reqwest::Method;
use serde_json::{Value, json};

const TEXT: &str = "text/x-brood";

/// Lineage of models with one preset in it.
struct Edited {
    server: TestServer,
    lineage: String,
    parent: Value,
}

impl Edited {
    async fn new() -> Self {
        let server = TestServer::start();
        let body = json!({"name": "edited", "dialect": {"length": 0}, "thumbnail_px": 16});
        let made = server.post("/v1/lineages", &body).await.expect(201).json();
        let lineage = format!("/v1/lineages/{}", text_of(&made["id"]));
        let body = json!({"presets": ["model-gold"]});
        let made = server.post(&format!("{lineage}/adoptions"), &body).await.expect(201).json();
        Self { server, lineage, parent: made["individuals"][0].clone() }
    }

    /// Returns the parent's text with another roughness.
    async fn text(&self, roughness: f64) -> String {
        let path = format!("/v1/genomes/{}", text_of(&self.parent["hash"]));
        let request = self.server.request(Method::GET, &path).header("accept", TEXT);
        let text = self.server.send(request).await.expect(200).text();
        let lines = text.lines().map(|line| match line.starts_with("roughness ") {
            true => format!("roughness {roughness}\n"),
            false => format!("{line}\n"),
        });
        lines.collect()
    }

    async fn stored(&self, roughness: f64) -> Value {
        let text = self.text(roughness).await;
        let made = self.server.post_bytes("/v1/genomes", TEXT, text).await;
        made.expect(201).json()["hash"].clone()
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn an_edited_genome_becomes_a_child_that_is_bred_on_and_saved_with_its_parent() {
    let edited = Edited::new().await;
    let Edited { server, lineage, parent } = &edited;
    let body = json!({"genomes": [edited.stored(0.5).await], "parent": parent["id"]});
    let path = format!("{lineage}/adoptions");
    let made = server.post(&path, &body).await.expect(201).json();
    let child = &made["individuals"][0];
    assert_eq!((&made["parents"], &made["index"]), (&json!([parent["id"]]), &json!(1)));
    assert_eq!((&made["centre"]["id"], &child["operator"]), (&parent["id"], &json!("adopt")));
    assert_eq!(child["parents"], json!([parent["id"]]));
    assert_ne!(child["hash"], parent["hash"]);
    server.get(&text_of(&child["thumbnail"])).await.expect(200).picture();
    let body = json!({"parents": [child["id"]], "count": 3, "seed": 1});
    let bred = server.post(&format!("{lineage}/generations"), &body).await.expect(201).json();
    let id = text_of(&bred["individuals"][0]["id"]);
    let path = format!("/v1/individuals/{id}/ancestry");
    let ancestors = server.get(&path).await.expect(200).json();
    let ids = |all: &Value| -> Vec<Value> {
        let all = all.as_array().or_else(|| all["items"].as_array()).unwrap();
        all.iter().map(|one| one["id"].clone()).collect()
    };
    assert_eq!(ids(&ancestors), [child["id"].clone(), parent["id"].clone()]);
    let path = format!("/v1/individuals/{}/descendants", text_of(&parent["id"]));
    let descendants = server.get(&path).await.expect(200).json();
    assert_eq!(ids(&descendants)[0], child["id"], "the child, then its brood");
    assert_eq!(ids(&descendants).len(), 4);
    let file = server.get(&format!("{lineage}/file")).await.expect(200).body;
    let other = TestServer::start();
    let imported = other.post_bytes("/v1/lineages/import", "application/json", file).await;
    let id = text_of(&imported.expect(201).json()["id"]).to_owned();
    let there = other.get(&format!("/v1/lineages/{id}/generations")).await.expect(200).json();
    let there = there["items"].as_array().unwrap();
    let twin = &there[1]["individuals"][0];
    assert_eq!((&twin["hash"], &twin["operator"]), (&child["hash"], &json!("adopt")));
    assert_eq!(there[1]["parents"], json!([there[0]["individuals"][0]["id"]]));
    assert_eq!(there[2]["parents"], json!([twin["id"]]));
}

#[tokio::test(flavor = "multi_thread")]
async fn a_parent_that_cannot_adopt_is_refused_with_a_pointer() {
    let edited = Edited::new().await;
    let Edited { server, lineage, parent } = &edited;
    let stranger = TestLineage::new(server).await.random_child(1).await;
    let hash = edited.stored(0.4).await;
    let rows = [
        (json!(stranger), 422),
        (json!("0197f3c0-0000-7000-8000-000000000000"), 404),
        (json!("gold"), 400),
        (json!([parent["id"]]), 400),
        (parent["hash"].clone(), 400),
    ];
    for (wrong, status) in rows {
        let body = json!({"genomes": [hash], "parent": wrong});
        let problem = server.post(&format!("{lineage}/adoptions"), &body).await.problem(status);
        assert_eq!(problem["pointer"], "/parent", "{problem}");
    }
    let list = server.get(&format!("{lineage}/generations")).await.expect(200).json();
    assert_eq!(list["items"].as_array().unwrap().len(), 1, "a refused request stores nothing");
}
