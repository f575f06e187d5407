//! Workers that wait for a job. A new render job is granted to a waiting worker directly.

use std::collections::VecDeque;
use std::sync::{Mutex, MutexGuard};

use tokio::sync::oneshot;

/// Worker that waits for a job.
pub struct WaitingWorker<G> {
    /// Name of the worker.
    pub worker: String,
    /// Channel that receives the grant.
    pub sender: oneshot::Sender<G>,
}

/// Queue of waiting workers, longest first.
pub struct WaitingWorkers<G> {
    waiting: Mutex<VecDeque<WaitingWorker<G>>>,
}

impl<G> WaitingWorkers<G> {
    /// Creates an empty queue.
    pub fn new() -> Self {
        Self { waiting: Mutex::new(VecDeque::new()) }
    }

    /// Adds a worker at the end; it leaves by dropping or closing the receiver.
    pub fn join(&self, worker: &str) -> oneshot::Receiver<G> {
        let (sender, receiver) = oneshot::channel();
        let mut waiting = self.lock();
        // Removing closed entries keeps the queue no longer than the number of open requests.
        waiting.retain(|one| !one.sender.is_closed());
        waiting.push_back(WaitingWorker { worker: worker.to_owned(), sender });
        receiver
    }

    /// Removes and returns the worker that has waited longest.
    pub fn next(&self) -> Option<WaitingWorker<G>> {
        let mut waiting = self.lock();
        std::iter::from_fn(|| waiting.pop_front()).find(|one| !one.sender.is_closed())
    }

    fn lock(&self) -> MutexGuard<'_, VecDeque<WaitingWorker<G>>> {
        self.waiting.lock().expect("nothing panics under this lock")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn next_returns_the_longest_waiting_worker_that_has_not_left() {
        let waiters = WaitingWorkers::<()>::new();
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
        let waiters = WaitingWorkers::<()>::new();
        for _ in 0..100 {
            drop(waiters.join("impatient"));
        }
        assert!(waiters.lock().len() <= 1);
    }
}
