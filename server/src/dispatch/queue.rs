//! Workers that found no job and wait for one: a job that is made while they wait is put into their hands.

use std::collections::VecDeque;
use std::sync::{Mutex, MutexGuard};

use brood_protocol::{LeaseGrant, LeaseTicket};
use tokio::sync::oneshot;

use crate::state::App;

/// A lease on its way to a worker. Given back unless it was handed over: a request that is given up in the middle loses
/// no job.
pub struct Handed {
    app: App,
    grant: Option<LeaseGrant>,
    ticket: LeaseTicket,
}

impl Handed {
    /// Of a lease that was just granted.
    pub fn new(app: App, grant: LeaseGrant) -> Self {
        Self { app, ticket: grant.ticket, grant: Some(grant) }
    }

    /// The lease, which from now on is the worker's to keep.
    pub fn take(mut self) -> LeaseGrant {
        self.grant.take().expect("taken once, by value")
    }
}

impl Drop for Handed {
    fn drop(&mut self) {
        if self.grant.is_none() {
            return;
        }
        if let Some(lease) = self.app.dispatch.table.end(&self.ticket) {
            let app = self.app.clone();
            self.app.tasks.spawn(async move { app.put_back(&lease, false).await });
        }
    }
}

/// A worker that waits.
pub struct Waiting {
    /// Its name.
    pub worker: String,
    /// Where it waits.
    pub place: oneshot::Sender<Handed>,
}

/// The workers that wait, longest first.
#[derive(Default)]
pub struct Waiters {
    waiting: Mutex<VecDeque<Waiting>>,
}

impl Waiters {
    /// Joins at the end; who drops or closes the receiver has left.
    pub fn join(&self, worker: &str) -> oneshot::Receiver<Handed> {
        let (place, receiver) = oneshot::channel();
        let mut waiting = self.lock();
        // Those who have left are forgotten here, so that the list is no longer than the requests that are open.
        waiting.retain(|one| !one.place.is_closed());
        waiting.push_back(Waiting { worker: worker.to_owned(), place });
        receiver
    }

    /// Takes the one who has waited longest.
    pub fn next(&self) -> Option<Waiting> {
        let mut waiting = self.lock();
        std::iter::from_fn(|| waiting.pop_front()).find(|one| !one.place.is_closed())
    }

    fn lock(&self) -> MutexGuard<'_, VecDeque<Waiting>> {
        self.waiting.lock().expect("nothing panics under this lock")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn longest_waiting_worker_that_is_still_there_comes_next() {
        let waiters = Waiters::default();
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
    fn list_forgets_those_who_left() {
        let waiters = Waiters::default();
        for _ in 0..100 {
            drop(waiters.join("impatient"));
        }
        assert!(waiters.lock().len() <= 1);
    }
}
