//! Kinds of leased jobs. Claims, heartbeats, releases and the loss of leases are the same for all
//! kinds, see [`lease`](super::lease). A kind is the service that owns the jobs: it claims them,
//! keeps their leases and stores their return.

use std::sync::Arc;
use std::time::Duration;

use brood_protocol::Ticket;
use brood_storage::{EndedLease, LostLeases, StorageError};
use http::StatusCode;
use tokio::sync::Notify;
use tokio_util::sync::CancellationToken;
use tokio_util::task::TaskTracker;

use super::queue::WaitingWorkers;
use crate::problem::ApiError;

/// Kind of leased job.
pub trait JobKind: Sized + Send + Sync + 'static {
    /// Name in logs.
    const NAME: &'static str;
    /// Proof of a lease.
    type Ticket: Ticket;
    /// Message that grants a lease.
    type Grant: Send + 'static;
    /// Name of a queue, if jobs of this kind wait in several; a worker waits for jobs of one.
    type Queue: Copy + Send + Sync + 'static;

    /// Returns the tasks of this kind.
    fn jobs(&self) -> &Jobs;

    /// Returns the workers that wait for jobs of a queue.
    fn lane(&self, queue: Self::Queue) -> &Lane<Self>;

    /// True if a job waits in a queue.
    fn any_queued(
        &self,
        queue: Self::Queue,
    ) -> impl Future<Output = Result<bool, StorageError>> + Send;

    /// Claims the next job of a queue and grants its lease. Jobs that need no worker or cannot be
    /// decoded end here.
    fn claim(
        self: &Arc<Self>,
        worker: &str,
        queue: Self::Queue,
    ) -> impl Future<Output = Result<Option<PendingGrant<Self>>, ApiError>> + Send;

    /// Ends a lease and returns its unfinished job to its queue.
    ///
    /// # Errors
    /// 409 if the lease is not valid any more.
    fn give_back(&self, ticket: &Self::Ticket)
    -> impl Future<Output = Result<(), ApiError>> + Send;

    /// Ends leases and returns their jobs to their queues. If workers were lost, a job may fail
    /// instead: a render job after three deaths or ten expired leases, others after three
    /// consecutive losses. Returns the leases.
    fn end_lost(
        &self,
        lost: LostLeases,
    ) -> impl Future<Output = Result<Vec<EndedLease>, ApiError>> + Send;
}

/// Workers that wait for jobs of one queue.
pub struct Lane<K: JobKind> {
    /// Notified once per queued job.
    pub notify: Notify,
    /// Waiting workers.
    pub waiting: WaitingWorkers<PendingGrant<K>>,
}

impl<K: JobKind> Default for Lane<K> {
    fn default() -> Self {
        Self { notify: Notify::new(), waiting: WaitingWorkers::new() }
    }
}

/// Tasks of one kind of job.
pub struct Jobs {
    /// Tasks that may outlive their request.
    pub tasks: TaskTracker,
    /// Cancelled when the server begins to stop.
    pub stopping: CancellationToken,
    /// Interval at which waiting workers look for jobs without a notification, if other servers
    /// queue jobs, too.
    pub poll: Option<Duration>,
}

impl Jobs {
    /// Uses the tracker of tasks and the token of the server.
    pub fn new(tasks: &TaskTracker, stopping: &CancellationToken, poll: Option<Duration>) -> Self {
        Self { tasks: tasks.clone(), stopping: stopping.clone(), poll }
    }
}

/// Lease on its way to a worker. Unless taken, it is returned on drop, so that a cancelled request
/// loses no job.
pub struct PendingGrant<K: JobKind> {
    kind: Arc<K>,
    grant: Option<K::Grant>,
    ticket: K::Ticket,
}

impl<K: JobKind> PendingGrant<K> {
    /// Wraps a new lease.
    pub fn new(kind: &Arc<K>, ticket: K::Ticket, grant: K::Grant) -> Self {
        Self { kind: kind.clone(), ticket, grant: Some(grant) }
    }

    /// Returns the lease, which the worker must now renew.
    pub fn take(mut self) -> K::Grant {
        self.grant.take().expect("taken once, by value")
    }
}

impl<K: JobKind> Drop for PendingGrant<K> {
    fn drop(&mut self) {
        if self.grant.is_none() {
            return;
        }
        let (kind, ticket) = (self.kind.clone(), self.ticket);
        self.kind.jobs().tasks.spawn(async move {
            // 409 if the lease has ended meanwhile.
            if let Err(error) = kind.give_back(&ticket).await
                && error.status() != StatusCode::CONFLICT
            {
                let reason = &error.problem().detail;
                tracing::error!(kind = K::NAME, reason, "cannot requeue a job");
            }
        });
    }
}
