//! Tests of exports' leases and files, against a real store.

use brood_genome::preset::neutral;
use brood_storage::{NewExport, NewExportFile, NewGenome};
use tempfile::TempDir;

use super::*;
use crate::config::ServerConfig;
use crate::dispatch::{claim_lease, end_leases};
use crate::server::Server;
use crate::state::App;

/// Returns an app, and exports whose files may have `most_bytes` together.
async fn exports(most_bytes: u64) -> (TempDir, App, Arc<Exports>) {
    let dir = tempfile::tempdir().unwrap();
    let address = "127.0.0.1:0".parse().unwrap();
    let server = Server::bind(ServerConfig::new(address, dir.path().to_owned())).await.unwrap();
    let app = server.app();
    let exports = Arc::new(Exports {
        store: app.store.clone(),
        jobs: Jobs::new(&app.tasks, &app.stopping, None),
        lane: Lane::default(),
        library: app.library.clone(),
        folder: app.exports.folder.clone(),
        events: app.events.clone(),
        space: Mutex::new(()),
        most_bytes,
    });
    (dir, app, exports)
}

/// Queues an export of a genome in this number of files.
async fn queued(app: &App, files: u32) -> JobId {
    let genome = neutral();
    let stored = NewGenome {
        hash: genome.hash(),
        bytes: genome.canonical_bytes(),
        program_hash: [0; 32],
        live_instructions: 0,
        layers: Vec::new(),
    };
    app.store.put_genome(stored).await.unwrap();
    let file = |number| NewExportFile { number, genome: genome.hash(), format: "brood".to_owned() };
    let new = NewExport {
        id: JobId::fresh(),
        energy_limit: None,
        files: (0..files).map(file).collect(),
        plan: "{}".to_owned(),
        created_ms: now_ms(),
        idempotency: None,
    };
    let id = new.id;
    app.store.create_export(new, 100).await.unwrap();
    id
}

async fn claim(exports: &Arc<Exports>) -> ExportGrant {
    claim_lease(exports, "a", (), 0).await.unwrap().unwrap()
}

fn made(ticket: ExportTicket, number: u32, bytes: usize) -> ExportReport {
    let update = ExportUpdate::Made { number, bytes: vec![1; bytes], note: None };
    ExportReport { ticket, update }
}

#[tokio::test(flavor = "multi_thread")]
async fn oldest_ended_export_gives_way_and_one_that_does_not_fit_fails() {
    let (_dir, app, exports) = exports(100).await;
    let mut ids = Vec::new();
    for _ in 0..3 {
        ids.push(queued(&app, 1).await);
        let ticket = claim(&exports).await.ticket;
        assert_eq!(exports.report(made(ticket, 0, 40)).await.unwrap(), Directive::Stop);
    }
    let kept: Vec<_> = app.store.exports().await.unwrap().iter().map(|one| one.id).collect();
    assert_eq!(kept, ids[1..], "two of 40 bytes fit into 100");
    assert!(!exports.folder.has(ids[0], 0, 40) && exports.folder.has(ids[2], 0, 40));

    let large = queued(&app, 2).await;
    let ticket = claim(&exports).await.ticket;
    assert_eq!(exports.report(made(ticket, 0, 90)).await.unwrap(), Directive::Continue);
    assert_eq!(exports.report(made(ticket, 1, 20)).await.unwrap(), Directive::Stop);
    let export = app.store.export(large).await.unwrap();
    assert_eq!((export.state, export.bytes), (JobStatus::Failed, 0));
    assert!(export.reason.unwrap().contains("together"));
    assert!(!exports.folder.has(large, 0, 90));
    assert_eq!(exports.report(made(ticket, 1, 1)).await.unwrap_err().status(), 409);
}

#[tokio::test(flavor = "multi_thread")]
async fn next_lease_has_the_missing_files_and_a_third_death_fails_the_export() {
    let (_dir, app, exports) = exports(1000).await;
    let id = queued(&app, 3).await;
    let first = claim(&exports).await;
    assert_eq!((first.files.len(), first.genomes.len()), (3, 1));
    exports.report(made(first.ticket, 1, 5)).await.unwrap();
    for _ in 0..2 {
        end_leases(&*exports, LostLeases::OfWorker("a".to_owned())).await;
        let grant = claim(&exports).await;
        let numbers: Vec<_> = grant.files.iter().map(|file| file.number).collect();
        assert_eq!(numbers, [0, 2]);
        assert_eq!(exports.report(made(first.ticket, 0, 5)).await.unwrap_err().status(), 409);
    }
    assert!(exports.folder.has(id, 1, 5));
    end_leases(&*exports, LostLeases::OfWorker("a".to_owned())).await;
    let export = app.store.export(id).await.unwrap();
    assert_eq!((export.state, export.reason.as_deref()), (JobStatus::Failed, Some("worker_lost")));
    assert!(!exports.folder.has(id, 1, 5));
}

#[tokio::test(flavor = "multi_thread")]
async fn lost_file_is_made_again_and_meanwhile_the_others_are_kept() {
    let (_dir, app, exports) = exports(1000).await;
    let id = queued(&app, 2).await;
    let ticket = claim(&exports).await.ticket;
    assert_eq!(exports.report(made(ticket, 0, 5)).await.unwrap(), Directive::Continue);
    assert_eq!(exports.report(made(ticket, 1, 6)).await.unwrap(), Directive::Stop);
    let (_, files) = app.store.export_plan(id).await.unwrap();
    exports.check_files(id, &files).await.unwrap();
    assert_eq!(exports.read_file(id, &files[1]).await.unwrap().to_vec(), [1; 6]);

    let old = app.store.export(id).await.unwrap();
    std::fs::remove_file(exports.folder.path(id, 0)).unwrap();
    assert_eq!(exports.check_files(id, &files).await.unwrap_err().status(), 409);
    assert_eq!(exports.check_files(id, &files).await.unwrap_err().status(), 409);
    // A server that has seen the export before it was queued again changes nothing.
    app.store.forget_export_files((id, old.epoch), vec![1]).await.unwrap();
    exports.delete(id).await.unwrap();
    assert!(exports.folder.has(id, 1, 6));

    let grant = claim(&exports).await;
    let numbers: Vec<_> = grant.files.iter().map(|file| file.number).collect();
    assert_eq!(numbers, [0]);
    assert_eq!(exports.report(made(grant.ticket, 0, 5)).await.unwrap(), Directive::Stop);
    exports.check_files(id, &files).await.unwrap();
    exports.delete(id).await.unwrap();
    assert!(!exports.folder.has(id, 1, 6));
    assert!(matches!(app.store.export(id).await, Err(StorageError::NotFound)));
}

#[tokio::test(flavor = "multi_thread")]
async fn cancelled_export_refuses_the_report_of_its_worker_and_leaves_no_file() {
    let (_dir, app, exports) = exports(1000).await;
    let id = queued(&app, 2).await;
    let ticket = claim(&exports).await.ticket;
    exports.report(made(ticket, 0, 5)).await.unwrap();
    assert_eq!(exports.cancel(id, None).await.unwrap().state, JobStatus::Cancelled);
    assert_eq!(exports.report(made(ticket, 1, 5)).await.unwrap_err().status(), 409);
    assert!(!exports.folder.has(id, 0, 5));
    assert_eq!(exports.cancel(id, None).await.unwrap_err().status(), 409);
    exports.prune().await.unwrap();
    assert!(app.store.export(id).await.is_ok(), "it is kept for a day");
}
