//! Tests of claims of searches, against a real store.

use brood_genome::Dialect;
use brood_protocol::{Budget, Lineage, LineageId, SearchOptions, Seed, Target, TargetId, encode};
use brood_storage::{NewSearch, NewTarget};
use tempfile::TempDir;

use super::*;
use crate::config::ServerConfig;
use crate::dispatch::{LeaseEnd, claim_lease, end_leases};
use crate::server::Server;
use crate::state::App;

async fn app() -> (TempDir, App) {
    let dir = tempfile::tempdir().unwrap();
    let address = "127.0.0.1:0".parse().unwrap();
    let server = Server::bind(ServerConfig::new(address, dir.path().to_owned())).await.unwrap();
    (dir, server.app())
}

/// Queues a search whose start genomes are these bytes.
async fn search(app: &App, start: Vec<u8>) -> JobId {
    let target = Target {
        id: TargetId::fresh(),
        kind: "samples".to_owned(),
        name: "paint".to_owned(),
        samples: 600,
        fitted_samples: 480,
        held_out_samples: 120,
        skipped_samples: 0,
        largest_f: 0.5,
        reciprocal_floor: None,
        largest_albedo: None,
        hash: "00".to_owned(),
        bytes: 3,
        created_ms: 7,
        views: Vec::new(),
    };
    let new = NewSearch {
        id: JobId::fresh(),
        target: target.id,
        lineage: LineageId::fresh(),
        new_lineage: None,
        options: SearchOptions {
            name: "paint".to_owned(),
            strategy: "lobes".to_owned(),
            objective: Some("seen".to_owned()),
            seed: Seed(1),
            threads: None,
            mirrored: true,
            budget: Budget::Generations(10),
            target_error: None,
            start: Vec::new(),
        },
        start,
        created_ms: 8,
        idempotency: None,
    };
    let hash = *blake3::hash(b"file").as_bytes();
    let file = NewTarget { target, hash, bytes: vec![1, 2, 3], idempotency: None };
    app.store.create_target(file).await.unwrap();
    let lineage = Lineage {
        id: new.lineage,
        name: "first".to_owned(),
        notes: String::new(),
        tags: Vec::new(),
        hidden: false,
        cover_individual: None,
        scene: app.store.put_scene("{}", hash, &[], 1).await.unwrap(),
        thumbnail_px: 256,
        dialect: Dialect::default(),
        saturation: 0.1,
        start: brood_genome::Start::Wild,
        energy_limit: true,
        generations: 0,
        favourites: 0,
        created_ms: 5,
        version: 1,
    };
    app.store.create_lineage(lineage, None).await.unwrap();
    let id = new.id;
    app.store.create_search(new, 10).await.unwrap();
    id
}

fn no_genomes() -> Vec<u8> {
    encode(&Vec::<Vec<u8>>::new())
}

#[tokio::test]
async fn claimed_search_is_requeued_without_a_death_when_request_was_dropped() {
    let (_dir, app) = app().await;
    let id = search(&app, no_genomes()).await;
    let claimed = async {
        while app.searches.jobs.leases.len() == 0 {
            tokio::task::yield_now().await;
        }
    };
    tokio::select! {
        biased;
        () = claimed => {}
        _ = claim_lease(&app.searches, "gone", (), 20_000) => panic!("the request is dropped first"),
    }
    // Waits until the search is queued again: long before the first lease would expire.
    let grant = claim_lease(&app.searches, "next", (), 10_000)
        .await
        .unwrap()
        .expect("the search is queued");
    assert_eq!(grant.ticket, SearchTicket { job: id, epoch: 3 }, "claim, release, claim");
    assert_eq!(app.store.search(id).await.unwrap().deaths, 0);
    assert_eq!(app.searches.jobs.leases.len(), 1);
}

#[tokio::test]
async fn search_fails_with_reason_when_start_cannot_be_decoded() {
    let (_dir, app) = app().await;
    let broken = search(&app, vec![9]).await;
    assert!(claim_lease(&app.searches, "worker", (), 0).await.unwrap().is_none());
    let search = app.store.search(broken).await.unwrap();
    assert_eq!(search.state, SearchState::Failed);
    assert!(search.reason.unwrap().starts_with("cannot decode the start genomes"));
    assert!(search.ended_ms.is_some());
    assert_eq!(app.searches.jobs.leases.len(), 0);
}

#[tokio::test]
async fn next_search_is_claimed_when_start_of_the_first_cannot_be_decoded() {
    let (_dir, app) = app().await;
    search(&app, vec![9]).await;
    let good = search(&app, no_genomes()).await;
    let grant = claim_lease(&app.searches, "worker", (), 0).await.unwrap().unwrap();
    assert_eq!(grant.ticket.job, good);
}

#[tokio::test]
async fn search_of_a_dead_worker_is_requeued_with_a_death_but_not_at_shutdown() {
    let (_dir, app) = app().await;
    let id = search(&app, no_genomes()).await;
    for (end, deaths) in [(LeaseEnd::Shutdown, 0), (LeaseEnd::Death("worker"), 1)] {
        let grant = claim_lease(&app.searches, "worker", (), 0).await.unwrap().unwrap();
        end_leases(&*app.searches, LeaseEnd::Death("other")).await;
        end_leases(&*app.searches, LeaseEnd::Expired).await;
        renew_lease(&*app.searches, &grant.ticket).unwrap();
        end_leases(&*app.searches, end).await;
        assert!(renew_lease(&*app.searches, &grant.ticket).is_err());
        let search = app.store.search(id).await.unwrap();
        assert_eq!((search.state, search.deaths), (SearchState::Queued, deaths));
    }
}
