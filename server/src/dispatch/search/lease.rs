//! Lease table of searches, on the monotonic clock.

use std::collections::HashMap;
use std::sync::{Mutex, MutexGuard};
use std::time::Duration;

use brood_protocol::{JobId, SearchTicket};
use tokio::time::Instant;

use crate::limit;

/// Leases of searches by job.
#[derive(Debug, Default)]
pub struct SearchLeases {
    leases: Mutex<HashMap<JobId, SearchLease>>,
}

#[derive(Debug)]
struct SearchLease {
    epoch: u64,
    worker: String,
    granted: Instant,
    deadline: Instant,
}

impl SearchLeases {
    /// Grants a search; replaces an earlier lease.
    pub fn grant(&self, ticket: SearchTicket, worker: &str) {
        let granted = Instant::now();
        let deadline = granted + limit::LEASE;
        let lease =
            SearchLease { epoch: ticket.epoch, worker: worker.to_owned(), granted, deadline };
        self.lock().insert(ticket.job, lease);
    }

    /// Renews a lease and returns its age; `None` if it is not valid any more.
    pub fn renew(&self, ticket: &SearchTicket) -> Option<Duration> {
        let mut leases = self.lock();
        let lease = leases.get_mut(&ticket.job).filter(|lease| lease.epoch == ticket.epoch)?;
        lease.deadline = Instant::now() + limit::LEASE;
        Some(lease.granted.elapsed())
    }

    /// Ends a lease; false if it is not valid any more.
    pub fn end(&self, ticket: &SearchTicket) -> bool {
        let mut leases = self.lock();
        let is_held = leases.get(&ticket.job).is_some_and(|lease| lease.epoch == ticket.epoch);
        is_held && leases.remove(&ticket.job).is_some()
    }

    /// Ends the lease of a search, of any epoch.
    pub fn forget(&self, job: JobId) {
        self.lock().remove(&job);
    }

    /// Removes and returns the expired leases.
    pub fn expire(&self) -> Vec<SearchTicket> {
        let now = Instant::now();
        self.take(|lease| lease.deadline <= now)
    }

    /// Removes and returns the leases of a worker.
    pub fn end_those_of(&self, worker: &str) -> Vec<SearchTicket> {
        self.take(|lease| lease.worker == worker)
    }

    /// Removes and returns all leases.
    pub fn end_all(&self) -> Vec<SearchTicket> {
        self.take(|_| true)
    }

    fn take(&self, which: impl Fn(&SearchLease) -> bool) -> Vec<SearchTicket> {
        let mut leases = self.lock();
        let taken = leases.extract_if(|_, lease| which(lease));
        taken.map(|(job, lease)| SearchTicket { job, epoch: lease.epoch }).collect()
    }

    fn lock(&self) -> MutexGuard<'_, HashMap<JobId, SearchLease>> {
        self.leases.lock().expect("nothing panics under this lock")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[tokio::test(start_paused = true)]
    async fn lease_expires_unless_renewed_and_ends_once() {
        let leases = SearchLeases::default();
        let ticket = |epoch| SearchTicket { job: JobId::fresh(), epoch };
        let (kept, lost) = (ticket(1), ticket(2));
        leases.grant(kept, "a");
        leases.grant(lost, "b");
        tokio::time::advance(Duration::from_secs(15)).await;
        assert_eq!(leases.renew(&kept), Some(Duration::from_secs(15)));
        tokio::time::advance(Duration::from_secs(6)).await;
        assert_eq!(leases.expire(), [lost]);
        assert_eq!(leases.renew(&SearchTicket { epoch: 9, ..kept }), None);
        assert!(!leases.end(&SearchTicket { epoch: 9, ..kept }));
        assert!(leases.end(&kept) && !leases.end(&kept));
    }

    #[tokio::test]
    async fn leases_of_one_worker_end_without_the_others() {
        let leases = SearchLeases::default();
        for worker in ["a", "a", "b"] {
            leases.grant(SearchTicket { job: JobId::fresh(), epoch: 1 }, worker);
        }
        assert_eq!(leases.end_those_of("a").len(), 2);
        assert_eq!(leases.end_all().len(), 1);
    }
}
