//! Leases of all kinds of jobs: claims, heartbeats, releases, and the return of jobs whose lease is
//! lost.

use std::sync::Arc;
use std::time::Duration;

use tokio::time::Instant;

use super::kind::{JobKind, Returned};
use super::table::Renewed;
use crate::limit;
use crate::problem::ApiError;

/// Longest error text of a worker that is stored.
const REASON_CHARS: usize = 500;

/// Reason for ending leases.
#[derive(Debug, Clone, Copy)]
pub enum LeaseEnd<'a> {
    /// Ends the leases that have expired.
    Expired,
    /// Ends the leases of a worker that has died, before they expire.
    Death(&'a str),
    /// Ends all leases: the server stops.
    Shutdown,
}

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
        let mut receiver = lane.waiting.join(worker);
        tokio::select! {
            biased;
            pending = &mut receiver => if let Ok(pending) = pending {
                return Ok(Some(pending.take()));
            },
            () = notified => {}
            () = tokio::time::sleep_until(deadline) => {}
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

/// Renews a lease.
///
/// # Errors
/// 409 if the lease is not valid any more.
pub fn renew_lease<K: JobKind>(kind: &K, ticket: &K::Ticket) -> Result<Renewed, ApiError> {
    kind.jobs().leases.renew(ticket).ok_or_else(stale)
}

/// Returns an unfinished job to its queue.
///
/// # Errors
/// 409 if the lease is not valid any more.
pub async fn release_lease<K: JobKind>(kind: &K, ticket: &K::Ticket) -> Result<(), ApiError> {
    let lease = kind.jobs().leases.end(ticket).ok_or_else(stale)?;
    kind.on_returned(lease, Returned::Released).await;
    Ok(())
}

/// Ends leases and requeues their jobs. Returns the names of the workers that held them.
pub async fn end_leases<K: JobKind>(kind: &K, end: LeaseEnd<'_>) -> Vec<String> {
    let leases = &kind.jobs().leases;
    let (ended, (returned, lost)) = match end {
        LeaseEnd::Expired => {
            (leases.end_expired(), (Returned::Expired, Some("a lease has expired")))
        }
        LeaseEnd::Death(worker) => (
            leases.end_those_of(worker),
            (Returned::Died, Some("a worker died while running a job")),
        ),
        LeaseEnd::Shutdown => (leases.end_all(), (Returned::Released, None)),
    };
    let mut workers = Vec::with_capacity(ended.len());
    for lease in ended {
        workers.push(lease.worker.clone());
        if let Some(message) = lost {
            let (job, worker) = (K::job(&lease), &lease.worker);
            tracing::warn!(kind = K::NAME, %job, worker, "{message}");
        }
        kind.on_returned(lease, returned).await;
    }
    workers
}

/// Time to live of a lease, in milliseconds.
pub(super) fn lease_ms(ttl: Duration) -> u32 {
    u32::try_from(ttl.as_millis()).expect("a lease is seconds long")
}

/// Error for a lease that is not valid any more.
pub(super) fn stale() -> ApiError {
    ApiError::stale_lease("the lease has expired, or another worker finished the job")
}

/// Returns the start of a worker's error text.
pub(super) fn shortened(reason: &str) -> String {
    reason.chars().take(REASON_CHARS).collect()
}
