//! Tests of claims of searches, against a real store.

use brood_genome::Dialect;
use brood_protocol::{
    Budget, JobId, Lineage, LineageId, SearchOptions, Seed, Target, TargetId, encode,
};
use brood_storage::{NewSearch, NewTarget, SearchChange};
use tempfile::TempDir;

use super::*;
use crate::config::ServerConfig;
use crate::dispatch::{claim_lease, end_leases};
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
        islands: Vec::new(),
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
            islands: 1,
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

fn line(generation: u32) -> GenerationLine {
    GenerationLine {
        generation,
        evaluations: 10,
        fitted: 1.0,
        held: 1.0,
        median: 1.0,
        diversity: 1.0,
        repeats: 0,
        seconds: 1.0,
    }
}

#[tokio::test]
async fn claimed_search_is_requeued_without_a_death_when_request_was_dropped() {
    let (_dir, app) = app().await;
    let id = search(&app, no_genomes()).await;
    let pending = app.searches.claim("gone", ()).await.unwrap().expect("the search is queued");
    drop(pending);
    // Waits until the search is queued again: long before the first lease would expire.
    let grant = claim_lease(&app.searches, "next", (), 10_000)
        .await
        .unwrap()
        .expect("the search is queued");
    assert_eq!(grant.ticket, SearchTicket { job: id, epoch: 3 }, "claim, release, claim");
    assert_eq!(app.store.search(id).await.unwrap().deaths, 0);
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
    let worker = LostLeases::OfWorker("worker".to_owned());
    for (lost, deaths) in [(LostLeases::OfProcess, 0), (worker, 1)] {
        let grant = claim_lease(&app.searches, "worker", (), 0).await.unwrap().unwrap();
        end_leases(&*app.searches, LostLeases::OfWorker("other".to_owned())).await;
        end_leases(&*app.searches, LostLeases::Expired).await;
        app.searches.renew(&grant.ticket).await.unwrap();
        end_leases(&*app.searches, lost).await;
        let ended = app.searches.renew(&grant.ticket).await.unwrap_err();
        assert_eq!(ended.status(), 409);
        let search = app.store.search(id).await.unwrap();
        assert_eq!((search.state, search.deaths), (SearchState::Queued, deaths));
    }
}

#[tokio::test]
async fn report_whose_answer_was_lost_is_repeated_without_a_change() {
    let (_dir, app) = app().await;
    let id = search(&app, no_genomes()).await;
    let ticket = claim_lease(&app.searches, "worker", (), 0).await.unwrap().unwrap().ticket;
    let report = |generations: std::ops::RangeInclusive<u32>| {
        let (lines, checkpoint) = (generations.map(line).collect(), None);
        let update = SearchUpdate::Generations { lines, checkpoint, best: None, emigrants: None };
        SearchReport { ticket, held_ms: 5, update }
    };
    for generations in [1..=2, 1..=2, 3..=3] {
        let directive = app.searches.report(report(generations)).await.unwrap();
        assert_eq!(directive, Directive::Continue);
    }
    assert_eq!(app.searches.report(report(5..=5)).await.unwrap_err().status(), 422);
    assert_eq!(app.store.search(id).await.unwrap().generation, 3);
}

#[tokio::test]
async fn search_yields_with_a_checkpoint_after_its_time_slice() {
    let (_dir, app) = app().await;
    let first = search(&app, no_genomes()).await;
    let ticket = claim_lease(&app.searches, "worker", (), 0).await.unwrap().unwrap().ticket;
    let report = |held_s: u64, lines: Vec<GenerationLine>, checkpoint| {
        let update = SearchUpdate::Generations { lines, checkpoint, best: None, emigrants: None };
        app.searches.report(SearchReport { ticket, held_ms: 1000 * held_s, update })
    };
    let saved = || Some(vec![7]);
    assert_eq!(report(60, Vec::new(), saved()).await.unwrap(), Directive::Continue, "none waits");
    search(&app, no_genomes()).await;
    assert_eq!(report(5, Vec::new(), saved()).await.unwrap(), Directive::Continue);
    assert_eq!(report(60, vec![line(1)], None).await.unwrap(), Directive::Yield);
    assert_eq!(app.store.search(first).await.unwrap().state, SearchState::Running);
    assert_eq!(report(60, Vec::new(), saved()).await.unwrap(), Directive::Stop);
    assert_eq!(app.store.search(first).await.unwrap().state, SearchState::Queued);
    assert_eq!(report(60, Vec::new(), saved()).await.unwrap_err().status(), 409);
}

#[tokio::test]
async fn search_that_is_paused_takes_the_last_generations_of_its_worker_and_a_checkpoint() {
    let (_dir, app) = app().await;
    let id = search(&app, no_genomes()).await;
    let ticket = claim_lease(&app.searches, "worker", (), 0).await.unwrap().unwrap().ticket;
    let report = |lines: Vec<GenerationLine>, checkpoint| {
        let update = SearchUpdate::Generations { lines, checkpoint, best: None, emigrants: None };
        app.searches.report(SearchReport { ticket, held_ms: 5, update })
    };
    assert_eq!(report(vec![line(1)], None).await.unwrap(), Directive::Continue);
    let pause = app.store.change_search(id, SearchChange::Pause, None, 5).await.unwrap();
    assert_eq!(pause.unwrap().state, SearchState::Paused);
    app.searches.renew(&ticket).await.unwrap();
    for _ in 0..2 {
        assert_eq!(report(vec![line(2)], None).await.unwrap(), Directive::Yield);
    }
    assert_eq!(report(Vec::new(), Some(vec![7])).await.unwrap(), Directive::Stop);
    let paused = app.store.search(id).await.unwrap();
    assert_eq!((paused.state, paused.generation), (SearchState::Paused, 2));
    app.store.change_search(id, SearchChange::Resume, None, 5).await.unwrap().unwrap();
    assert_eq!(report(Vec::new(), Some(vec![8])).await.unwrap_err().status(), 409);
    assert_eq!(app.searches.renew(&ticket).await.unwrap_err().status(), 409);
    let grant = claim_lease(&app.searches, "worker", (), 0).await.unwrap().unwrap();
    assert_eq!(grant.checkpoint, Some(vec![7]));
}

#[tokio::test]
async fn report_that_arrives_twice_at_once_is_stored_once() {
    let (_dir, app) = app().await;
    let id = search(&app, no_genomes()).await;
    let ticket = claim_lease(&app.searches, "worker", (), 0).await.unwrap().unwrap().ticket;
    for generation in 1..=50 {
        let report = || {
            let lines = vec![line(generation)];
            let update =
                SearchUpdate::Generations { lines, checkpoint: None, best: None, emigrants: None };
            app.searches.report(SearchReport { ticket, held_ms: 5, update })
        };
        let both = tokio::join!(report(), report());
        assert_eq!((both.0.unwrap(), both.1.unwrap()), (Directive::Continue, Directive::Continue));
    }
    assert_eq!(app.store.search_log(id, 0, 100).await.unwrap().len(), 50);
}
