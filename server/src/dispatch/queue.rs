//! Workers that wait for a job. A new job is granted to one of them directly.

use std::collections::VecDeque;
use std::sync::{Mutex, MutexGuard};

use brood_protocol::{LeaseGrant, LeaseTicket};
use tokio::sync::oneshot;

use crate::state::App;

/// Lease on its way to a worker. Unless taken, it is returned on drop, so that a cancelled request
/// loses no job.
pub struct PendingGrant {
    app: App,
    grant: Option<LeaseGrant>,
    ticket: LeaseTicket,
}

impl PendingGrant {
    /// Wraps a new lease.
    pub fn new(app: App, grant: LeaseGrant) -> Self {
        Self { app, ticket: grant.ticket, grant: Some(grant) }
    }

    /// Returns the lease, which the worker must now renew.
    pub fn take(mut self) -> LeaseGrant {
        self.grant.take().expect("taken once, by value")
    }
}

impl Drop for PendingGrant {
    fn drop(&mut self) {
        if self.grant.is_none() {
            return;
        }
        if let Some(lease) = self.app.dispatch.table.end(&self.ticket) {
            let app = self.app.clone();
            self.app.tasks.spawn(async move { app.requeue_job(&lease, false).await });
        }
    }
}

/// Worker that waits for a job.
pub struct WaitingWorker {
    /// Name of the worker.
    pub worker: String,
    /// Channel that receives the lease.
    pub sender: oneshot::Sender<PendingGrant>,
}

/// Queue of waiting workers, longest first.
#[derive(Default)]
pub struct WaitingWorkers {
    waiting: Mutex<VecDeque<WaitingWorker>>,
}

impl WaitingWorkers {
    /// Adds a worker at the end; it leaves by dropping or closing the receiver.
    pub fn join(&self, worker: &str) -> oneshot::Receiver<PendingGrant> {
        let (sender, receiver) = oneshot::channel();
        let mut waiting = self.lock();
        // Removing closed entries keeps the queue no longer than the number of open requests.
        waiting.retain(|one| !one.sender.is_closed());
        waiting.push_back(WaitingWorker { worker: worker.to_owned(), sender });
        receiver
    }

    /// Removes and returns the worker that has waited longest.
    pub fn next(&self) -> Option<WaitingWorker> {
        let mut waiting = self.lock();
        std::iter::from_fn(|| waiting.pop_front()).find(|one| !one.sender.is_closed())
    }

    fn lock(&self) -> MutexGuard<'_, VecDeque<WaitingWorker>> {
        self.waiting.lock().expect("nothing panics under this lock")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn next_returns_the_longest_waiting_worker_that_has_not_left() {
        let waiters = WaitingWorkers::default();
        assert!(waiters.next().is_none());
        let gone = waiters.join("gone");
        let _first = waiters.join("first");
        let mut closed = waiters.join("closed");
        let _last = waiters.join("last");
        drop(gone);
        closed.close();
        let order: Vec<_> = std::iter::from_fn(|| waiters.next()).map(|one| one.worker).collect();
        assert_eq!(order, ["first", "last"]);
    }

    #[test]
    fn join_removes_workers_that_have_left() {
        let waiters = WaitingWorkers::default();
        for _ in 0..100 {
            drop(waiters.join("impatient"));
        }
        assert!(waiters.lock().len() <= 1);
    }
}
