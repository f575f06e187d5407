//! Data directories of earlier versions: their rows are changed as those versions wrote them.

use brood_tests::{ServerOptions, TestLineage, TestServer, text_of};
use serde_json::json;
use sqlx::sqlite::{SqliteConnectOptions, SqliteConnection};
use sqlx::{Connection, Row};

const PYRAMID: &str = include_str!("../data/pyramid.obj");

async fn open(server: &TestServer) -> SqliteConnection {
    let options = SqliteConnectOptions::new().filename(server.data().join("brood.db"));
    SqliteConnection::connect_with(&options).await.unwrap()
}

/// Writes an earlier protocol version into the only encoded message of a table.
async fn age(database: &mut SqliteConnection, table: &'static str, column: &'static str) {
    let read = format!("SELECT {column} FROM {table}");
    let row = sqlx::query(sqlx::AssertSqlSafe(read)).fetch_one(&mut *database).await.unwrap();
    let mut message: Vec<u8> = row.get(0);
    assert!(message.starts_with(b"brood/"), "{table}.{column} is a message with its version");
    message[6] = b'4';
    let write = format!("UPDATE {table} SET {column} = ?");
    let write = sqlx::query(sqlx::AssertSqlSafe(write)).bind(message);
    assert_eq!(write.execute(database).await.unwrap().rows_affected(), 1);
}

#[tokio::test(flavor = "multi_thread")]
async fn meshes_of_an_earlier_protocol_are_rendered_and_exported() {
    let mut server = TestServer::start();
    let mesh = server.post_bytes("/v1/meshes", "model/obj", PYRAMID).await.expect(201).json();
    let scene = server.post("/v1/scenes", &json!({"mesh": mesh["id"]})).await.expect(201).json();
    let body = json!({"name": "pyramid", "scene": scene["id"], "thumbnail_px": 32});
    let lineage = TestLineage::with(&server, body).await;
    let child = lineage.random_child(1).await;
    let file = lineage.path("/file");
    let paths = [
        format!("/v1/individuals/{child}/render.png?size=64"),
        format!("/v1/meshes/{}/mesh.glb", text_of(&mesh["id"])),
    ];
    let mut before = Vec::new();
    for path in &paths {
        before.push(server.get(path).await.expect(200).body);
    }
    assert_eq!(server.terminate(), 0);
    let mut database = open(&server).await;
    age(&mut database, "mesh", "data").await;
    database.close().await.unwrap();
    std::fs::remove_dir_all(server.data().join("cache")).unwrap();
    server.restart();
    for (path, before) in paths.iter().zip(before) {
        assert_eq!(server.get(path).await.expect(200).body, before, "{path}");
    }
    let exported = server.get(&file).await.expect(200).json();
    server.post("/v1/lineages/import", &exported).await.expect(201);
}

#[tokio::test(flavor = "multi_thread")]
async fn searches_queued_by_an_earlier_protocol_are_run() {
    let idle = ServerOptions { workers: 0, ..ServerOptions::default() };
    let mut server = TestServer::start_with(idle);
    let body = json!({
        "kind": "fit", "target": server.glossy_target().await, "strategy": "lobes", "threads": 1,
        "generations": 1,
    });
    let search = server.post("/v1/jobs", &body).await.expect(202).json();
    assert_eq!(server.terminate(), 0);
    let mut database = open(&server).await;
    age(&mut database, "search", "start").await;
    database.close().await.unwrap();
    server.restart_with(ServerOptions::default());
    let path = format!("/v1/jobs/{}", text_of(&search["id"]));
    for _ in 0..300 {
        let state = text_of(&server.get(&path).await.expect(200).json()["state"]);
        assert!(state != "failed", "the search cannot be read");
        if state == "succeeded" {
            return;
        }
        tokio::time::sleep(std::time::Duration::from_millis(100)).await;
    }
    panic!("the search does not end");
}

#[tokio::test(flavor = "multi_thread")]
async fn individuals_are_rendered_when_an_operation_has_changed_its_meaning() {
    let mut server = TestServer::start();
    let lineage = TestLineage::new(&server).await;
    let child = lineage.random_child(1).await;
    assert_eq!(server.terminate(), 0);
    let mut database = open(&server).await;
    let foreign = sqlx::query("UPDATE genome SET program_hash = zeroblob(32)");
    assert!(foreign.execute(&mut database).await.unwrap().rows_affected() > 0);
    database.close().await.unwrap();
    server.restart();
    let individual = server.get(&format!("/v1/individuals/{child}")).await.expect(200).json();
    server.get(&text_of(&individual["thumbnail"])).await.expect(200).picture();
    server.get(&format!("/v1/individuals/{child}/render.png")).await.expect(200).picture();
}

#[tokio::test(flavor = "multi_thread")]
async fn key_of_an_earlier_renderer_is_gone_with_the_location_of_the_current_picture() {
    let mut server = TestServer::start();
    let generation = TestLineage::new(&server).await.random(1).await;
    let url = text_of(&generation["individuals"][0]["thumbnail"]);
    let picture = server.get(&url).await.expect(200).body;
    assert_eq!(server.terminate(), 0);
    let key = url.rsplit('/').next().unwrap().trim_end_matches(".png");
    let old = key.chars().rev().collect::<String>();
    let mut database = open(&server).await;
    let aged = sqlx::query(
        "UPDATE picture SET key = unhex(?), renderer_version = renderer_version - 1
         WHERE key = unhex(?)",
    );
    let changed = aged.bind(&old).bind(key).execute(&mut database).await.unwrap();
    assert_eq!(changed.rows_affected(), 1);
    database.close().await.unwrap();
    server.restart();
    let gone = server.get(&format!("/v1/thumbnails/{old}.png")).await;
    let location = gone.header("location");
    assert_eq!(location, url, "same scene, size and material, by the current renderer");
    let problem = gone.problem(410);
    assert!(text_of(&problem["detail"]).contains(&url), "{problem}");
    assert_eq!(server.get(&location).await.expect(200).body, picture);
}
