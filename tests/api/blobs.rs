//! Large files in an object store. The tests do nothing on SQLite, and without the S3 server that
//! `BROOD_TEST_BLOBS` and the variables of AWS name.

use brood_tests::{ServerOptions, TestServer, binary, glossy_csv, text_of};
use serde_json::json;
use sqlx::{Connection, PgConnection};
use uuid::Uuid;

/// Options of a server with an empty folder in the object store.
fn options() -> Option<ServerOptions> {
    let bucket = std::env::var("BROOD_TEST_BLOBS").ok()?;
    std::env::var("BROOD_TEST_DATABASE").ok()?;
    let arguments = vec!["--blobs".to_owned(), format!("{bucket}/{}", Uuid::now_v7())];
    Some(ServerOptions { arguments, ..ServerOptions::default() })
}

#[tokio::test(flavor = "multi_thread")]
async fn search_runs_on_a_large_target_at_another_server() {
    let Some(options) = options() else { return };
    let first = TestServer::start_with(ServerOptions { workers: 0, ..options.clone() });
    let spec = json!({"kind": "samples", "name": "large"});
    let file = glossy_csv(12_000, 1);
    assert!(file.len() > 1 << 20, "{}", file.len());
    let target = first.post_target(&spec, &file).await.expect(201).json();
    let mut database = PgConnection::connect(&first.database().unwrap()).await.unwrap();
    let objects = "SELECT count(*) FROM target_file WHERE object IS NOT NULL AND bytes IS NULL";
    let count: i64 = sqlx::query_scalar(objects).fetch_one(&mut database).await.unwrap();
    assert_eq!(count, 1);

    let second = first.beside(options.clone()).unwrap();
    let body = json!({
        "kind": "fit", "target": target["id"], "strategy": "lobes", "generations": 3, "threads": 1,
    });
    let id = text_of(&first.post("/v1/jobs", &body).await.expect(202).json()["id"]);
    let is_over = |job: &serde_json::Value| {
        ["succeeded", "failed"].iter().any(|state| job["state"] == *state)
    };
    let job = second.job_once(&id, is_over).await;
    assert_eq!(job["state"], "succeeded", "{job}");

    let check = std::process::Command::new(binary())
        .args(["check", "--data"])
        .arg(first.data())
        .args(&options.arguments)
        .env("BROOD_DATABASE", first.database().unwrap())
        .output()
        .unwrap();
    let text = String::from_utf8_lossy(&check.stdout);
    assert!(check.status.success() && text.contains("read 1 files in the object store"), "{text}");

    first.delete(&format!("/v1/targets/{}", text_of(&target["id"]))).await.expect(204);
    let count: i64 = sqlx::query_scalar(objects).fetch_one(&mut database).await.unwrap();
    assert_eq!(count, 0);
}

#[tokio::test(flavor = "multi_thread")]
async fn server_without_the_store_of_the_database_is_refused() {
    let Some(options) = options() else { return };
    let first = TestServer::start_with(ServerOptions { workers: 0, ..options.clone() });
    let spec = json!({"kind": "samples", "name": "large"});
    first.post_target(&spec, glossy_csv(12_000, 1)).await.expect(201);
    let data = tempfile::tempdir().unwrap();
    let refused = std::process::Command::new(binary())
        .args(["serve", "--listen", "127.0.0.1:0", "--workers", "0", "--data"])
        .arg(data.path())
        .env("BROOD_DATABASE", first.database().unwrap())
        .output()
        .unwrap();
    let text = String::from_utf8_lossy(&refused.stderr);
    let expected = format!("start this with --blobs {}", options.arguments[1]);
    assert!(!refused.status.success() && text.contains(&expected), "{text}");
}

#[tokio::test(flavor = "multi_thread")]
async fn upload_is_answered_with_503_while_the_store_is_gone() {
    let Some(options) = options() else { return };
    let mut server = TestServer::start_with(ServerOptions { workers: 0, ..options.clone() });
    assert_eq!(server.terminate(), 0);
    // No server has this port.
    let gone = ("AWS_ENDPOINT", "http://127.0.0.1:9".into());
    server.restart_with(ServerOptions { environment: vec![gone], workers: 0, ..options.clone() });
    let spec = json!({"kind": "samples", "name": "large"});
    let refused = server.post_target(&spec, glossy_csv(12_000, 1)).await.expect(503);
    assert!(refused.headers.contains_key("retry-after"));
    server.post_target(&spec, glossy_csv(600, 1)).await.expect(201);
    assert!(server.log().contains("the object store cannot be used"));
    assert_eq!(server.terminate(), 0);
    server.restart_with(ServerOptions { workers: 0, ..options });
    server.post_target(&spec, glossy_csv(12_000, 1)).await.expect(201);
}
