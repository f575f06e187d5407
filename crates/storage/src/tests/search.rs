//! Tests of searches: claims in turn, steps, changes by users, worker deaths, stale epochs.

use brood_protocol::{
    Budget, FoundMaterial, GenerationLine, SearchOptions, SearchState, Target, TargetId,
};

use super::*;
use crate::{
    ClaimedSearch, NewSearch, NewTarget, SearchChange, SearchEnd, SearchStep, StoredSearch,
};

fn target() -> NewTarget {
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
    NewTarget { target, hash: hash("file"), bytes: vec![1, 2, 3], idempotency: None }
}

async fn search(store: &Store, target: TargetId, lineage: LineageId) -> JobId {
    let id = JobId::fresh();
    let options = SearchOptions {
        name: "paint".to_owned(),
        strategy: "lobes".to_owned(),
        objective: Some("seen".to_owned()),
        seed: Seed(u64::MAX),
        threads: None,
        mirrored: true,
        budget: Budget::Generations(10),
        target_error: None,
        start: Vec::new(),
    };
    let new = NewSearch {
        id,
        target,
        lineage,
        new_lineage: None,
        options,
        start: vec![9],
        created_ms: 8,
        idempotency: None,
    };
    store.create_search(new, 10).await.unwrap();
    id
}

fn step(claimed: &ClaimedSearch, generations: std::ops::RangeInclusive<u32>) -> SearchStep {
    let line = |generation: u32| GenerationLine {
        generation,
        evaluations: u64::from(generation) * 100,
        fitted: f64::INFINITY,
        held: 1.0 / f64::from(generation),
        median: 2.0 / f64::from(generation),
        diversity: 0.5,
        repeats: u64::from(generation),
        seconds: f64::from(generation),
    };
    let lines: Vec<_> = generations.map(line).collect();
    SearchStep {
        id: claimed.id,
        epoch: claimed.epoch,
        seconds: lines.last().map_or(0.0, |line| line.seconds),
        lines,
        checkpoint: Some((vec![5; 9], hash("state"))),
        best: None,
        best_before: None,
        yields: false,
        end: None,
    }
}

async fn claim(store: &Store) -> ClaimedSearch {
    store.claim_search("worker", 20).await.unwrap().expect("a search is queued")
}

async fn change(
    store: &Store,
    id: JobId,
    change: SearchChange,
) -> Result<SearchState, SearchState> {
    store.change_search(id, change, 30).await.unwrap().map(|search: StoredSearch| search.state)
}

async fn fixture() -> (Place, Store, TargetId, LineageId) {
    let (place, store) = open().await;
    let new = target();
    let target = new.target.id;
    store.create_target(new).await.unwrap();
    let lineage = lineage(&store).await;
    (place, store, target, lineage)
}

#[tokio::test]
async fn search_resumes_from_stored_checkpoint() {
    let (_dir, store, target, lineage) = fixture().await;
    let id = search(&store, target, lineage).await;
    let claimed = claim(&store).await;
    assert_eq!((claimed.id, claimed.checkpoint.clone(), &claimed.start[..]), (id, None, &[9][..]));
    store.step_search(step(&claimed, 1..=2)).await.unwrap();
    let now = store.step_search(step(&claimed, 3..=3)).await.unwrap();
    assert_eq!((now.generation, now.evaluations, now.seconds), (3, 300, 3.0));
    assert_eq!(
        (now.fitted, now.held, now.population),
        (None, Some(1.0 / 3.0), Some(hash("state")))
    );
    assert_eq!(store.requeue_all_searches().await.unwrap(), 1);
    let again = claim(&store).await;
    assert_eq!((again.checkpoint.clone(), again.seconds), (Some(vec![5; 9]), 3.0));
    let stale = store.step_search(step(&claimed, 4..=4)).await;
    assert!(matches!(stale, Err(StorageError::Conflict { .. })), "{stale:?}");
    let log = store.search_log(id, 1, 10).await.unwrap();
    assert_eq!(log.iter().map(|line| line.generation).collect::<Vec<_>>(), [2, 3]);
    let end = SearchEnd {
        state: SearchState::Succeeded,
        reason: None,
        front: Vec::<FoundMaterial>::new(),
        ended_ms: 40,
    };
    let last = SearchStep { end: Some(end), ..step(&again, 4..=4) };
    let done = store.step_search(last).await.unwrap();
    assert_eq!((done.state, done.ended_ms), (SearchState::Succeeded, Some(40)));
    assert!(store.claim_search("worker", 50).await.unwrap().is_none());
}

#[tokio::test]
async fn searches_take_turns_and_users_can_interrupt() {
    let (_dir, store, target, lineage) = fixture().await;
    let (first, second) =
        (search(&store, target, lineage).await, search(&store, target, lineage).await);
    let claimed = claim(&store).await;
    assert_eq!(claimed.id, first);
    store.step_search(SearchStep { yields: true, ..step(&claimed, 1..=1) }).await.unwrap();
    let other = claim(&store).await;
    assert_eq!(other.id, second, "the first search moved to the end of the queue");
    assert_eq!(change(&store, second, SearchChange::Resume).await, Err(SearchState::Running));
    assert_eq!(change(&store, second, SearchChange::Pause).await, Ok(SearchState::Paused));
    let late = store.step_search(step(&other, 1..=1)).await;
    assert!(matches!(late, Err(StorageError::Conflict { .. })), "{late:?}");
    assert!(matches!(store.delete_target(target).await, Err(StorageError::Conflict { .. })));
    assert_eq!(change(&store, second, SearchChange::Resume).await, Ok(SearchState::Queued));
    for id in [first, second] {
        assert_eq!(change(&store, id, SearchChange::Cancel).await, Ok(SearchState::Cancelled));
        assert_eq!(change(&store, id, SearchChange::Cancel).await, Err(SearchState::Cancelled));
    }
    store.delete_target(target).await.unwrap();
    assert!(matches!(store.target_file(hash("file")).await, Err(StorageError::NotFound)));
    let listed = store.list_searches(None, None, 10).await.unwrap();
    assert_eq!(listed.iter().map(|one| one.id).collect::<Vec<_>>(), [second, first]);
    let born = async |lineage| store.list_searches(None, Some(lineage), 10).await.unwrap();
    assert_eq!(born(lineage).await, listed);
    assert!(born(LineageId::fresh()).await.is_empty());
    store.purge_lineage(lineage).await.unwrap();
    assert!(store.list_searches(None, None, 10).await.unwrap().is_empty());
}

#[tokio::test]
async fn search_fails_when_three_workers_die_without_progress() {
    let (_dir, store, target, lineage) = fixture().await;
    let id = search(&store, target, lineage).await;
    for round in 0..5 {
        let claimed = claim(&store).await;
        if round == 1 {
            // A step resets the count of deaths.
            store.step_search(step(&claimed, 1..=1)).await.unwrap();
        }
        let now = store.release_search(id, claimed.epoch, true, 60).await.unwrap();
        let expected = if round == 3 { SearchState::Failed } else { SearchState::Queued };
        assert_eq!(now.state, expected, "{round}");
        if now.state == SearchState::Failed {
            assert_eq!(now.reason.as_deref(), Some("worker_lost"));
            break;
        }
    }
    assert_eq!(store.search(id).await.unwrap().state, SearchState::Failed);
}
