//! Kinds of leased jobs. Claims, heartbeats, releases and the loss of leases are the same for all
//! kinds, see [`lease`](super::lease). A kind claims its jobs and stores their return.

use brood_protocol::{JobId, Ticket};
use brood_storage::StorageError;
use tokio::sync::Notify;

use super::Dispatch;
use super::queue::{PendingGrant, WaitingWorkers};
use super::table::{Lease, LeaseTable};
use crate::problem::ApiError;
use crate::state::{App, AppState};

/// Kind of leased job.
pub trait JobKind: Sized + 'static {
    /// Name in logs.
    const NAME: &'static str;
    /// Proof of a lease.
    type Ticket: Ticket;
    /// Data that the server keeps during a lease.
    type Payload: Send + 'static;
    /// Message that grants a lease.
    type Grant: Send + 'static;

    /// Returns the leases of this kind.
    fn jobs(dispatch: &Dispatch) -> &Jobs<Self>;

    /// Returns the job of a lease.
    fn job(lease: &LeaseOf<Self>) -> JobId;

    /// True if a job of this kind is queued.
    fn any_queued(app: &AppState) -> impl Future<Output = Result<bool, StorageError>> + Send;

    /// Claims the next job and grants its lease. Jobs that need no worker or cannot be decoded end
    /// here.
    fn claim(
        app: &App,
        worker: &str,
    ) -> impl Future<Output = Result<Option<PendingGrant<Self>>, ApiError>> + Send;

    /// Stores the return of an unfinished job, whose lease has ended, to its queue. If its worker
    /// died, the job may fail instead: a render job after three deaths, a search after three
    /// consecutive ones.
    fn on_returned(
        app: &AppState,
        lease: LeaseOf<Self>,
        worker_died: bool,
    ) -> impl Future<Output = ()> + Send;
}

/// Lease of one kind of job.
pub type LeaseOf<K> = Lease<<K as JobKind>::Ticket, <K as JobKind>::Payload>;

/// Leases of one kind of job, and the workers that wait for one.
pub struct Jobs<K: JobKind> {
    /// The leases.
    pub leases: LeaseTable<K::Ticket, K::Payload>,
    /// Notified once per queued job.
    pub notify: Notify,
    /// Waiting workers.
    pub waiting: WaitingWorkers<K>,
}

impl<K: JobKind> Jobs<K> {
    /// Creates an empty table without waiting workers.
    pub fn new() -> Self {
        Self { leases: LeaseTable::new(), notify: Notify::new(), waiting: WaitingWorkers::new() }
    }
}
