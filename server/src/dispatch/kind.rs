//! Kinds of leased jobs. Claims, heartbeats, releases and the loss of leases are the same for all
//! kinds, see [`lease`](super::lease). A kind is the service that owns the jobs: it claims them and
//! stores their return.

use std::sync::Arc;

use brood_protocol::{JobId, Ticket};
use brood_storage::StorageError;
use tokio::sync::Notify;
use tokio_util::sync::CancellationToken;
use tokio_util::task::TaskTracker;

use super::queue::WaitingWorkers;
use super::table::{Lease, LeaseTable};
use crate::problem::ApiError;

/// Kind of leased job.
pub trait JobKind: Sized + Send + Sync + 'static {
    /// Name in logs.
    const NAME: &'static str;
    /// Proof of a lease.
    type Ticket: Ticket;
    /// Data that the server keeps during a lease.
    type Payload: Send + 'static;
    /// Message that grants a lease.
    type Grant: Send + 'static;
    /// Name of a queue, if jobs of this kind wait in several; a worker waits for jobs of one.
    type Queue: Copy + Send + Sync + 'static;

    /// Returns the leases of this kind.
    fn jobs(&self) -> &Jobs<Self>;

    /// Returns the job of a lease.
    fn job(lease: &LeaseOf<Self>) -> JobId;

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

    /// Returns an unfinished job, whose lease has ended, to its queue. If its worker was lost, the
    /// job may fail instead: a render job after three deaths or ten expired leases, a search after
    /// three consecutive losses.
    fn on_returned(
        &self,
        lease: LeaseOf<Self>,
        returned: Returned,
    ) -> impl Future<Output = ()> + Send;
}

/// Reason for the return of an unfinished job.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Returned {
    /// The worker gave the job back, or never got it.
    Released,
    /// The lease expired: the worker was stopped, cut off or has died.
    Expired,
    /// The worker has died, or sent what is no picture.
    Died,
}

impl Returned {
    /// True if the worker may have been lost because of the job.
    pub fn is_loss(self) -> bool {
        self != Self::Released
    }
}

/// Lease of one kind of job.
pub type LeaseOf<K> = Lease<<K as JobKind>::Ticket, <K as JobKind>::Payload>;

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

/// Leases of one kind of job.
pub struct Jobs<K: JobKind> {
    /// The leases.
    pub leases: LeaseTable<K::Ticket, K::Payload>,
    /// Tasks that may outlive their request.
    pub tasks: TaskTracker,
    /// Cancelled when the server begins to stop.
    pub stopping: CancellationToken,
}

impl<K: JobKind> Jobs<K> {
    /// Creates an empty table of leases.
    pub fn new(tasks: &TaskTracker, stopping: &CancellationToken) -> Self {
        let leases = LeaseTable::default();
        Self { leases, tasks: tasks.clone(), stopping: stopping.clone() }
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
        if let Some(lease) = self.kind.jobs().leases.end(&self.ticket) {
            let kind = self.kind.clone();
            self.kind
                .jobs()
                .tasks
                .spawn(async move { kind.on_returned(lease, Returned::Released).await });
        }
    }
}
