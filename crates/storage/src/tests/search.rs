//! Tests of searches: claims in turn, steps, changes by users, worker deaths, stale epochs.

use brood_protocol::{
    Budget, FoundMaterial, GenerationLine, SearchOptions, SearchState, Target, TargetId,
};

use super::*;
use crate::{
    ClaimedSearch, EndedLease, IslandEnd, IslandEnded, LostLeases, NewSearch, NewTarget,
    SearchChange, SearchEnd, SearchStep, StoredArrival, StoredSearch,
};

pub(super) fn target() -> NewTarget {
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

pub(super) async fn search(store: &Store, target: TargetId, lineage: LineageId) -> JobId {
    islands(store, target, lineage, 1).await[0]
}

/// Stores a search of several islands. Returns their ids.
async fn islands(store: &Store, target: TargetId, lineage: LineageId, count: u32) -> Vec<JobId> {
    let ids: Vec<JobId> = (0..count).map(|_| JobId::fresh()).collect();
    let id = ids[0];
    let options = SearchOptions {
        name: "paint".to_owned(),
        strategy: "lobes".to_owned(),
        objective: Some("seen".to_owned()),
        seed: Seed(u64::MAX),
        threads: None,
        mirrored: true,
        budget: Budget::Generations(10),
        islands: count,
        target_error: None,
        start: Vec::new(),
    };
    let new = NewSearch {
        id,
        islands: ids[1..].to_vec(),
        target,
        lineage,
        new_lineage: None,
        options,
        start: vec![9],
        created_ms: 8,
        idempotency: None,
    };
    store.create_search(new, 10).await.unwrap();
    ids
}

/// Time to live of the leases.
const LEASE: Duration = Duration::from_secs(20);

/// Returns the leased search to the queue as its worker does.
async fn release_all(store: &Store) {
    for search in store.list_searches(None, None, 10).await.unwrap() {
        if search.state == SearchState::Running {
            store.release_search(search.id, search.epoch, false, 30).await.unwrap();
        }
    }
}

pub(super) fn step(
    claimed: &ClaimedSearch,
    generations: std::ops::RangeInclusive<u32>,
) -> SearchStep {
    let from = generations.start() - 1;
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
        is_paused: false,
        from,
        seconds: lines.last().map_or(0.0, |line| line.seconds),
        lines,
        checkpoint: Some((vec![5; 9], hash("state"))),
        archipelago: None,
        emigrants: None,
        best: None,
        best_before: None,
        yields: false,
        ttl: LEASE,
        end: None,
    }
}

pub(super) async fn claim(store: &Store) -> ClaimedSearch {
    store.claim_search("worker", LEASE, 20).await.unwrap().expect("a search is queued")
}

async fn change(
    store: &Store,
    id: JobId,
    change: SearchChange,
) -> Result<SearchState, SearchState> {
    store
        .change_search(id, change, None, 30)
        .await
        .unwrap()
        .map(|search: StoredSearch| search.state)
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
    release_all(&store).await;
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
    assert!(store.claim_search("worker", LEASE, 50).await.unwrap().is_none());
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
async fn paused_search_takes_what_its_worker_had_computed() {
    let (_dir, store, target, lineage) = fixture().await;
    let id = search(&store, target, lineage).await;
    let claimed = claim(&store).await;
    store.step_search(step(&claimed, 1..=1)).await.unwrap();
    assert_eq!(change(&store, id, SearchChange::Pause).await, Ok(SearchState::Paused));
    let paused = store.search(id).await.unwrap();
    let late = SearchStep { epoch: paused.epoch, is_paused: true, ..step(&claimed, 2..=4) };
    let now = store.step_search(late.clone()).await.unwrap();
    assert_eq!((now.state, now.epoch, now.generation), (SearchState::Paused, paused.epoch, 4));
    let twice = store.step_search(late).await;
    assert!(matches!(twice, Err(StorageError::Conflict { .. })), "{twice:?}");
    assert_eq!(change(&store, id, SearchChange::Resume).await, Ok(SearchState::Queued));
    let again = claim(&store).await;
    assert_eq!((again.generation, again.checkpoint), (4, Some(vec![5; 9])));
    let late = SearchStep { epoch: paused.epoch, is_paused: true, ..step(&claimed, 5..=5) };
    let late = store.step_search(late).await;
    assert!(matches!(late, Err(StorageError::Conflict { .. })), "{late:?}");
}

#[tokio::test]
async fn expired_lease_is_no_death_after_a_fault_of_the_database() {
    let (_dir, store, target, lineage) = fixture().await;
    search(&store, target, lineage).await;
    store.claim_search("worker", Duration::ZERO, 20).await.unwrap().unwrap();
    let ended = async || store.end_search_leases(LostLeases::Expired, 60).await.unwrap();
    store.lease_faults().note::<()>(&Err(StorageError::Full));
    assert!(ended().await.is_empty(), "the worker gets time to renew its lease");
    store.lease_faults().pass(Duration::from_secs(21));
    let (_, search) = ended().await.pop().expect("the worker did not renew it");
    assert_eq!((search.state, search.deaths), (SearchState::Queued, 0));
    store.claim_search("worker", Duration::ZERO, 20).await.unwrap().unwrap();
    store.lease_faults().pass(Duration::from_secs(40));
    assert_eq!(ended().await[0].1.deaths, 1);
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

#[tokio::test]
async fn next_lease_continues_from_the_checkpoint_and_forgets_the_generations_after_it() {
    let (_dir, store, target, lineage) = fixture().await;
    let id = search(&store, target, lineage).await;
    let claimed = claim(&store).await;
    let unsaved = |claimed: &ClaimedSearch, generations| SearchStep {
        checkpoint: None,
        ..step(claimed, generations)
    };
    store.step_search(unsaved(&claimed, 1..=2)).await.unwrap();
    release_all(&store).await;
    let claimed = claim(&store).await;
    assert_eq!((claimed.generation, claimed.checkpoint.clone(), claimed.seconds), (0, None, 0.0));
    let begun = store.search(id).await.unwrap();
    assert_eq!((begun.generation, begun.evaluations, begun.held), (0, 0, None));
    assert!(store.search_log(id, 0, 10).await.unwrap().is_empty());

    store.step_search(step(&claimed, 1..=3)).await.unwrap();
    let now = store.step_search(unsaved(&claimed, 4..=6)).await.unwrap();
    assert_eq!((now.generation, now.held), (6, Some(1.0 / 6.0)));
    release_all(&store).await;
    let again = claim(&store).await;
    assert_eq!((again.generation, again.seconds), (3, 3.0));
    assert_eq!(again.checkpoint, Some(vec![5; 9]));
    let begun = store.search(id).await.unwrap();
    assert_eq!((begun.generation, begun.evaluations, begun.seconds), (3, 300, 3.0));
    assert_eq!((begun.fitted, begun.held), (None, Some(1.0 / 3.0)));
    store.step_search(unsaved(&again, 4..=4)).await.unwrap();
    let log = store.search_log(id, 0, 10).await.unwrap();
    assert_eq!(log.iter().map(|line| line.generation).collect::<Vec<_>>(), [1, 2, 3, 4]);
    store.purge_lineage(lineage).await.unwrap();
}

#[tokio::test]
async fn lease_expires_unless_a_renewal_or_a_step_prolongs_it() {
    let (_dir, store, target, lineage) = fixture().await;
    search(&store, target, lineage).await;
    let short = Duration::from_millis(1);
    let ended = async || store.end_search_leases(LostLeases::Expired, 60).await.unwrap();
    for prolonged in ["never", "by a renewal", "by a step"] {
        let claimed = store.claim_search("worker", short, 20).await.unwrap().unwrap();
        match prolonged {
            "never" => {}
            "by a renewal" => store.renew_search(claimed.id, claimed.epoch, LEASE).await.unwrap(),
            _ => drop(store.step_search(step(&claimed, 1..=1)).await.unwrap()),
        }
        tokio::time::sleep(Duration::from_millis(20)).await;
        let expired = ended().await;
        if prolonged == "never" {
            let lease =
                EndedLease { id: claimed.id, epoch: claimed.epoch, worker: "worker".to_owned() };
            assert_eq!(expired[0].0, lease);
            assert_eq!((expired[0].1.state, expired[0].1.deaths), (SearchState::Queued, 1));
            let stale = store.renew_search(claimed.id, claimed.epoch, LEASE).await;
            assert!(matches!(stale, Err(StorageError::Conflict { .. })), "{stale:?}");
        } else {
            assert!(expired.is_empty(), "{prolonged}");
            store.renew_search(claimed.id, claimed.epoch, short).await.unwrap();
            tokio::time::sleep(Duration::from_millis(20)).await;
            assert_eq!(ended().await.len(), 1, "{prolonged}");
        }
        assert!(ended().await.is_empty());
    }
}

#[tokio::test]
async fn all_leases_of_a_process_end_on_sqlite_alone() {
    let (place, store, target, lineage) = fixture().await;
    search(&store, target, lineage).await;
    claim(&store).await;
    let other = LostLeases::OfWorker("other".to_owned());
    assert!(store.end_search_leases(other, 60).await.unwrap().is_empty());
    let ended = store.end_search_leases(LostLeases::OfProcess, 60).await.unwrap();
    assert_eq!(ended.len(), usize::from(matches!(place, Place::Directory(_))));
    for (_, search) in ended {
        assert_eq!((search.state, search.deaths), (SearchState::Queued, 0));
    }
}

#[tokio::test]
async fn island_waits_for_the_migrants_of_the_one_before() {
    let (_dir, store, target, lineage) = fixture().await;
    let ids = islands(&store, target, lineage, 2).await;
    assert_eq!(store.list_searches(None, None, 10).await.unwrap().len(), 1);
    let [first, second] = [claim(&store).await, claim(&store).await];
    assert_eq!((first.id, first.island, second.id, second.island), (ids[0], 0, ids[1], 1));
    let migrate = |claimed: &ClaimedSearch, genomes: u8| SearchStep {
        archipelago: Some(ids[0]),
        emigrants: Some(vec![genomes]),
        yields: true,
        ..step(claimed, 1..=2)
    };
    store.step_search(migrate(&first, 1)).await.unwrap();
    assert!(!store.any_search_queued().await.unwrap(), "the second has sent nothing");
    assert!(store.claim_search("worker", LEASE, 20).await.unwrap().is_none());
    let sent = store.search_arrival(ids[1], 2).await.unwrap();
    assert_eq!(sent, Some(StoredArrival::Migrants(vec![1])));
    store.step_search(migrate(&second, 2)).await.unwrap();
    let first = claim(&store).await;
    assert_eq!((first.id, &first.arrival), (ids[0], &Some(StoredArrival::Migrants(vec![2]))));
    assert!(first.checkpoint.is_some());
    // A lease that was lost takes them again; a later checkpoint has them.
    store.release_search(first.id, first.epoch, false, 30).await.unwrap();
    let first = claim(&store).await;
    assert_eq!(first.arrival, Some(StoredArrival::Migrants(vec![2])));
    store.step_search(step(&first, 3..=3)).await.unwrap();
    store.release_search(first.id, first.epoch, false, 30).await.unwrap();
    let first = claim(&store).await;
    assert_eq!((first.id, &first.arrival), (ids[0], &None));
    let second = claim(&store).await;
    assert_eq!((second.id, &second.arrival), (ids[1], &Some(StoredArrival::Migrants(vec![1]))));
}

#[tokio::test]
async fn search_of_islands_ends_with_the_last() {
    let (_dir, store, target, lineage) = fixture().await;
    let ids = islands(&store, target, lineage, 3).await;
    let mut claimed = Vec::new();
    for _ in 0..3 {
        let own = claim(&store).await;
        store.step_search(step(&own, 1..=2)).await.unwrap();
        claimed.push(own);
    }
    let end = |own: &ClaimedSearch| IslandEnd {
        id: own.id,
        epoch: own.epoch,
        generation: 2,
        seconds: 2.0,
        front: vec![u8::try_from(own.island).unwrap()],
    };
    assert!(matches!(
        store.end_island(ids[0], end(&claimed[2])).await.unwrap(),
        IslandEnded::Stored(_)
    ));
    let stale = store.end_island(ids[0], end(&claimed[2])).await;
    assert!(matches!(stale, Err(StorageError::Conflict { .. })), "{stale:?}");
    assert_eq!(
        store.search_arrival(ids[0], 9).await.unwrap(),
        Some(StoredArrival::Front(vec![2])),
        "the first takes from the last"
    );
    store.end_island(ids[0], end(&claimed[0])).await.unwrap();
    assert!(store.claim_search("worker", LEASE, 20).await.unwrap().is_none());
    let others = store.end_island(ids[0], end(&claimed[1])).await.unwrap();
    assert_eq!(others, IslandEnded::Last(vec![(0, vec![0]), (2, vec![2])]));
    let last = SearchStep {
        archipelago: Some(ids[0]),
        lines: Vec::new(),
        from: 2,
        checkpoint: None,
        end: Some(SearchEnd {
            state: SearchState::Succeeded,
            reason: None,
            front: Vec::new(),
            ended_ms: 40,
        }),
        ..step(&claimed[1], 1..=2)
    };
    store.step_search(last).await.unwrap();
    let ended = store.islands(ids[0]).await.unwrap();
    assert!(ended.iter().all(|one| one.state == SearchState::Succeeded && !one.is_over));
    assert!(matches!(store.islands(ids[1]).await, Err(StorageError::NotFound)));
}

#[tokio::test]
async fn change_of_a_search_concerns_all_of_its_islands() {
    let (_dir, store, target, lineage) = fixture().await;
    let ids = islands(&store, target, lineage, 2).await;
    let claimed = claim(&store).await;
    assert_eq!(change(&store, ids[0], SearchChange::Pause).await, Ok(SearchState::Paused));
    let states = async || {
        let all = store.islands(ids[0]).await.unwrap();
        all.iter().map(|one| one.state).collect::<Vec<_>>()
    };
    assert_eq!(states().await, [SearchState::Paused; 2]);
    assert!(store.step_search(step(&claimed, 1..=1)).await.is_err());
    assert_eq!(change(&store, ids[0], SearchChange::Resume).await, Ok(SearchState::Queued));
    // An island whose workers die fails the search.
    for _ in 0..3 {
        let claimed = claim(&store).await;
        assert_eq!(claimed.id, ids[0]);
        store.release_search(claimed.id, claimed.epoch, true, 30).await.unwrap();
    }
    assert_eq!(states().await, [SearchState::Failed; 2]);
}

#[tokio::test]
async fn islands_that_fail_at_once_end_with_the_leases_of_others() {
    let (_dir, store, target, lineage) = fixture().await;
    let ids = islands(&store, target, lineage, 3).await;
    let other = search(&store, target, lineage).await;
    for round in 1..=3 {
        for _ in 0..4 {
            claim(&store).await;
        }
        let lost = LostLeases::OfWorker("worker".to_owned());
        let ended = store.end_search_leases(lost, 30).await.unwrap();
        assert_eq!(ended.len(), if round < 3 { 4 } else { 2 }, "{ended:?}");
    }
    for id in [ids[0], ids[1], ids[2], other] {
        let ended = store.search(id).await.unwrap();
        assert_eq!(ended.state, SearchState::Failed);
        assert_eq!(ended.reason.as_deref(), Some("worker_lost"));
    }
}
