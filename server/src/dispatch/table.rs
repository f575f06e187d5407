//! Lease table of render jobs, on the monotonic clock: jumps of the wall clock expire no lease.

use std::collections::HashMap;
use std::sync::{Arc, Mutex, MutexGuard};
use std::time::Duration;

use brood_protocol::{JobId, LeaseId, LeaseTicket, RenderJob};
use tokio::time::Instant;

use crate::limit;

/// Render job granted to a worker.
#[derive(Debug, Clone)]
pub struct Lease {
    /// The job.
    pub job: JobId,
    /// Epoch of the lease; the store rejects writes of other epochs.
    pub epoch: u64,
    /// Name of the worker.
    pub worker: String,
    /// Work to do.
    pub work: Arc<RenderJob>,
    /// Time that the job waited in the queue.
    pub queued: Duration,
    /// Time of the grant.
    pub granted: Instant,
    deadline: Instant,
}

/// Leases of render jobs.
#[derive(Debug)]
pub struct LeaseTable {
    leases: Mutex<HashMap<LeaseId, Lease>>,
}

impl LeaseTable {
    /// Creates an empty table.
    pub fn new() -> Self {
        Self { leases: Mutex::new(HashMap::new()) }
    }

    /// Grants a job that has waited for `queued`.
    pub fn grant(
        &self,
        (job, epoch): (JobId, u64),
        worker: &str,
        work: Arc<RenderJob>,
        queued: Duration,
    ) -> LeaseTicket {
        let granted = Instant::now();
        let deadline = granted + limit::LEASE;
        let lease =
            Lease { job, epoch, worker: worker.to_owned(), work, queued, granted, deadline };
        let id = LeaseId::fresh();
        self.lock().insert(id, lease);
        LeaseTicket { lease: id, epoch }
    }

    /// Renews a lease and returns the worker's name; `None` if it is not valid any more.
    pub fn renew(&self, ticket: &LeaseTicket) -> Option<String> {
        let mut leases = self.lock();
        let lease = leases.get_mut(&ticket.lease).filter(|lease| lease.epoch == ticket.epoch)?;
        lease.deadline = Instant::now() + limit::LEASE;
        Some(lease.worker.clone())
    }

    /// Ends and returns a lease; `None` if it is not valid any more.
    pub fn end(&self, ticket: &LeaseTicket) -> Option<Lease> {
        let mut leases = self.lock();
        let held = leases.get(&ticket.lease).is_some_and(|lease| lease.epoch == ticket.epoch);
        if held { leases.remove(&ticket.lease) } else { None }
    }

    /// Removes and returns the expired leases.
    pub fn expire(&self) -> Vec<Lease> {
        let now = Instant::now();
        self.lock().extract_if(|_, lease| lease.deadline <= now).map(|(_, lease)| lease).collect()
    }

    /// Removes and returns the leases of a worker.
    pub fn end_those_of(&self, worker: &str) -> Vec<Lease> {
        let mut leases = self.lock();
        leases.extract_if(|_, lease| lease.worker == worker).map(|(_, lease)| lease).collect()
    }

    /// Removes and returns all leases.
    pub fn end_all(&self) -> Vec<Lease> {
        self.lock().drain().map(|(_, lease)| lease).collect()
    }

    /// Number of leases.
    pub fn len(&self) -> usize {
        self.lock().len()
    }

    fn lock(&self) -> MutexGuard<'_, HashMap<LeaseId, Lease>> {
        self.leases.lock().expect("nothing panics under this lock")
    }
}

#[cfg(test)]
mod tests {
    use brood_protocol::{Backend, Frame, MeshSource, PictureFormat};
    use brood_scene::Scene;

    use super::*;

    fn work() -> Arc<RenderJob> {
        let options = (PictureFormat::Png, Backend::Auto);
        let frame = Frame::new(&Scene::default(), MeshSource::Builtin, 16, 1, options);
        Arc::new(RenderJob { frame, items: Vec::new() })
    }

    #[tokio::test(start_paused = true)]
    async fn lease_expires_unless_it_is_renewed() {
        let table = LeaseTable::new();
        let kept = table.grant((JobId::fresh(), 1), "a", work(), Duration::ZERO);
        let lost = table.grant((JobId::fresh(), 1), "b", work(), Duration::ZERO);
        tokio::time::advance(Duration::from_secs(15)).await;
        assert_eq!(table.renew(&kept).as_deref(), Some("a"));
        tokio::time::advance(Duration::from_secs(6)).await;
        let expired = table.expire();
        assert_eq!(expired.len(), 1);
        assert_eq!(expired[0].worker, "b");
        assert!(table.renew(&lost).is_none() && table.end(&lost).is_none());
        assert!(table.end(&kept).is_some());
        assert!(table.end(&kept).is_none(), "a lease ends once");
    }

    #[tokio::test]
    async fn lease_of_another_epoch_is_stale() {
        let table = LeaseTable::new();
        let ticket = table.grant((JobId::fresh(), 2), "a", work(), Duration::ZERO);
        let stale = LeaseTicket { epoch: 1, ..ticket };
        assert!(table.renew(&stale).is_none() && table.end(&stale).is_none());
        assert_eq!(table.len(), 1);
    }

    #[tokio::test]
    async fn leases_of_one_worker_end_without_the_others() {
        let table = LeaseTable::new();
        table.grant((JobId::fresh(), 1), "a", work(), Duration::ZERO);
        table.grant((JobId::fresh(), 1), "a", work(), Duration::ZERO);
        let other = table.grant((JobId::fresh(), 1), "b", work(), Duration::ZERO);
        assert_eq!(table.end_those_of("a").len(), 2);
        assert!(table.end_those_of("a").is_empty());
        assert!(table.renew(&other).is_some());
    }
}
