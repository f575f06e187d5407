//! Edited genomes: models with their parameters, source code of a genome that is not stored, and
//! adoption as a child.

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
    let removed = server.get(&format!("{path}?cursor={}", uuid::Uuid::nil())).await.expect(400);
    assert!(removed.text().contains("was removed"), "{}", removed.text());
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

#[tokio::test(flavor = "multi_thread")]
async fn a_genome_is_printed_as_source_code_without_being_stored() {
    let edited = Edited::new().await;
    let Edited { server, lineage, parent } = &edited;
    let text = edited.text(0.61).await;
    let path = "/v1/exports/glsl-es-300?uv_within=1";
    let printed = server.post_bytes(path, TEXT, text.clone()).await.expect(200);
    assert!(printed.header("content-type").starts_with("text/plain"), "{:?}", printed.headers);
    let printed = printed.text();
    let stored = server.get(&format!("{lineage}/generations")).await.expect(200).json();
    assert_eq!(stored["items"].as_array().unwrap().len(), 1);
    let body = json!({"genomes": [edited.stored(0.61).await], "parent": parent["id"]});
    let made = server.post(&format!("{lineage}/adoptions"), &body).await.expect(201).json();
    let id = text_of(&made["individuals"][0]["id"]);
    let same = format!("/v1/individuals/{id}/exports/glsl-es-300?uv_within=1");
    assert_eq!(server.get(&same).await.expect(200).text(), printed);
    let genome = format!("/v1/genomes/{}", text_of(&made["individuals"][0]["hash"]));
    let genome = server.get(&genome).await.expect(200).json();
    assert_eq!(server.post(path, &genome).await.expect(200).text(), printed, "JSON is the same");
    let limited = server.post(&format!("{path}&energy_limit=true"), &genome).await.expect(200);
    let same = format!("{same}&energy_limit=true");
    assert_eq!(limited.text(), server.get(&same).await.expect(200).text());

    let problem = server.post_bytes(path, TEXT, edited.text(2.0).await).await.problem(422);
    assert!(text_of(&problem["detail"]).contains("roughness must be between"), "{problem}");
    assert!(problem["line"].as_u64().is_some(), "{problem}");
    server.post_bytes("/v1/exports/cg", TEXT, text.clone()).await.problem(404);
    server.post_bytes("/v1/exports/wgsl?uv_within=-1", TEXT, text.clone()).await.problem(400);
    server.post_bytes("/v1/exports/wgsl", "image/png", text).await.problem(415);
}

#[tokio::test(flavor = "multi_thread")]
async fn models_are_listed_with_the_ranges_of_their_parameters() {
    let server = TestServer::start();
    let models = server.get("/v1/models").await.expect(200).json();
    let models = models.as_array().unwrap();
    assert!(models.len() >= 15);
    let conductor = models.iter().find(|one| one["name"] == "conductor").unwrap();
    let find = |name: &str| {
        let all = conductor["parameters"].as_array().unwrap();
        all.iter().find(|one| one["name"] == name).unwrap()
    };
    let roughness = find("roughness");
    assert_eq!(roughness["range"], json!([1e-4, 1.0]));
    assert_eq!(
        (&roughness["kind"], &roughness["scale"], &roughness["default"]),
        (&json!("scalar"), &json!("logarithmic"), &json!([0.2]))
    );
    assert_eq!(
        (&find("eta")["kind"], &find("stretch")["scale"]),
        (&json!("color"), &json!("linear"))
    );
    let distribution = find("distribution");
    assert_eq!(distribution["kind"], "choice");
    assert_eq!(distribution["default"], json!([0.0]));
    assert!(distribution["words"].as_array().unwrap().contains(&json!("ggx")), "{distribution}");
}

#[tokio::test(flavor = "multi_thread")]
async fn a_genome_is_rendered_without_being_stored() {
    let edited = Edited::new().await;
    let Edited { server, lineage, parent } = &edited;
    let scene = text_of(&server.get(lineage).await.expect(200).json()["scene"]).to_owned();
    let path = format!("/v1/render.png?scene={scene}&size=32&light_deg=20");
    let text = edited.text(0.45).await;
    let drawn = server.post_bytes(&path, TEXT, text.clone()).await.expect(200);
    assert_eq!(drawn.picture().dimensions(), (32, 32));
    let body = json!({"genomes": [edited.stored(0.45).await], "parent": parent["id"]});
    let made = server.post(&format!("{lineage}/adoptions"), &body).await.expect(201).json();
    let id = text_of(&made["individuals"][0]["id"]);
    let same = format!("/v1/individuals/{id}/render.png?size=32&light_deg=20");
    assert_eq!(server.get(&same).await.expect(200).body, drawn.body);

    let problem = server.post_bytes(&path, TEXT, "brood 1\nnonsense\n").await.problem(422);
    assert_eq!(problem["line"], json!(2), "{problem}");
    server.post_bytes("/v1/render.png", TEXT, text.clone()).await.problem(400);
    let unknown = "/v1/render.png?scene=0197f3c0-0000-7000-8000-000000000000";
    server.post_bytes(unknown, TEXT, text.clone()).await.problem(404);
    server.post_bytes(&format!("{path}&samples=4"), TEXT, text).await.problem(400);
}
