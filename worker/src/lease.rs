//! Leases of a worker, the same for all kinds of jobs: heartbeats, and calls with retries. A kind
//! defines its requests and runs its jobs; [`claim`](crate::claim) requests them.

use std::time::Duration;

use brood_protocol::{ClaimRequest, ClientError, JobId, Ticket, WorkerClient};
use tokio::time::Instant;
use tokio_util::sync::CancellationToken;

use crate::backoff::Backoff;

/// Number of consecutive failures after which a warning is logged.
pub(crate) const WARN_AFTER_FAILURES: u32 = 3;
/// Interval of the renewals of long jobs.
pub(crate) const HEARTBEAT: Duration = Duration::from_secs(5);

/// Time until a worker requests a job again where the server or the last job was of another
/// version.
pub(crate) const OTHER_VERSION_WAIT: Duration = Duration::from_secs(5);

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
    /// The job is returned to its queue for a worker of another version.
    OtherVersion(String),
}

impl Interrupted {
    /// The job has `what`, which this worker does not know.
    pub(crate) fn unknown(what: &str, name: &str) -> Self {
        Self::OtherVersion(format!("the job is for a worker of another version: {what} {name:?}"))
    }

    /// Classifies the error of a call: a rejected request fails the job, an unreachable or broken
    /// server does not. `what` names the call.
    pub(crate) fn by(what: &str, error: ClientError) -> Self {
        match error {
            ClientError::Stale => Self::Stale,
            error @ ClientError::OtherVersion(_) => Self::OtherVersion(error.to_string()),
            ClientError::Wire(error) => Self::Failed(error.to_string()),
            ClientError::Status { status, detail } if status.is_client_error() => {
                Self::Failed(format!("cannot {what} ({status}): {detail}"))
            }
            error => Self::Release(error.to_string()),
        }
    }
}

/// Keeps the slot of a job that was returned for a worker of another version, so that this worker
/// does not claim it again at once.
pub(crate) async fn leave_to_others(shutdown: &CancellationToken) {
    let _ = shutdown.run_until_cancelled(tokio::time::sleep(OTHER_VERSION_WAIT)).await;
}

/// Kind of leased job, with the resources that a worker shares among its jobs.
pub(crate) trait JobKind: Clone + Send + Sync + 'static {
    /// Interval between renewals of a lease. The server refuses a renewal if the job is no longer
    /// wanted.
    const HEARTBEAT: Duration;
    /// Request for a job.
    type Request: ClaimRequest;
    /// Proof of a lease.
    type Ticket: Ticket;

    /// Returns the kind with another client: that of the server which grants the jobs.
    fn at(self, client: WorkerClient) -> Self;

    /// Name in logs.
    fn name(&self) -> &'static str;

    /// Number of concurrent jobs of a worker.
    fn concurrent(&self) -> usize;

    /// Returns a request for a job, which the server may answer after this time.
    fn request(&self, worker: &str, wait_ms: u32) -> Self::Request;

    /// Returns the job and the ticket of a grant.
    fn lease(grant: &<Self::Request as ClaimRequest>::Grant) -> (JobId, Self::Ticket);

    /// Runs one job. Errors are handled here: the lease is returned or expires.
    fn run(
        self,
        grant: <Self::Request as ClaimRequest>::Grant,
    ) -> impl Future<Output = ()> + Send + 'static;
}

/// Calls `renew` periodically. Returns when the lease is lost: the server refuses to renew it, or
/// has not answered for the duration of a lease, `ttl`. Other errors are answers: a server that
/// cannot write its database ends no lease, and renews this one later.
pub(crate) async fn renew_lease<K: JobKind, F>(ttl: Duration, mut renew: impl FnMut() -> F)
where
    F: Future<Output = Result<(), ClientError>>,
{
    let period = K::HEARTBEAT.min(ttl / 4).max(Duration::from_millis(50));
    let mut answered = Instant::now();
    loop {
        tokio::time::sleep(period).await;
        // Checked before the attempt: if this process was stopped for longer than a lease, the
        // server may have been stopped, too.
        let is_last = answered.elapsed() >= ttl;
        match tokio::time::timeout(period.max(ttl / 4), renew()).await {
            Ok(Ok(())) => answered = Instant::now(),
            Ok(Err(ClientError::Stale)) => return,
            Ok(Err(ClientError::Status { status, .. })) if status.as_u16() == 404 => return,
            Ok(Err(error)) if !error.is_unanswered() => {
                answered = Instant::now();
                tracing::debug!(%error, "heartbeat refused");
            }
            Ok(Err(_)) | Err(_) if is_last => {
                tracing::info!(?ttl, "the server has not answered for the duration of a lease");
                return;
            }
            // Not fatal: if the server was only slow, the next heartbeat arrives in time; if it
            // restarted, that heartbeat returns `Stale`.
            Ok(Err(error)) => tracing::debug!(%error, "heartbeat failed"),
            Err(_) => tracing::debug!("heartbeat not answered"),
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
            ClientError::Transport(_) | ClientError::Gateway(_) | ClientError::Busy => true,
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
