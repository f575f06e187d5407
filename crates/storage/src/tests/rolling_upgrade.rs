//! Tests of servers of two schemas on one PostgreSQL database. They do nothing without
//! `BROOD_TEST_DATABASE`.

use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

use sqlx::migrate::{Migration, MigrationType, Migrator};
use sqlx::{Connection as _, SqlSafeStr as _};

use super::*;
use crate::engine::postgres::{MIGRATIONS, Postgres, Usage};

/// Migration after which servers of this build run.
const COMPATIBLE: &str = "-- Servers of schema 2 or later run on these tables.
    ALTER TABLE lineage ADD COLUMN colour TEXT;
    ALTER TABLE genome ADD COLUMN colour BIGINT NOT NULL DEFAULT 0;
    ALTER TABLE search ADD COLUMN colour BIGINT;
    CREATE TABLE shade (id BIGINT NOT NULL PRIMARY KEY)";
/// Migration that excludes them.
const INCOMPATIBLE: &str = "CREATE TABLE tone (id BIGINT NOT NULL PRIMARY KEY)";
/// Index that is made while servers run.
const INDEX: &str = "-- no-transaction
-- Servers of schema 2 or later run on these tables.
CREATE INDEX CONCURRENTLY IF NOT EXISTS lineage_name ON lineage (name)";

/// Returns the migrations of a build with further ones than this build.
fn with(further: &[&'static str]) -> &'static Migrator {
    let further = (101_i64..).zip(further).map(|(version, sql)| {
        let no_tx = sql.starts_with("-- no-transaction");
        let sql = (*sql).into_sql_str();
        Migration::new(version, "further".into(), MigrationType::Simple, sql, no_tx)
    });
    let steps = MIGRATIONS.iter().cloned().chain(further);
    Box::leak(Box::new(Migrator::with_migrations(steps.collect())))
}

async fn start(
    address: &DatabaseAddress,
    further: &[&'static str],
) -> Result<Postgres, StorageError> {
    Postgres::connect_with(address, Usage::Server, with(further)).await
}

/// Asserts that a start was refused with these words in one line.
#[track_caller]
fn assert_refused<T>(started: Result<T, StorageError>, words: &str) {
    let Err(StorageError::Unsupported(reason)) = started else { panic!("must be refused") };
    assert!(reason.contains(words) && !reason.contains('\n'), "{reason}");
}

/// Gives birth until `end` is set. Returns the number of births and the longest time of one.
async fn bear(store: Store, lineage: LineageId, end: Arc<AtomicBool>) -> (u64, Duration) {
    let (mut births, mut longest) = (0, Duration::ZERO);
    while !end.load(Ordering::Relaxed) {
        let start = Instant::now();
        generation(&store, lineage, &[], &format!("born {births}")).await;
        longest = longest.max(start.elapsed());
        births += 1;
    }
    (births, longest)
}

#[tokio::test(flavor = "multi_thread")]
async fn tables_are_changed_while_a_server_of_the_earlier_schema_writes() {
    let Place::Schema(address, data) = Place::new().await else { return };
    let older = Store::connect(&address, data.path()).await.unwrap();
    let lineage = lineage(&older).await;
    let end = Arc::<AtomicBool>::default();
    let births = tokio::spawn(bear(older.clone(), lineage, end.clone()));
    let newer = start(&address, &[COMPATIBLE, INDEX]).await.unwrap();
    tokio::time::sleep(Duration::from_millis(200)).await;
    end.store(true, Ordering::Relaxed);
    let (born, _) = births.await.unwrap();
    assert!(born > 0);

    // A server of the earlier schema starts on the new tables, too, and so does a command.
    older.close().await.unwrap();
    let again = Store::connect(&address, data.path()).await.unwrap();
    generation(&again, lineage, &[], "after").await;
    assert_eq!(again.lineage(lineage).await.unwrap().generations, born + 1);
    Store::connect_shared(&address).await.unwrap().close().await.unwrap();
    newer.close().await.unwrap();
    again.close().await.unwrap();
    // A copy would leave columns out.
    let copy = Postgres::connect(&address, Usage::Alone).await;
    assert_refused(copy, "a newer version of brood");
}

#[tokio::test(flavor = "multi_thread")]
async fn servers_that_a_change_excludes_are_waited_for() {
    let Place::Schema(address, data) = Place::new().await else { return };
    let older = Store::connect(&address, data.path()).await.unwrap();
    let lineage = lineage(&older).await;
    let (late, command) = tokio::join!(start(&address, &[INCOMPATIBLE]), async {
        Postgres::connect_with(&address, Usage::Command, with(&[COMPATIBLE])).await
    });
    assert_refused(late, "servers of an earlier version of brood use the database");
    assert_refused(command, "servers of an earlier version of brood use the database");
    generation(&older, lineage, &[], "beside").await;

    let soon = async {
        tokio::time::sleep(Duration::from_secs(1)).await;
        generation(&older, lineage, &[], "still").await;
        older.clone().close().await.unwrap();
    };
    let (newer, ()) = tokio::join!(start(&address, &[INCOMPATIBLE]), soon);
    let newer = newer.unwrap();
    let excluded = Store::connect(&address, data.path()).await;
    assert_refused(excluded, "a newer version of brood has changed the tables");
    assert_refused(Store::connect_shared(&address).await, "a newer version of brood");
    newer.close().await.unwrap();
}

#[tokio::test]
async fn tables_of_an_unknown_version_are_refused() {
    let Place::Schema(address, data) = Place::new().await else { return };
    let store = Store::connect(&address, data.path()).await.unwrap();
    let unknown = "INSERT INTO _sqlx_migrations (version, description, success, checksum, \
                   execution_time) VALUES (9001, 'unknown', TRUE, '', 0)";
    execute(&store, unknown).await;
    store.close().await.unwrap();
    let refused = Store::connect(&address, data.path()).await;
    assert_refused(refused, "written by another version of brood");
}

#[tokio::test(flavor = "multi_thread")]
async fn births_do_not_wait_for_a_change_that_waits_for_a_table() {
    let Place::Schema(address, data) = Place::new().await else { return };
    let older = Store::connect(&address, data.path()).await.unwrap();
    let lineage = lineage(&older).await;
    let mut reader = sqlx::PgConnection::connect(address.as_str()).await.unwrap();
    let read = "BEGIN; LOCK TABLE lineage IN ACCESS SHARE MODE";
    sqlx::raw_sql(read).execute(&mut reader).await.unwrap();
    let end = Arc::<AtomicBool>::default();
    let births = tokio::spawn(bear(older, lineage, end.clone()));
    let slow = async {
        tokio::time::sleep(Duration::from_secs(4)).await;
        sqlx::raw_sql("COMMIT").execute(&mut reader).await.unwrap();
        Instant::now()
    };
    let started = async { (start(&address, &[COMPATIBLE]).await.unwrap(), Instant::now()) };
    let ((newer, changed), released) = tokio::join!(started, slow);
    end.store(true, Ordering::Relaxed);
    let (_, longest) = births.await.unwrap();
    assert!(changed > released);
    assert!(longest < Duration::from_secs(3), "{longest:?}");
    newer.close().await.unwrap();
}

#[tokio::test]
async fn index_that_was_not_finished_is_made_again() {
    let Place::Schema(address, data) = Place::new().await else { return };
    let store = Store::connect(&address, data.path()).await.unwrap();
    for sql in [
        "CREATE INDEX lineage_name ON lineage (name)",
        "UPDATE pg_index SET indisvalid = FALSE
         WHERE indexrelid = CAST('lineage_name' AS regclass)",
    ] {
        execute(&store, sql).await;
    }
    let newer = start(&address, &[INDEX]).await.unwrap();
    let mut conn = store.reader().await.unwrap();
    let valid = "SELECT count(*) FROM pg_index
        WHERE indexrelid = CAST('lineage_name' AS regclass) AND indisvalid";
    let valid: u64 = query(valid).fetch_value(&mut conn).await.unwrap();
    assert_eq!(valid, 1);
    newer.close().await.unwrap();
}

/// Ends the connection that has the lock of a server. Returns false if there is none.
async fn lose_lock(store: &Store) -> bool {
    let ended = store.write(move |conn| {
        Box::pin(async move {
            let sql = "SELECT pg_terminate_backend(pid) FROM pg_locks
                WHERE locktype = 'advisory' AND granted AND pid <> pg_backend_pid()
                    AND CAST(objid AS BIGINT)
                        = (CAST(hashtext(current_schema()) AS BIGINT) & 4294967295)";
            query(sql).execute(conn).await
        })
    });
    ended.await.unwrap() > 0
}

#[tokio::test]
async fn lock_that_was_lost_is_taken_again() {
    let Place::Schema(address, data) = Place::new().await else { return };
    let store = Store::connect(&address, data.path()).await.unwrap();
    for _ in 0..2 {
        assert!(lose_lock(&store).await);
        tokio::time::sleep(Duration::from_secs(4)).await;
    }
    let late = start(&address, &[INCOMPATIBLE]).await;
    assert_refused(late, "servers of an earlier version of brood use the database");
    assert!(!store.is_poisoned());
    store.close().await.unwrap();
}

#[tokio::test]
async fn server_whose_tables_were_changed_without_its_lock_stops() {
    let Place::Schema(address, data) = Place::new().await else { return };
    let store = Store::connect(&address, data.path()).await.unwrap();
    for sql in [
        "INSERT INTO _brood_step (version, oldest) VALUES (9001, 9001)",
        "INSERT INTO _sqlx_migrations (version, description, success, checksum, execution_time)
         VALUES (9001, 'later', TRUE, '', 0)",
    ] {
        execute(&store, sql).await;
    }
    assert!(lose_lock(&store).await);
    for _ in 0..200 {
        if store.is_poisoned() {
            break;
        }
        tokio::time::sleep(Duration::from_millis(50)).await;
    }
    let words = "another version of brood has changed the tables";
    assert_refused(store.counts().await, words);
    assert_refused(store.close().await, words);
}
