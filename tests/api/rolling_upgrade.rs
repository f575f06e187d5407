//! Servers of this version on tables that a later version has changed. The tests do nothing on
//! SQLite.

use brood_tests::{ServerOptions, TestLineage, TestServer, brood};
use sqlx::{Connection, PgConnection};
use tempfile::TempDir;

/// Change of a later version after which servers of this one run.
const COMPATIBLE: &str = "BEGIN;
    SET LOCAL lock_timeout = '5s';
    ALTER TABLE lineage ADD COLUMN colour TEXT;
    ALTER TABLE generation ADD COLUMN colour BIGINT NOT NULL DEFAULT 0;
    ALTER TABLE individual ADD COLUMN colour BIGINT;
    ALTER TABLE idempotency ADD COLUMN colour BIGINT;
    CREATE TABLE shade (
        lineage_id BYTEA NOT NULL PRIMARY KEY REFERENCES lineage (id) ON DELETE CASCADE
    );
    INSERT INTO _brood_step (version, oldest) VALUES (9001, 1);
    INSERT INTO _sqlx_migrations (version, description, success, checksum, execution_time)
        VALUES (9001, 'colours', TRUE, '', 0);
    COMMIT";
/// Change that excludes servers of this version.
const INCOMPATIBLE: &str = "INSERT INTO _brood_step (version, oldest) VALUES (9002, 9002);
    INSERT INTO _sqlx_migrations (version, description, success, checksum, execution_time)
        VALUES (9002, 'tones', TRUE, '', 0)";

#[tokio::test(flavor = "multi_thread")]
async fn servers_run_and_start_on_tables_that_a_later_version_has_changed() {
    let mut first = TestServer::start();
    let Some(address) = first.database() else { return };
    let mut database = PgConnection::connect(&address).await.unwrap();
    {
        let lineage = TestLineage::new(&first).await;
        // All statements are prepared before the change.
        lineage.random(1).await;
        let births = async {
            for seed in 2..30 {
                lineage.random(seed).await;
            }
        };
        let change = async {
            sqlx::raw_sql(COMPATIBLE).execute(&mut database).await.unwrap();
        };
        tokio::join!(births, change);
        let second = first.beside(ServerOptions::default()).unwrap();
        let path = lineage.path("/generations");
        let body = serde_json::json!({"parents": [], "count": 4});
        second.post(&path, &body).await.expect(201);
        lineage.random(30).await;
        let listed = second.get(&format!("{path}?limit=100")).await.expect(200).json();
        assert_eq!(listed["items"].as_array().unwrap().len(), 31);
        second.delete(&lineage.path("?purge=true")).await.expect(204);
    }
    assert_eq!(first.terminate(), 0);
    first.restart();

    sqlx::raw_sql(INCOMPATIBLE).execute(&mut database).await.unwrap();
    let data = TempDir::new().unwrap();
    let folder = data.path().to_string_lossy().into_owned();
    let arguments = ["serve", "--listen", "127.0.0.1:0", "--workers", "0", "--data", &folder];
    let refused = brood(arguments.into_iter().chain(["--database", address.as_str()]));
    assert_ne!(refused.code, 0);
    let errors: Vec<_> =
        refused.stderr.lines().filter(|line| line.contains("a newer version of brood")).collect();
    assert_eq!(errors.len(), 1, "{}", refused.stderr);
    assert!(errors[0].contains("to schema 9002, which servers before schema 9002 cannot use"));
    // The lock of a running server keeps such a change away.
    TestLineage::new(&first).await.random(1).await;
}
