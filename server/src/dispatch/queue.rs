//! Grants on their way to a worker, and workers that wait for one. A new render job is granted to a
//! waiting worker directly.

use std::collections::VecDeque;
use std::sync::{Mutex, MutexGuard};

use tokio::sync::oneshot;

use super::kind::JobKind;
use crate::state::App;

/// Lease on its way to a worker. Unless taken, it is returned on drop, so that a cancelled request
/// loses no job.
pub struct PendingGrant<K: JobKind> {
    app: App,
    grant: Option<K::Grant>,
    ticket: K::Ticket,
}

impl<K: JobKind> PendingGrant<K> {
    /// Wraps a new lease.
    pub fn new(app: App, ticket: K::Ticket, grant: K::Grant) -> Self {
        Self { app, ticket, grant: Some(grant) }
    }

    /// Returns the proof of the lease.
    pub fn ticket(&self) -> K::Ticket {
        self.ticket
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
        if let Some(lease) = K::jobs(&self.app.dispatch).leases.end(&self.ticket) {
            let app = self.app.clone();
            self.app.tasks.spawn(async move { K::on_returned(&app, lease, false).await });
        }
    }
}

/// Worker that waits for a job.
pub struct WaitingWorker<K: JobKind> {
    /// Name of the worker.
    pub worker: String,
    /// Channel that receives the lease.
    pub sender: oneshot::Sender<PendingGrant<K>>,
}

/// Queue of waiting workers, longest first.
pub struct WaitingWorkers<K: JobKind> {
    waiting: Mutex<VecDeque<WaitingWorker<K>>>,
}

impl<K: JobKind> WaitingWorkers<K> {
    /// Creates an empty queue.
    pub fn new() -> Self {
        Self { waiting: Mutex::new(VecDeque::new()) }
    }

    /// Adds a worker at the end; it leaves by dropping or closing the receiver.
    pub fn join(&self, worker: &str) -> oneshot::Receiver<PendingGrant<K>> {
        let (sender, receiver) = oneshot::channel();
        let mut waiting = self.lock();
        // Removing closed entries keeps the queue no longer than the number of open requests.
        waiting.retain(|one| !one.sender.is_closed());
        waiting.push_back(WaitingWorker { worker: worker.to_owned(), sender });
        receiver
    }

    /// Removes and returns the worker that has waited longest.
    pub fn next(&self) -> Option<WaitingWorker<K>> {
        let mut waiting = self.lock();
        std::iter::from_fn(|| waiting.pop_front()).find(|one| !one.sender.is_closed())
    }

    fn lock(&self) -> MutexGuard<'_, VecDeque<WaitingWorker<K>>> {
        self.waiting.lock().expect("nothing panics under this lock")
    }
}

#[cfg(test)]
mod tests {
    use super::super::render_job::Render;
    use super::*;

    #[test]
    fn next_returns_the_longest_waiting_worker_that_has_not_left() {
        let waiters = WaitingWorkers::<Render>::new();
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
        let waiters = WaitingWorkers::<Render>::new();
        for _ in 0..100 {
            drop(waiters.join("impatient"));
        }
        assert!(waiters.lock().len() <= 1);
    }
}
