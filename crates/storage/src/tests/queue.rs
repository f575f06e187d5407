//! Tests of the render queue.

use brood_protocol::Queue;

use super::{job, lineage, new_generation, open};
use crate::{ClaimedJob, FIRST_EPOCH, JobState, NewJob, StorageError, Store};

const NO_LIMIT: u64 = 1000;

async fn enqueue(store: &Store, queue: Queue) -> brood_protocol::JobId {
    let job = job(queue);
    let id = job.id;
    store.enqueue(job, NO_LIMIT).await.unwrap();
    id
}

/// Claims the next interactive job, or the next batch job if there is none.
async fn claim(store: &Store, worker: &str) -> Option<ClaimedJob> {
    match store.claim(worker, Queue::Interactive).await.unwrap() {
        None => store.claim(worker, Queue::Batch).await.unwrap(),
        claimed => claimed,
    }
}

#[tokio::test]
async fn job_is_deleted_when_completed() {
    let (_dir, store) = open().await;
    assert_eq!(claim(&store, "w").await, None);
    let id = enqueue(&store, Queue::Interactive).await;
    let claimed = claim(&store, "w").await.unwrap();
    assert_eq!((claimed.id, claimed.epoch), (id, 1));
    assert_eq!(claimed.payload, b"pixels, please");
    assert_eq!(claim(&store, "x").await, None);
    let row = store.job(id).await.unwrap();
    assert_eq!((row.state, row.worker.as_deref(), row.epoch), (JobState::Leased, Some("w"), 1));
    store.complete(id, 1).await.unwrap();
    assert!(matches!(store.job(id).await, Err(StorageError::NotFound)));
    let twice = store.complete(id, 1).await;
    assert!(matches!(twice, Err(StorageError::Conflict { .. })), "{twice:?}");
}

#[tokio::test]
async fn transition_is_rejected_when_epoch_is_stale() {
    let (_dir, store) = open().await;
    let id = enqueue(&store, Queue::Interactive).await;
    let first = claim(&store, "slow").await.unwrap();
    assert_eq!(store.release(id, first.epoch, true).await.unwrap(), JobState::Queued);
    let unleased = store.complete(id, first.epoch).await;
    assert!(matches!(unleased, Err(StorageError::Conflict { .. })), "{unleased:?}");
    let second = claim(&store, "fast").await.unwrap();
    assert_eq!((second.id, second.epoch), (id, 2));
    let before = store.job(id).await.unwrap();
    for late in [
        store.complete(id, 1).await,
        store.fail(id, 1, "late").await,
        store.release(id, 1, true).await.map(drop),
        store.complete(id, 3).await,
    ] {
        assert!(matches!(late, Err(StorageError::Conflict { .. })), "{late:?}");
    }
    assert_eq!(store.job(id).await.unwrap(), before);
    store.complete(id, 2).await.unwrap();
}

#[tokio::test]
async fn job_becomes_dead_when_three_workers_died() {
    let (_dir, store) = open().await;
    let id = enqueue(&store, Queue::Interactive).await;
    let mut states = Vec::new();
    for died in [true, false, false, true, true] {
        let epoch = claim(&store, "w").await.unwrap().epoch;
        states.push(store.release(id, epoch, died).await.unwrap());
    }
    use JobState::{Dead, Queued};
    assert_eq!(states, [Queued, Queued, Queued, Queued, Dead]);
    let row = store.job(id).await.unwrap();
    assert_eq!((row.deaths, row.reason.as_deref()), (3, Some("worker_lost")));
    assert_eq!(claim(&store, "w").await, None);
}

#[tokio::test]
async fn job_keeps_reason_when_failed() {
    let (_dir, store) = open().await;
    let id = enqueue(&store, Queue::Batch).await;
    let epoch = claim(&store, "w").await.unwrap().epoch;
    store.fail(id, epoch, "no such mesh").await.unwrap();
    let row = store.job(id).await.unwrap();
    assert_eq!((row.state, row.reason.as_deref()), (JobState::Failed, Some("no such mesh")));
    for _ in 0..105 {
        let id = enqueue(&store, Queue::Batch).await;
        claim(&store, "w").await.unwrap();
        store.fail(id, 1, "again").await.unwrap();
    }
    assert_eq!(store.queue_depth().await.unwrap().of(Queue::Batch, JobState::Failed), 100);
    assert!(matches!(store.job(id).await, Err(StorageError::NotFound)));
}

#[tokio::test]
async fn jobs_are_claimed_by_turn_and_by_queue() {
    let (_dir, store) = open().await;
    let mut ids = Vec::new();
    for turn in [5, 2, 2, 9] {
        let job = NewJob { turn, ..job(Queue::Interactive) };
        ids.push(job.id);
        store.enqueue(job, NO_LIMIT).await.unwrap();
    }
    let batch = enqueue(&store, Queue::Batch).await;
    let mut claimed = Vec::new();
    while let Some(job) = store.claim("w", Queue::Interactive).await.unwrap() {
        claimed.push((job.id, job.turn));
    }
    assert_eq!(claimed, [(ids[1], 2), (ids[2], 2), (ids[0], 5), (ids[3], 9)]);
    assert_eq!(store.claim("w", Queue::Batch).await.unwrap().unwrap().id, batch);
    store.requeue_all_leased().await.unwrap();
    let first = store.claim("w", Queue::Interactive).await.unwrap().unwrap();
    assert_eq!((first.id, first.turn), (ids[0], 0), "all clients begin anew");
}

#[tokio::test]
async fn queues_have_separate_limits() {
    let (_dir, store) = open().await;
    store.enqueue(job(Queue::Batch), 2).await.unwrap();
    store.enqueue(job(Queue::Batch), 2).await.unwrap();
    let full = store.enqueue(job(Queue::Batch), 2).await;
    assert!(matches!(full, Err(StorageError::QueueFull)), "{full:?}");
    assert!(store.is_queue_full(Queue::Batch, 2).await.unwrap());
    assert!(!store.is_queue_full(Queue::Batch, 3).await.unwrap());
    assert!(!store.is_queue_full(Queue::Interactive, 1).await.unwrap());
    store.enqueue(job(Queue::Interactive), 2).await.unwrap();
    claim(&store, "w").await.unwrap();
    let depth = store.queue_depth().await.unwrap();
    let all: Vec<_> = depth.iter().collect();
    let expected = [(Queue::Interactive, JobState::Leased, 1), (Queue::Batch, JobState::Queued, 2)];
    assert_eq!(all, expected);
    assert_eq!(depth.of(Queue::Batch, JobState::Leased), 0);
}

#[tokio::test]
async fn leased_jobs_are_requeued_when_server_starts() {
    let (_dir, store) = open().await;
    let id = enqueue(&store, Queue::Interactive).await;
    enqueue(&store, Queue::Interactive).await;
    claim(&store, "w").await.unwrap();
    assert_eq!(store.requeue_all_leased().await.unwrap(), 1);
    let row = store.job(id).await.unwrap();
    assert_eq!((row.state, row.deaths, row.worker), (JobState::Queued, 0, None));
    assert_eq!(claim(&store, "w").await.unwrap().epoch, 2);
}

#[tokio::test]
async fn job_is_leased_at_once_when_inserted_with_worker() {
    let (dir, store) = open().await;
    let lineage = lineage(&store).await;
    assert!(!store.any_queued(Queue::Interactive).await.unwrap());
    assert_eq!(store.oldest_queued_ms(Queue::Interactive).await.unwrap(), None);
    let mut new = new_generation(lineage, &[], "a");
    let job = NewJob { leased_to: Some("w".to_owned()), ..job(Queue::Interactive) };
    let (id, created_ms) = (job.id, job.created_ms);
    new.job = Some(job);
    store.create_generation(new).await.unwrap();
    assert!(!store.any_queued(Queue::Interactive).await.unwrap());
    assert_eq!(claim(&store, "other").await, None);
    let row = store.job(id).await.unwrap();
    let found = (row.state, row.epoch, row.worker.as_deref());
    assert_eq!(found, (JobState::Leased, FIRST_EPOCH, Some("w")));
    // The lease behaves like any other: it is released and claimed under the next epoch, and only
    // that epoch counts.
    assert_eq!(store.release(id, FIRST_EPOCH, false).await.unwrap(), JobState::Queued);
    assert!(store.any_queued(Queue::Interactive).await.unwrap());
    assert_eq!(store.oldest_queued_ms(Queue::Interactive).await.unwrap(), Some(created_ms));
    let claimed = claim(&store, "other").await.unwrap();
    assert_eq!((claimed.id, claimed.epoch), (id, FIRST_EPOCH + 1));
    assert!(store.complete(id, FIRST_EPOCH).await.is_err());
    store.close().await.unwrap();
    let again = Store::open(dir.path()).await.unwrap();
    assert_eq!(again.requeue_all_leased().await.unwrap(), 1, "leases end with the process");
}
