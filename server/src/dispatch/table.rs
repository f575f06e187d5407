//! Leases of render jobs, on the monotonic clock: jumps of the wall clock expire no lease.

use std::collections::HashMap;
use std::sync::{Mutex, MutexGuard};
use std::time::Duration;

use brood_protocol::{LeaseTicket, Ticket};
use tokio::time::Instant;

use super::render_queue::QueuedJob;

/// Render job during its lease.
#[derive(Debug)]
pub struct LeasedRender {
    /// The job.
    pub job: QueuedJob,
    /// Time that it waited in the queue.
    pub queued: Duration,
}

/// Lease of a render job.
pub type RenderLease = Lease<LeaseTicket, LeasedRender>;

/// Job that is granted to a worker, with data that is kept during the lease.
#[derive(Debug)]
pub struct Lease<T, P> {
    /// Key and epoch.
    pub ticket: T,
    /// Name of the worker.
    pub worker: String,
    /// Time of the grant.
    pub granted: Instant,
    /// Data of the job.
    pub payload: P,
    /// Time to live without renewal.
    ttl: Duration,
    deadline: Instant,
}

/// Lease after a renewal.
#[derive(Debug, PartialEq, Eq)]
pub struct Renewed {
    /// Name of the worker.
    pub worker: String,
    /// Time since the grant.
    pub age: Duration,
}

/// Leases by their keys.
#[derive(Debug)]
pub struct LeaseTable<T: Ticket, P> {
    leases: Mutex<HashMap<T::Key, Lease<T, P>>>,
}

impl<T: Ticket, P> Default for LeaseTable<T, P> {
    fn default() -> Self {
        Self { leases: Mutex::default() }
    }
}

impl<T: Ticket, P> LeaseTable<T, P> {
    /// Grants a lease with a time to live; replaces an earlier one with the same key.
    pub fn grant(&self, ticket: T, worker: &str, payload: P, ttl: Duration) {
        let granted = Instant::now();
        let deadline = granted + ttl;
        let lease = Lease { ticket, worker: worker.to_owned(), granted, payload, ttl, deadline };
        self.lock().insert(ticket.key(), lease);
    }

    /// Renews a lease; `None` if it is not valid any more.
    pub fn renew(&self, ticket: &T) -> Option<Renewed> {
        let mut leases = self.lock();
        let lease = leases.get_mut(&ticket.key())?;
        if lease.ticket.epoch() != ticket.epoch() {
            return None;
        }
        lease.deadline = Instant::now() + lease.ttl;
        Some(Renewed { worker: lease.worker.clone(), age: lease.granted.elapsed() })
    }

    /// Reads a lease; `None` if it is not valid any more.
    pub fn read<R>(&self, ticket: &T, read: impl FnOnce(&Lease<T, P>) -> R) -> Option<R> {
        let leases = self.lock();
        let lease = leases.get(&ticket.key())?;
        (lease.ticket.epoch() == ticket.epoch()).then(|| read(lease))
    }

    /// Ends and returns a lease; `None` if it is not valid any more.
    pub fn end(&self, ticket: &T) -> Option<Lease<T, P>> {
        let mut leases = self.lock();
        let held = leases.get(&ticket.key())?.ticket.epoch() == ticket.epoch();
        if held { leases.remove(&ticket.key()) } else { None }
    }

    /// Removes and returns the expired leases.
    pub fn end_expired(&self) -> Vec<Lease<T, P>> {
        let now = Instant::now();
        self.end_where(|lease| lease.deadline <= now)
    }

    /// Removes and returns the leases of a worker.
    pub fn end_those_of(&self, worker: &str) -> Vec<Lease<T, P>> {
        self.end_where(|lease| lease.worker == worker)
    }

    /// Removes and returns all leases.
    pub fn end_all(&self) -> Vec<Lease<T, P>> {
        self.end_where(|_| true)
    }

    /// Number of leases.
    pub fn len(&self) -> usize {
        self.lock().len()
    }

    fn end_where(&self, ends: impl Fn(&Lease<T, P>) -> bool) -> Vec<Lease<T, P>> {
        self.lock().extract_if(|_, lease| ends(lease)).map(|(_, lease)| lease).collect()
    }

    fn lock(&self) -> MutexGuard<'_, HashMap<T::Key, Lease<T, P>>> {
        self.leases.lock().expect("nothing panics under this lock")
    }
}

#[cfg(test)]
mod tests {
    use brood_protocol::{JobId, LeaseId, LeaseTicket, SearchTicket};

    use super::*;
    use crate::limit;

    fn ticket(epoch: u64) -> SearchTicket {
        SearchTicket { job: JobId::fresh(), epoch }
    }

    #[tokio::test(start_paused = true)]
    async fn lease_expires_unless_it_is_renewed() {
        let table = LeaseTable::default();
        let (kept, lost) = (ticket(1), ticket(2));
        table.grant(kept, "a", "payload of a", limit::LEASE);
        table.grant(lost, "b", "payload of b", limit::LEASE);
        tokio::time::advance(Duration::from_secs(15)).await;
        let renewed = Renewed { worker: "a".to_owned(), age: Duration::from_secs(15) };
        assert_eq!(table.renew(&kept), Some(renewed));
        tokio::time::advance(Duration::from_secs(6)).await;
        let expired = table.end_expired();
        assert_eq!(expired.len(), 1);
        let Lease { ticket, worker, payload, .. } = &expired[0];
        assert_eq!((*ticket, worker.as_str(), *payload), (lost, "b", "payload of b"));
        assert!(table.renew(&lost).is_none() && table.end(&lost).is_none());
        assert!(table.end(&kept).is_some());
        assert!(table.end(&kept).is_none(), "a lease ends once");
    }

    #[tokio::test]
    async fn lease_of_another_epoch_is_stale() {
        let table = LeaseTable::default();
        let ticket = LeaseTicket { lease: LeaseId::fresh(), epoch: 2 };
        table.grant(ticket, "a", (), limit::LEASE);
        for epoch in [1, 3] {
            let stale = LeaseTicket { epoch, ..ticket };
            assert!(table.renew(&stale).is_none() && table.end(&stale).is_none());
        }
        assert_eq!(table.len(), 1);
    }

    #[tokio::test]
    async fn grant_replaces_an_earlier_lease_of_the_job() {
        let table = LeaseTable::default();
        let first = ticket(1);
        let second = SearchTicket { epoch: 2, ..first };
        table.grant(first, "a", (), limit::LEASE);
        table.grant(second, "b", (), limit::LEASE);
        assert!(table.end(&first).is_none());
        assert_eq!(table.end(&second).unwrap().worker, "b");
    }

    #[tokio::test]
    async fn leases_of_one_worker_end_without_the_others() {
        let table = LeaseTable::default();
        for worker in ["a", "a", "b"] {
            table.grant(ticket(1), worker, (), limit::LEASE);
        }
        assert_eq!(table.end_those_of("a").len(), 2);
        assert!(table.end_those_of("a").is_empty());
        assert_eq!(table.end_all().len(), 1);
        assert_eq!(table.len(), 0);
    }
}
