//! The list of lineages: search, tags, hidden lineages, covers; and favourites of all of them.

use brood_tests::{ServerOptions, TestLineage, TestServer, ids, text_of};
use serde_json::{Value, json};
use sqlx::Connection;
use sqlx::sqlite::{SqliteConnectOptions, SqliteConnection};

/// Changes something under its present version; returns the answer.
async fn change(server: &TestServer, path: &str, body: Value) -> Value {
    let tag = server.get(path).await.expect(200).header("etag");
    server.patch(path, Some(&tag), &body).await.expect(200).json()
}

/// Reads all pages of a list, two items each.
async fn all(server: &TestServer, path: &str) -> Vec<Value> {
    let mut items = Vec::new();
    let mut next = Value::String(String::new());
    while let Value::String(cursor) = next {
        let cursor = if cursor.is_empty() { cursor } else { format!("&cursor={cursor}") };
        let page = server.get(&format!("{path}limit=2{cursor}")).await.expect(200).json();
        items.extend(page["items"].as_array().unwrap().clone());
        next = page["next"].clone();
    }
    items
}

fn column(items: &[Value], name: &str) -> Vec<String> {
    items.iter().map(|item| text_of(&item[name])).collect()
}

#[tokio::test(flavor = "multi_thread")]
async fn lineages_are_found_by_name_tag_and_note() {
    let server = TestServer::start();
    for number in 0..5 {
        let body = json!({
            "name": format!("Étude {number}"), "notes": "for the kitchen", "thumbnail_px": 32,
            "tags": if number < 3 { json!(["car paint"]) } else { json!([]) },
        });
        let lineage = TestLineage::with(&server, body).await;
        if number == 4 {
            change(&server, &lineage.path(""), json!({"tags": ["Glas", "blau"]})).await;
        }
    }
    for (search, count) in [
        ("", 5),
        ("%C3%A9tude", 5),
        ("KITCHEN%203", 1),
        ("car+paint", 3),
        ("glas", 1),
        ("glas%20paint", 0),
        ("%25", 0),
    ] {
        let found = all(&server, &format!("/v1/lineages?search={search}&")).await;
        assert_eq!(found.len(), count, "{search}: {found:?}");
    }
    let long = "x".repeat(201);
    server.get(&format!("/v1/lineages?search={long}")).await.problem(400);
    server.get("/v1/lineages?hidden=maybe").await.problem(400);
}

#[tokio::test(flavor = "multi_thread")]
async fn tags_are_refused_when_they_are_not_a_few_short_words() {
    let server = TestServer::start();
    let lineage = TestLineage::new(&server).await;
    let tag = server.get(&lineage.path("")).await.expect(200).header("etag");
    let many: Vec<_> = (0..13).map(|number| format!("tag {number}")).collect();
    for (tags, pointer) in [
        (json!(many), "/tags"),
        (json!(["gold", ""]), "/tags/1"),
        (json!([" gold"]), "/tags/0"),
        (json!(["a,b"]), "/tags/0"),
        (json!(["a\nb"]), "/tags/0"),
        (json!(["x".repeat(31)]), "/tags/0"),
        (json!(["gold", "clay", "GOLD"]), "/tags/2"),
    ] {
        let answer = server.patch(&lineage.path(""), Some(&tag), &json!({"tags": tags})).await;
        assert_eq!(answer.problem(422)["pointer"], pointer, "{tags}");
        server.post("/v1/lineages", &json!({"name": "a", "tags": tags})).await.problem(422);
    }
    server.patch(&lineage.path(""), Some(&tag), &json!({"tags": "gold"})).await.problem(400);
}

#[tokio::test(flavor = "multi_thread")]
async fn hidden_lineage_is_listed_apart_and_restored() {
    let server = TestServer::start();
    let (kept, hidden) = (TestLineage::new(&server).await, TestLineage::new(&server).await);
    server.delete(&hidden.path("")).await.expect(204);
    let listed = |path: &'static str| async { column(&all(&server, path).await, "id") };
    assert_eq!(listed("/v1/lineages?").await, [kept.id.as_str()]);
    assert_eq!(listed("/v1/lineages?hidden=true&").await, [hidden.id.as_str()]);
    let restored = change(&server, &hidden.path(""), json!({"hidden": false})).await;
    assert_eq!(restored["hidden"], false);
    assert_eq!(listed("/v1/lineages?").await, [hidden.id.clone(), kept.id.clone()]);
    change(&server, &kept.path(""), json!({"hidden": true})).await;
    assert_eq!(listed("/v1/lineages?hidden=true&").await, [kept.id.as_str()]);
}

#[tokio::test(flavor = "multi_thread")]
async fn cover_is_the_chosen_individual_also_after_export_and_import() {
    let server = TestServer::start();
    let lineage = TestLineage::new(&server).await;
    let generation = lineage.random(1).await;
    let chosen = &generation["individuals"][2];
    let other = TestLineage::new(&server).await.random_child(2).await;
    let body = json!({"cover_individual": chosen["id"], "tags": ["metal"]});
    change(&server, &lineage.path(""), body).await;
    let listed = all(&server, "/v1/lineages?search=metal&").await;
    assert_eq!(listed[0]["cover"], chosen["thumbnail"]);
    let tag = server.get(&lineage.path("")).await.expect(200).header("etag");
    let body = json!({"cover_individual": other});
    let foreign = server.patch(&lineage.path(""), Some(&tag), &body).await;
    assert_eq!(foreign.problem(422)["pointer"], "/cover_individual");

    let file = server.get(&lineage.path("/file")).await.expect(200).json();
    let imported = server.post("/v1/lineages/import", &file).await.expect(201).json();
    assert_eq!(imported["tags"], json!(["metal"]));
    assert_ne!(imported["cover_individual"], chosen["id"], "individuals have new ids");
    let listed = all(&server, "/v1/lineages?search=metal&").await;
    let covers = column(&listed, "cover");
    assert_eq!(covers[0], covers[1], "the same material in the same scene");

    let cleared = change(&server, &lineage.path(""), json!({"cover_individual": null})).await;
    assert_eq!(cleared["cover_individual"], Value::Null);
    let listed = all(&server, "/v1/lineages?search=metal&").await;
    assert_eq!(listed[1]["cover"], generation["individuals"][0]["thumbnail"]);
}

#[tokio::test(flavor = "multi_thread")]
async fn favourites_of_all_lineages_are_paged_with_their_place() {
    let server = TestServer::start();
    let (first, second) = (TestLineage::new(&server).await, TestLineage::new(&server).await);
    let mut marked = Vec::new();
    for (lineage, seed) in [(&first, 1), (&second, 2), (&first, 3)] {
        for id in &ids(&lineage.random(seed).await)[..2] {
            let path = format!("/v1/individuals/{id}");
            let changed = change(&server, &path, json!({"favourite": true})).await;
            assert_eq!(changed["generation_index"], u32::from(seed == 3));
            marked.push(id.clone());
        }
    }
    marked.reverse();
    let found = all(&server, "/v1/individuals?favourite=true&").await;
    assert_eq!(column(&found, "id"), marked, "newest first");
    assert_eq!(found[0]["generation_index"], 1);
    assert_eq!(server.get(&first.path("")).await.expect(200).json()["favourites"], 4);
    let of_one = format!("/v1/individuals?favourite=true&lineage={}&", second.id);
    assert_eq!(column(&all(&server, &of_one).await, "id"), marked[2..4]);
    server.delete(&second.path("")).await.expect(204);
    assert_eq!(all(&server, "/v1/individuals?favourite=true&").await.len(), 4);
    assert_eq!(all(&server, &of_one).await.len(), 2, "named, hidden ones are listed");
    let unknown = "01900000-0000-7000-8000-000000000000";
    server.get(&format!("/v1/individuals?favourite=true&lineage={unknown}")).await.problem(404);
    server.get("/v1/individuals?favourite=true&lineage=x").await.problem(400);
    server.get(&format!("/v1/individuals?lineage={}", first.id)).await.problem(400);
}

#[tokio::test(flavor = "multi_thread")]
async fn data_of_an_earlier_version_has_no_tags_and_its_hidden_lineages_can_be_restored() {
    let mut server = TestServer::start();
    let lineage = TestLineage::new(&server).await;
    let (id, path) = (lineage.id.clone(), lineage.path(""));
    lineage.random(1).await;
    server.delete(&path).await.expect(204);
    assert_eq!(server.terminate(), 0);
    let options = SqliteConnectOptions::new().filename(server.data().join("brood.db"));
    let mut database = SqliteConnection::connect_with(&options).await.unwrap();
    for sql in [
        "ALTER TABLE target_file DROP COLUMN object",
        "ALTER TABLE light_asset DROP COLUMN object",
        "ALTER TABLE mesh DROP COLUMN object",
        "DROP TABLE migrant",
        "DROP INDEX search_parent",
        "ALTER TABLE search DROP COLUMN found",
        "ALTER TABLE search DROP COLUMN awaits",
        "ALTER TABLE search DROP COLUMN previous_id",
        "ALTER TABLE search DROP COLUMN island",
        "ALTER TABLE search DROP COLUMN parent_id",
        "DROP TABLE search_checkpoint",
        "DROP INDEX search_running",
        "ALTER TABLE search DROP COLUMN lease_until_ms",
        "ALTER TABLE search ADD COLUMN checkpoint BLOB",
        "DROP TABLE unfinished_lineage",
        "DROP INDEX generation_parent_generation",
        "ALTER TABLE generation_parent DROP COLUMN parent_generation_id",
        "CREATE TABLE job (id BLOB NOT NULL PRIMARY KEY, queue TEXT NOT NULL, state TEXT NOT NULL)",
        "CREATE INDEX job_waiting ON job (queue, id) WHERE state = 'queued'",
        "ALTER TABLE genome DROP COLUMN bases",
        "DROP TABLE closed",
        "ALTER TABLE search DROP COLUMN brightest_png",
        "ALTER TABLE search DROP COLUMN darkest_png",
        "ALTER TABLE search DROP COLUMN spread_json",
        "DROP TABLE export_file",
        "DROP TABLE export",
        "DROP INDEX lineage_cover",
        "DROP INDEX individual_lineage_favourite",
        "ALTER TABLE lineage DROP COLUMN cover_id",
        "ALTER TABLE lineage DROP COLUMN tags_json",
        "ALTER TABLE lineage DROP COLUMN start",
        "ALTER TABLE generation DROP COLUMN steer_json",
        "ALTER TABLE generation DROP COLUMN painting_json",
        "ALTER TABLE generation DROP COLUMN bumps",
        "DELETE FROM _sqlx_migrations WHERE version >= 15",
    ] {
        sqlx::query(sql).execute(&mut database).await.unwrap();
    }
    database.close().await.unwrap();
    server.restart_with(ServerOptions::default());
    let hidden = all(&server, "/v1/lineages?hidden=true&").await;
    assert_eq!(column(&hidden, "id"), [id]);
    assert_eq!((&hidden[0]["tags"], &hidden[0]["hidden"]), (&json!([]), &json!(true)));
    assert!(hidden[0]["cover"].is_string());
    change(&server, &path, json!({"hidden": false, "tags": ["old"]})).await;
    assert_eq!(all(&server, "/v1/lineages?search=old&").await.len(), 1);
}
