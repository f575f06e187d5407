//! Tests of durability, locking, and recovery from failures.

use std::path::Path;
use std::sync::Arc;
use std::time::Duration;

use sqlx::{ConnectOptions, Connection};
use tempfile::TempDir;

use super::{
    execute, generation, hash, key, lineage, new_generation, new_lineage, open_directory, picture,
    scene,
};
use crate::engine::sqlite::connection;
use crate::sql::query;
use crate::{Scope, StorageError, Store};

/// Returns a copy of the files, as a killed process would leave them at this moment.
fn image(dir: &Path) -> TempDir {
    let copy = tempfile::tempdir().unwrap();
    for name in ["brood.db", "brood.db-wal"] {
        std::fs::copy(dir.join(name), copy.path().join(name)).unwrap();
    }
    copy
}

#[tokio::test]
async fn acknowledged_writes_survive_when_process_is_killed() {
    let (dir, store) = open_directory().await;
    let lineage = lineage(&store).await;
    let mut made = Vec::new();
    for n in 0..5 {
        let mut new = new_generation(lineage, &[], &n.to_string());
        new.pictures = vec![picture(&n.to_string(), &format!("{n} 0"), scene(&store).await)];
        made.push(store.create_generation(new).await.unwrap());
        let killed = image(dir.path());
        let again = Store::open(killed.path()).await.unwrap();
        assert_eq!(again.list_generations(lineage, None, 50).await.unwrap(), made);
        assert_eq!(again.picture(key(&n.to_string())).await.unwrap().size_px, 256.into());
        again.close().await.unwrap();
    }
}

#[tokio::test(flavor = "multi_thread", worker_threads = 4)]
async fn concurrent_generations_are_all_stored() {
    let (dir, store) = open_directory().await;
    let lineage = lineage(&store).await;
    let mut births = tokio::task::JoinSet::new();
    for n in 0..100 {
        let store = store.clone();
        births.spawn(async move { generation(&store, lineage, &[], &n.to_string()).await });
    }
    let mut acknowledged = births.join_all().await;
    acknowledged.sort_by_key(|one| one.index);
    let indices: Vec<_> = acknowledged.iter().map(|one| one.index).collect();
    assert_eq!(indices, (0..100).collect::<Vec<_>>());
    let killed = image(dir.path());
    let again = Store::open(killed.path()).await.unwrap();
    assert_eq!(again.list_generations(lineage, None, 200).await.unwrap(), acknowledged);
}

#[tokio::test]
async fn writes_return_busy_when_channel_is_full_and_acknowledged_ones_survive() {
    let (_dir, store) = open_directory().await;
    let mut flood = tokio::task::JoinSet::new();
    for n in 0..1000 {
        let store = store.clone();
        flood.spawn(async move {
            store.create_token(&n.to_string(), Scope::Read, hash(&n.to_string()), None).await
        });
    }
    let answers = flood.join_all().await;
    let acknowledged = answers.iter().filter(|answer| answer.is_ok()).count();
    let busy = answers.iter().filter(|answer| matches!(answer, Err(StorageError::Busy))).count();
    assert!(acknowledged >= 256 && busy > 0, "{acknowledged} done, {busy} busy");
    assert_eq!(acknowledged + busy, 1000);
    assert_eq!(store.list_tokens().await.unwrap().len(), acknowledged);
}

#[tokio::test]
async fn failed_operation_does_not_affect_its_group() {
    let (_dir, store) = open_directory().await;
    let scene = scene(&store).await;
    let good = new_lineage("good", scene, 1);
    let (first, refused, last) = tokio::join!(
        store.create_lineage(good.clone(), None),
        store.create_lineage(good.clone(), None),
        store.create_lineage(new_lineage("also", scene, 2), None),
    );
    assert!(first.is_ok() && last.is_ok(), "{first:?} {last:?}");
    assert!(matches!(refused, Err(StorageError::Conflict { .. })), "{refused:?}");
    assert_eq!(store.counts().await.unwrap().lineages, 2);
}

#[tokio::test]
async fn second_server_is_rejected_until_first_is_closed() {
    let (dir, store) = open_directory().await;
    let second = Store::open(dir.path()).await;
    assert!(matches!(second, Err(StorageError::Locked)), "{second:?}");
    let clone = store.clone();
    store.close().await.unwrap();
    let late = clone.create_token("t", Scope::Read, hash("t"), None).await;
    assert!(matches!(late, Err(StorageError::Closed)), "{late:?}");
    let late = clone.any_token().await;
    assert!(matches!(late, Err(StorageError::Closed)), "{late:?}");
    assert!(matches!(clone.close().await, Err(StorageError::Closed)));
    assert!(!dir.path().join("brood.db-wal").exists());
    Store::open(dir.path()).await.unwrap().close().await.unwrap();
}

#[tokio::test]
async fn directory_is_unlocked_when_all_clones_are_dropped() {
    let (dir, store) = open_directory().await;
    store.create_token("t", Scope::Read, hash("t"), None).await.unwrap();
    drop(store);
    let mut tries = 0;
    let store = loop {
        match Store::open(dir.path()).await {
            Ok(store) => break store,
            Err(StorageError::Locked) if tries < 500 => tries += 1,
            Err(error) => panic!("{error:?}"),
        }
        tokio::time::sleep(Duration::from_millis(10)).await;
    };
    assert!(store.any_token().await.unwrap());
}

#[tokio::test]
async fn command_opens_store_while_server_runs() {
    let (dir, server) = open_directory().await;
    let command = Store::open_shared(dir.path()).await.unwrap();
    command.create_token("t", Scope::Read, hash("t"), None).await.unwrap();
    assert!(server.any_token().await.unwrap());
    lineage(&server).await;
    assert_eq!(command.counts().await.unwrap().lineages, 1);
    command.close().await.unwrap();
    server.create_token("u", Scope::Read, hash("u"), None).await.unwrap();
    server.close().await.unwrap();

    let alone = Store::open_shared(dir.path()).await.unwrap();
    assert_eq!(alone.list_tokens().await.unwrap().len(), 2);
    assert!(matches!(Store::open(dir.path()).await, Err(StorageError::Locked)));
}

#[tokio::test]
async fn backup_can_be_opened_as_store() {
    let (_dir, store) = open_directory().await;
    let lineage = lineage(&store).await;
    let made = generation(&store, lineage, &[], "a").await;
    let copy = tempfile::tempdir().unwrap();
    let file = copy.path().join("brood.db");
    store.backup(&file).await.unwrap();
    generation(&store, lineage, &[], "b").await;
    let again = Store::open(copy.path()).await.unwrap();
    assert_eq!(again.list_generations(lineage, None, 9).await.unwrap(), [made]);
    let taken = store.backup(&file).await;
    assert!(matches!(taken, Err(StorageError::Conflict { .. })), "{taken:?}");
    let nowhere = store.backup(&copy.path().join("no/such/folder")).await;
    assert!(matches!(nowhere, Err(StorageError::Directory(_))), "{nowhere:?}");
}

#[tokio::test]
async fn writes_fail_while_disk_is_full_and_recover() {
    let (_dir, store) = open_directory().await;
    let lineage = lineage(&store).await;
    let made = generation(&store, lineage, &[], "a").await;
    execute(&store, "PRAGMA max_page_count = 1").await;
    let mut big = new_generation(lineage, &[], "b");
    Arc::make_mut(&mut big.individuals[0].genome).bytes = noise(1 << 20);
    let refused = store.create_generation(big.clone()).await;
    assert!(matches!(refused, Err(StorageError::Full)), "{refused:?}");
    assert_eq!(store.list_generations(lineage, None, 9).await.unwrap(), [made]);
    assert!(!store.is_poisoned());
    execute(&store, "PRAGMA max_page_count = 1000000").await;
    assert_eq!(store.create_generation(big).await.unwrap().index, 1);
}

/// Bytes that cannot be packed.
fn noise(length: usize) -> Vec<u8> {
    let mut bytes = vec![0; length];
    blake3::Hasher::new().finalize_xof().fill(&mut bytes);
    bytes
}

#[tokio::test]
async fn store_rejects_writes_when_disk_has_failed() {
    let (dir, store) = open_directory().await;
    let lineage = lineage(&store).await;
    let failed: Result<(), _> = store
        .write(|_| {
            let error = std::io::Error::other("fsync");
            Box::pin(async move { Err(StorageError::Database(sqlx::Error::Io(error))) })
        })
        .await;
    assert!(matches!(failed, Err(StorageError::Poisoned)), "{failed:?}");
    assert!(store.is_poisoned());
    let late = store.create_generation(new_generation(lineage, &[], "a")).await;
    assert!(matches!(late, Err(StorageError::Poisoned)), "{late:?}");
    assert_eq!(store.lineage(lineage).await.unwrap().generations, 0);
    assert!(matches!(store.close().await, Err(StorageError::Poisoned)));
    let killed = image(dir.path());
    let again = Store::open(killed.path()).await.unwrap();
    assert_eq!(again.lineage(lineage).await.unwrap().id, lineage);
}

#[tokio::test]
async fn store_rejects_writes_when_its_files_are_removed_or_replaced() {
    for name in ["brood.db", "brood.lock"] {
        for is_replaced in [false, true] {
            let (dir, store) = open_directory().await;
            let lineage = lineage(&store).await;
            let file = dir.path().join(name);
            if is_replaced {
                std::fs::copy(&file, dir.path().join("copy")).unwrap();
            }
            std::fs::remove_file(&file).unwrap();
            if is_replaced {
                std::fs::rename(dir.path().join("copy"), &file).unwrap();
            }
            let lost = store.create_generation(new_generation(lineage, &[], "a")).await;
            assert!(matches!(lost, Err(StorageError::Poisoned)), "{name}: {lost:?}");
            assert!(store.is_poisoned());
            assert!(matches!(store.close().await, Err(StorageError::Gone)), "{name}");
        }
    }
}

#[tokio::test]
async fn empty_database_is_refused() {
    let dir = tempfile::tempdir().unwrap();
    std::fs::write(dir.path().join("brood.db"), []).unwrap();
    let error = Store::open(dir.path()).await.unwrap_err().to_string();
    assert!(error.contains("brood.db is empty"), "{error}");
}

#[tokio::test]
async fn store_rejects_writes_when_transaction_is_lost() {
    let (_dir, store) = open_directory().await;
    let lost = store
        .write(|conn| {
            Box::pin(async move {
                query("ROLLBACK").execute(conn).await?;
                Ok(())
            })
        })
        .await;
    assert!(matches!(lost, Err(StorageError::Poisoned)), "{lost:?}");
}

#[tokio::test]
async fn store_rejects_writes_when_operation_panics() {
    let (_dir, store) = open_directory().await;
    let bug: Result<(), _> = store.write(|_| Box::pin(async { panic!("a bug") })).await;
    assert!(matches!(bug, Err(StorageError::Poisoned)), "{bug:?}");
    let late = store.create_token("t", Scope::Read, hash("t"), None).await;
    assert!(matches!(late, Err(StorageError::Poisoned)), "{late:?}");
}

/// Writes something that may be lost with the power.
async fn relaxed(store: &Store) {
    let change = store.write_relaxed(|conn| {
        Box::pin(async move {
            query("UPDATE lineage SET notes = notes").execute(conn).await?;
            Ok(())
        })
    });
    change.await.unwrap();
}

#[tokio::test]
async fn durable_writes_are_flushed_after_relaxed_commits() {
    let (_dir, store) = open_directory().await;
    relaxed(&store).await;
    let level = |store: Store| async move {
        store
            .write(|conn| {
                Box::pin(async move { query("PRAGMA synchronous").fetch_value::<i64>(conn).await })
            })
            .await
            .unwrap()
    };
    assert_eq!(level(store.clone()).await, 2);
    relaxed(&store).await;
    assert_eq!(level(store.clone()).await, 2);
}

#[tokio::test]
async fn log_size_is_bounded() {
    let (dir, store) = open_directory().await;
    let lineage = lineage(&store).await;
    for n in 0..300 {
        let mut new = new_generation(lineage, &[], &n.to_string());
        Arc::make_mut(&mut new.individuals[0].genome).bytes.extend([7; 200_000]);
        store.create_generation(new).await.unwrap();
    }
    let log_bytes = std::fs::metadata(dir.path().join("brood.db-wal")).unwrap().len();
    assert!(log_bytes < 30_000_000, "60 MB were written, {log_bytes} are in the log");
}

#[tokio::test]
async fn readers_cannot_write() {
    let (_dir, store) = open_directory().await;
    let mut conn = store.reader().await.unwrap();
    let refused = query("DELETE FROM token").execute(&mut conn).await;
    assert!(refused.is_err(), "{refused:?}");
}

#[tokio::test]
async fn damage_is_reported_when_last_shutdown_was_unclean() {
    let (dir, store) = open_directory().await;
    let killed = image(dir.path());
    drop(store);
    // Only other programs can write such a row: SQLite enforces foreign keys here.
    let options = connection::writing(&killed.path().join("brood.db"), false).foreign_keys(false);
    let mut conn = options.connect().await.unwrap();
    sqlx::query(
        "INSERT INTO individual (id, lineage_id, generation_id, slot, genome_hash, operator,
                                 attempts, twin)
         VALUES (randomblob(16), randomblob(16), randomblob(16), 0, randomblob(32), 'x', 1, 0)",
    )
    .execute(&mut conn)
    .await
    .unwrap();
    let damaged = image(killed.path());
    conn.close().await.unwrap();
    let opened = Store::open(damaged.path()).await;
    assert!(matches!(opened, Err(StorageError::Corrupt(_))), "{opened:?}");
}

#[tokio::test]
async fn file_is_rejected_when_foreign_or_newer() {
    let dir = tempfile::tempdir().unwrap();
    std::fs::write(
        dir.path().join("brood.db"),
        "This is a letter, and no database at all. ".repeat(200),
    )
    .unwrap();
    let opened = Store::open(dir.path()).await;
    assert!(matches!(opened, Err(StorageError::Corrupt(_))), "{opened:?}");

    let (dir, store) = open_directory().await;
    store.close().await.unwrap();
    let options = connection::writing(&dir.path().join("brood.db"), false);
    let mut conn = options.connect().await.unwrap();
    let sql =
        "INSERT INTO _sqlx_migrations (version, description, success, checksum, execution_time)
               VALUES (9999, 'from the future', 1, x'00', 0)";
    sqlx::query(sql).execute(&mut conn).await.unwrap();
    conn.close().await.unwrap();
    let opened = Store::open(dir.path()).await;
    assert!(matches!(opened, Err(StorageError::Unsupported(_))), "{opened:?}");
}

#[cfg(unix)]
#[tokio::test]
async fn files_are_closed_to_other_users_whatever_the_directory_is() {
    use std::os::unix::fs::PermissionsExt;

    let dir = tempfile::tempdir().unwrap();
    std::fs::set_permissions(dir.path(), PermissionsExt::from_mode(0o755)).unwrap();
    let store = Store::open(dir.path()).await.unwrap();
    lineage(&store).await;
    store.backup(&dir.path().join("copy.db")).await.unwrap();
    for name in ["brood.db", "brood.db-wal", "brood.db-shm", "brood.lock", "copy.db"] {
        let mode = std::fs::metadata(dir.path().join(name)).unwrap().permissions().mode();
        assert_eq!(mode & 0o777, 0o600, "{name}");
    }
}

#[tokio::test]
async fn database_whose_creation_was_cut_is_created_again() {
    let (dir, store) = open_directory().await;
    lineage(&store).await;
    let log = std::fs::read(dir.path().join("brood.db-wal")).unwrap();
    assert!(!log.is_empty());
    drop(store);
    for rest in ["brood.db.new", "brood.db.new-wal", "brood.db.new-shm", "brood.db-wal"] {
        let dir = tempfile::tempdir().unwrap();
        // Neither a part of a new database nor the log of a deleted one is read.
        std::fs::write(dir.path().join(rest), &log).unwrap();
        let store = Store::open(dir.path()).await.unwrap();
        assert_eq!(store.counts().await.unwrap().lineages, 0, "{rest}");
        lineage(&store).await;
        store.close().await.unwrap();
        assert!(!dir.path().join("brood.db.new").exists());
        let store = Store::open(dir.path()).await.unwrap();
        assert_eq!(store.counts().await.unwrap().lineages, 1, "{rest}");
    }
}

#[cfg(unix)]
#[tokio::test]
async fn link_to_a_missing_database_is_refused_and_kept() {
    let (dir, other) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    let link = dir.path().join("brood.db");
    std::os::unix::fs::symlink(other.path().join("brood.db"), &link).unwrap();
    let error = Store::open(dir.path()).await.unwrap_err().to_string();
    assert!(error.contains("brood.db is a link to a missing file"), "{error}");
    assert!(link.is_symlink());
}
