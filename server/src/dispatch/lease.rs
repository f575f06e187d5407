//! Leases of all kinds of jobs: claims, and the return of jobs whose lease is lost.

use std::sync::Arc;
use std::time::Duration;

use brood_storage::{EndedLease, LostLeases, StorageError};
use tokio::time::Instant;

use super::kind::JobKind;
use crate::limit;
use crate::problem::ApiError;

/// Longest error text of a worker that is stored.
const REASON_CHARS: usize = 500;

/// Waits for a job of a queue; `None` if there is none in the requested time.
///
/// # Errors
/// [`ApiError`] if the store fails.
pub async fn claim_lease<K: JobKind>(
    kind: &Arc<K>,
    worker: &str,
    queue: K::Queue,
    wait_ms: u32,
) -> Result<Option<K::Grant>, ApiError> {
    let wait = limit::LEASE_WAIT.min(Duration::from_millis(wait_ms.into()));
    let deadline = Instant::now() + wait;
    let (jobs, lane) = (kind.jobs(), kind.lane(queue));
    loop {
        let notified = lane.notify.notified();
        if jobs.stopping.is_cancelled() {
            return Ok(None);
        }
        if kind.any_queued(queue).await? {
            let (kind, worker) = (kind.clone(), worker.to_owned());
            // Runs in a separate task: a claim that was written must become a lease even if the
            // worker disconnects.
            let claim = jobs.tasks.spawn(async move {
                let claimed = kind.claim(&worker, queue).await;
                if let Ok(Some(_)) = claimed {
                    // Notifications coalesce: wake another waiter, as more jobs may be queued.
                    kind.lane(queue).notify.notify_one();
                }
                claimed
            });
            let claimed = claim.await.map_err(|error| ApiError::internal(error.to_string()))?;
            if let Some(pending) = claimed? {
                return Ok(Some(pending.take()));
            }
        }
        let look = jobs.poll.map_or(deadline, |poll| deadline.min(Instant::now() + poll));
        let mut receiver = lane.waiting.join(worker);
        tokio::select! {
            biased;
            pending = &mut receiver => if let Ok(pending) = pending {
                return Ok(Some(pending.take()));
            },
            () = notified => {}
            () = tokio::time::sleep_until(look) => {}
            () = jobs.stopping.cancelled() => {}
        }
        // A job may have arrived while another branch ended the wait.
        receiver.close();
        if let Ok(pending) = receiver.try_recv() {
            return Ok(Some(pending.take()));
        }
        if Instant::now() >= deadline {
            return Ok(None);
        }
    }
}

/// As [`try_end_leases`], but logs an error.
pub async fn end_leases<K: JobKind>(kind: &K, lost: LostLeases) -> Vec<String> {
    match try_end_leases(kind, lost).await {
        Ok(workers) => workers,
        Err(error) => {
            let reason = &error.problem().detail;
            tracing::error!(kind = K::NAME, reason, "cannot end the leases of lost workers");
            Vec::new()
        }
    }
}

/// Ends leases and requeues their jobs. Returns the names of the workers that held them.
///
/// # Errors
/// [`ApiError`] if the store fails.
pub async fn try_end_leases<K: JobKind>(
    kind: &K,
    lost: LostLeases,
) -> Result<Vec<String>, ApiError> {
    let message = match lost {
        LostLeases::Expired => Some("a lease has expired"),
        LostLeases::OfWorker(_) => Some("a worker died while running a job"),
        LostLeases::OfStopped(_) | LostLeases::OfProcess => None,
    };
    let ended = kind.end_lost(lost).await?;
    for EndedLease { id, worker, .. } in &ended {
        if let Some(message) = message {
            tracing::warn!(kind = K::NAME, job = %id, worker, "{message}");
        }
    }
    Ok(ended.into_iter().map(|lease| lease.worker).collect())
}

/// Time to live of a lease, in milliseconds.
pub(super) fn lease_ms(ttl: Duration) -> u32 {
    u32::try_from(ttl.as_millis()).expect("a lease is seconds long")
}

/// Error for a lease that is not valid any more.
pub(super) fn stale() -> ApiError {
    ApiError::stale_lease("the lease has expired, or another worker finished the job")
}

/// Returns [`stale`] if a lease in the store is not valid any more, or its job is removed.
pub(super) fn stale_or(error: StorageError) -> ApiError {
    match error {
        StorageError::Conflict { .. } | StorageError::NotFound => stale(),
        error => error.into(),
    }
}

/// Returns the start of a worker's error text.
pub(super) fn shortened(reason: &str) -> String {
    reason.chars().take(REASON_CHARS).collect()
}
