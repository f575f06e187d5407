//! Leases of a worker, the same for all kinds of jobs: claims, heartbeats, calls with retries, and
//! shutdown. A kind defines its requests and runs its jobs.

use std::sync::Arc;
use std::time::Duration;

use brood_protocol::{ClaimRequest, ClientError, JobId, WorkerClient};
use tokio::sync::Semaphore;
use tokio::task::JoinSet;
use tokio::time::Instant;
use tokio_util::sync::CancellationToken;

use crate::backoff::Backoff;

/// Number of consecutive failures after which a warning is logged.
const WARN_AFTER_FAILURES: u32 = 3;
const LONG_POLL: Duration = Duration::from_secs(20);
/// Interval of the renewals of long jobs.
pub(crate) const HEARTBEAT: Duration = Duration::from_secs(5);
/// Time for returning leases at shutdown. Leases not returned by then expire.
const SHUTDOWN_GRACE: Duration = Duration::from_secs(3);

/// Error that ends a worker.
#[derive(Debug, thiserror::Error)]
pub enum WorkerError {
    /// The token is missing, unknown or of another scope.
    #[error("{0}")]
    Refused(ClientError),
    /// The URL of the server is invalid, or the HTTP client cannot be set up.
    #[error("cannot set up the connection to the server: {0}")]
    Client(ClientError),
    /// A thread could not be started.
    #[error("cannot start the render threads: {0}")]
    Threads(#[from] std::io::Error),
}

/// Reason for ending a job without its result.
#[derive(Debug)]
pub(crate) enum Interrupted {
    /// The lease is no longer valid; nothing is reported.
    Stale,
    /// Permanent failure.
    Failed(String),
    /// The job is returned to its queue for another worker.
    Release(String),
}

impl Interrupted {
    /// Classifies the error of a call: a rejected request fails the job, an unreachable or broken
    /// server does not. `what` names the call.
    pub(crate) fn by(what: &str, error: ClientError) -> Self {
        match error {
            ClientError::Stale => Self::Stale,
            ClientError::Wire(error) => Self::Failed(error.to_string()),
            ClientError::Status { status, detail } if status.is_client_error() => {
                Self::Failed(format!("cannot {what} ({status}): {detail}"))
            }
            error => Self::Release(error.to_string()),
        }
    }
}

/// Kind of leased job, with the resources that a worker shares among its jobs.
pub(crate) trait JobKind: Clone + Send + Sync + 'static {
    /// Interval between renewals of a lease. The server refuses a renewal if the job is no longer
    /// wanted.
    const HEARTBEAT: Duration;
    /// Request for a job.
    type Request: ClaimRequest;

    /// Name in logs.
    fn name(&self) -> &'static str;

    /// Number of concurrent jobs of a worker.
    fn concurrent(&self) -> usize;

    /// Returns a request for a job, which the server may answer after this time.
    fn request(&self, worker: &str, wait_ms: u32) -> Self::Request;

    /// Runs one job. Errors are handled here: the lease is returned or expires.
    fn run(
        self,
        grant: <Self::Request as ClaimRequest>::Grant,
    ) -> impl Future<Output = ()> + Send + 'static;
}

/// Leases and runs jobs until `shutdown` is cancelled or the server rejects the token. Then cancels
/// `shutdown`, which the jobs observe, and waits until they have returned their leases.
///
/// # Errors
/// Returns [`WorkerError::Refused`] if the server rejects the token.
pub(crate) async fn run_jobs<K: JobKind>(
    client: &WorkerClient,
    worker: &str,
    kind: K,
    shutdown: CancellationToken,
) -> Result<(), WorkerError> {
    let (mut jobs, name) = (JoinSet::new(), kind.name());
    let result = tokio::select! {
        result = claim(client, worker, kind, &mut jobs) => result,
        () = shutdown.cancelled() => Ok(()),
    };
    shutdown.cancel();
    let finished = async { while jobs.join_next().await.is_some() {} };
    if tokio::time::timeout(SHUTDOWN_GRACE, finished).await.is_err() {
        tracing::warn!(kind = name, "some leases were not returned in time; they will expire");
    }
    result
}

/// Leases jobs and spawns a task for each. Returns only if the server rejects the token.
async fn claim<K: JobKind>(
    client: &WorkerClient,
    worker: &str,
    kind: K,
    jobs: &mut JoinSet<()>,
) -> Result<(), WorkerError> {
    let slots = Arc::new(Semaphore::new(kind.concurrent()));
    let wait_ms = u32::try_from(LONG_POLL.as_millis()).expect("seconds");
    let mut backoff = Backoff::default();
    tracing::info!(server = client.server(), worker, kind = kind.name(), "requesting jobs");
    loop {
        while jobs.try_join_next().is_some() {}
        let slot = slots.clone().acquire_owned().await.expect("the semaphore is never closed");
        match client.claim(&kind.request(worker, wait_ms)).await {
            Ok(grant) => {
                if backoff.failures() >= WARN_AFTER_FAILURES {
                    tracing::info!(kind = kind.name(), "the server responds again");
                }
                backoff.reset();
                if let Some(grant) = grant {
                    let running = kind.clone().run(grant);
                    jobs.spawn(async move {
                        running.await;
                        drop(slot);
                    });
                }
            }
            Err(error @ ClientError::Refused(_)) => return Err(WorkerError::Refused(error)),
            Err(error) => {
                let (wait, kind) = (backoff.next(), kind.name());
                // A single failure is normal while a server restarts. Warn once if failures
                // continue.
                if backoff.failures() == WARN_AFTER_FAILURES {
                    tracing::warn!(kind, %error, "cannot lease jobs from the server; retrying");
                } else {
                    tracing::debug!(kind, %error, "no job leased");
                }
                tokio::time::sleep(wait).await;
            }
        }
    }
}

/// Calls `renew` periodically. Returns when the lease is lost.
pub(crate) async fn renew_lease<K: JobKind, F>(ttl: Duration, mut renew: impl FnMut() -> F)
where
    F: Future<Output = Result<(), ClientError>>,
{
    let period = K::HEARTBEAT.min(ttl / 4).max(Duration::from_millis(50));
    loop {
        tokio::time::sleep(period).await;
        match renew().await {
            Ok(()) => {}
            Err(ClientError::Stale) => return,
            Err(ClientError::Status { status, .. }) if status.as_u16() == 404 => return,
            // Not fatal: if the server was only slow, the next heartbeat arrives in time; if it
            // restarted, that heartbeat returns `Stale`.
            Err(error) => tracing::debug!(%error, "heartbeat failed"),
        }
    }
}

/// Rule for repeating a failed call.
#[derive(Debug, Clone, Copy)]
pub(crate) struct RetryPolicy {
    /// Time after which the call is not repeated any more; `None` for no limit.
    pub(crate) limit: Option<Duration>,
    /// True to repeat after 5xx answers other than 503, too.
    pub(crate) repeats_server_errors: bool,
}

impl RetryPolicy {
    fn repeats(self, error: &ClientError) -> bool {
        match error {
            ClientError::Transport(_) | ClientError::Busy => true,
            ClientError::Status { status, .. } => {
                self.repeats_server_errors && status.is_server_error()
            }
            _ => false,
        }
    }
}

/// Calls the server until it answers, with growing delays. `what` names the call in logs.
///
/// # Errors
/// Returns the last error if the policy or `shutdown` ends the attempts.
pub(crate) async fn send_with_retry<T, F>(
    policy: RetryPolicy,
    (job, what): (JobId, &str),
    shutdown: &CancellationToken,
    mut call: impl FnMut() -> F,
) -> Result<T, ClientError>
where
    F: Future<Output = Result<T, ClientError>>,
{
    let deadline = policy.limit.map(|limit| Instant::now() + limit);
    let mut backoff = Backoff::default();
    loop {
        let error = match call().await {
            Ok(answer) => return Ok(answer),
            Err(error) => error,
        };
        let wait = backoff.next();
        let is_late = deadline.is_some_and(|deadline| Instant::now() + wait > deadline);
        if is_late || !policy.repeats(&error) {
            return Err(error);
        }
        if backoff.failures() == WARN_AFTER_FAILURES {
            tracing::warn!(%job, %error, "cannot {what}; retrying");
        }
        tokio::select! {
            () = tokio::time::sleep(wait) => {}
            () = shutdown.cancelled() => return Err(error),
        }
    }
}
