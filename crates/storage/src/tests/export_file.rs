//! Tests of exports' files in PostgreSQL. They do nothing without `BROOD_TEST_DATABASE`.

use std::collections::HashMap;

use brood_protocol::JobStatus;

use super::*;
use crate::export_file::PART_BYTES;
use crate::{ClaimedExport, NewExport, NewExportFile, StoredExport, StoredExportFile};

/// Time to live of the leases.
const LEASE: Duration = Duration::from_secs(20);

async fn open_postgres() -> Option<(Place, Store)> {
    let (place, store) = open().await;
    store.is_shared().then_some((place, store))
}

/// Starts an export with this number of files, and leases it.
async fn leased(store: &Store, files: u32) -> ClaimedExport {
    let file = |number| NewExportFile { number, genome: genome("a"), format: "brood".to_owned() };
    let new = NewExport {
        id: JobId::fresh(),
        energy_limit: None,
        files: (0..files).map(file).collect(),
        plan: "{}".to_owned(),
        created_ms: 1,
        idempotency: None,
    };
    store.create_export(new, 9).await.unwrap();
    claim(store).await
}

async fn claim(store: &Store) -> ClaimedExport {
    store.claim_export("worker", LEASE, 2).await.unwrap().unwrap()
}

/// Records a file of an export, and stores it.
async fn put(
    store: &Store,
    export: &ClaimedExport,
    number: u32,
    file: Vec<u8>,
) -> Result<StoredExport, StorageError> {
    let record = StoredExportFile { number, bytes: file.len() as u64, note: None };
    store.record_export_file((export.id, export.epoch), record, Some(file), (LEASE, 3)).await
}

/// Number of parts of all files.
async fn parts(store: &Store) -> u64 {
    let mut conn = store.reader().await.unwrap();
    query("SELECT count(*) FROM export_blob").fetch_value(&mut conn).await.unwrap()
}

#[tokio::test]
async fn file_is_read_as_it_was_stored_last() {
    let Some((_place, store)) = open_postgres().await else { return };
    let export = leased(&store, 3).await;
    let size = 2 * PART_BYTES + 5;
    let large: Vec<u8> = (0..size).map(|n| (n / 1000) as u8).collect();
    put(&store, &export, 0, vec![7; 3 * PART_BYTES + 1]).await.unwrap();
    assert_eq!(parts(&store).await, 4);
    put(&store, &export, 0, large.clone()).await.unwrap();
    put(&store, &export, 1, Vec::new()).await.unwrap();
    assert_eq!(parts(&store).await, 3);
    let running = store.export(export.id).await.unwrap();
    assert_eq!((running.state, running.bytes), (JobStatus::Running, size as u64));
    let ended = put(&store, &export, 2, vec![1, 2]).await.unwrap();
    assert_eq!(ended.state, JobStatus::Succeeded);

    let sizes = store.export_file_sizes(export.id).await.unwrap();
    assert_eq!(sizes, HashMap::from([(0, size as u64), (2, 2)]));
    let read = async |number, size| store.read_export_file((export.id, number), size).await;
    assert!(read(0, size as u64).await.unwrap() == large);
    assert_eq!(read(1, 0).await.unwrap(), Vec::<u8>::new());
    assert_eq!(read(2, 2).await.unwrap(), [1, 2]);
    for (number, size) in [(2, 3), (9, 1)] {
        assert!(matches!(read(number, size).await, Err(StorageError::NotFound)));
    }
    store.remove_unused_export_files().await.unwrap();
    assert_eq!(parts(&store).await, 4);
}

#[tokio::test]
async fn files_are_removed_with_their_export_and_others_kept() {
    let Some((_place, store)) = open_postgres().await else { return };
    let kept = leased(&store, 2).await;
    put(&store, &kept, 0, vec![1; PART_BYTES + 1]).await.unwrap();
    let [cancelled, failed, deleted] =
        [leased(&store, 2).await, leased(&store, 2).await, leased(&store, 1).await];
    for export in [&cancelled, &failed, &deleted] {
        put(&store, export, 0, vec![2; PART_BYTES + 1]).await.unwrap();
    }
    store.remove_unused_export_files().await.unwrap();
    assert_eq!(parts(&store).await, 8);

    store.cancel_export(cancelled.id, None, 4).await.unwrap().unwrap();
    let lease = (failed.id, failed.epoch);
    store.fail_export(lease, "too large".to_owned(), 4).await.unwrap();
    store.delete_export(deleted.id).await.unwrap();
    for export in [&cancelled, &failed, &deleted] {
        let late = put(&store, export, 0, vec![3]).await;
        assert!(matches!(late, Err(StorageError::Conflict { .. })), "{late:?}");
    }
    let (one, other) =
        tokio::join!(store.remove_unused_export_files(), store.remove_unused_export_files());
    one.unwrap();
    other.unwrap();
    assert_eq!(parts(&store).await, 2);
    let size = PART_BYTES as u64 + 1;
    let sizes = store.export_file_sizes(kept.id).await.unwrap();
    assert_eq!(sizes, HashMap::from([(0, size)]));
}

#[tokio::test]
async fn recorded_files_that_were_not_copied_are_made_again() {
    let Some((_place, store)) = open_postgres().await else { return };
    let export = leased(&store, 2).await;
    put(&store, &export, 0, vec![1]).await.unwrap();
    // As `migrate` leaves it: the record has a size, but there is no file.
    let record = StoredExportFile { number: 1, bytes: 9, note: None };
    let lease = (export.id, export.epoch);
    let ended = store.record_export_file(lease, record, None, (LEASE, 3)).await.unwrap();
    assert_eq!(ended.state, JobStatus::Succeeded);
    let sizes = store.export_file_sizes(export.id).await.unwrap();
    assert_eq!(sizes, HashMap::from([(0, 1)]));

    store.forget_export_files((export.id, ended.epoch - 1), vec![1]).await.unwrap();
    assert_eq!(store.export(export.id).await.unwrap(), ended);
    store.forget_export_files((export.id, ended.epoch), vec![1]).await.unwrap();
    let again = claim(&store).await;
    let missing: Vec<_> = again.missing.iter().map(|file| file.number).collect();
    assert_eq!((again.id, missing), (export.id, vec![1]));
    let ended = put(&store, &again, 1, vec![2; 9]).await.unwrap();
    assert_eq!((ended.state, ended.bytes), (JobStatus::Succeeded, 10));
    assert_eq!(store.read_export_file((export.id, 1), 9).await.unwrap(), [2; 9]);
}
