//! Job dispatch: picture requests become jobs, jobs become leases, and results become pictures.
//!
//! [`table`] holds the leases, [`render`] serves picture requests, [`lease`] serves render workers,
//! [`search`] serves search workers, [`queue`] holds the waiting workers, and [`history`] remembers
//! finished jobs.

mod history;
mod lease;
mod queue;
mod render;
mod search;
mod table;

use std::collections::HashMap;
use std::sync::Mutex;
use std::time::{Duration, Instant};

use brood_protocol::{BackendReport, WorkerReport};
use tokio::sync::{Notify, oneshot};

pub use history::{FinishedJob, History};
use queue::WaitingWorkers;
pub use queue::{PendingGrant, WaitingWorker};
pub use render::{FrameId, queued_job, render_work};
pub use search::{SearchLeases, search_json};
pub use table::{Lease, LeaseTable};

/// Number of workers remembered.
const WORKERS: usize = 256;
/// Time since its last message for which a worker counts as present.
const PRESENT: Duration = Duration::from_secs(60);

/// Leases, finished jobs and workers.
pub struct Dispatch {
    /// Render leases.
    pub table: LeaseTable,
    /// Notified once per queued render job.
    pub job_notify: Notify,
    /// Recently finished jobs.
    pub history: History,
    /// Search leases.
    pub search_leases: SearchLeases,
    /// Notified once per queued search.
    pub search_notify: Notify,
    waiters: WaitingWorkers,
    workers: Mutex<HashMap<String, (Instant, WorkerReport)>>,
}

impl Dispatch {
    /// Creates a dispatch without leases and workers.
    pub fn new() -> Self {
        Self {
            table: LeaseTable::new(),
            job_notify: Notify::new(),
            history: History::new(),
            search_leases: SearchLeases::default(),
            search_notify: Notify::new(),
            waiters: WaitingWorkers::default(),
            workers: Mutex::default(),
        }
    }

    /// Removes and returns the worker that has waited longest; the caller gives it a job.
    pub fn next_waiting(&self) -> Option<WaitingWorker> {
        self.waiters.next()
    }

    /// Adds a worker to those that wait for a job.
    pub fn join(&self, worker: &str) -> oneshot::Receiver<PendingGrant> {
        self.waiters.join(worker)
    }

    /// Records a message of a worker with its report.
    pub fn worker_seen(&self, name: &str, report: &WorkerReport) {
        let mut workers = self.workers.lock().expect("nothing panics under this lock");
        if workers.len() >= WORKERS && !workers.contains_key(name) {
            workers.retain(|_, (when, _)| when.elapsed() < PRESENT);
            if workers.len() >= WORKERS {
                return;
            }
        }
        workers.insert(name.to_owned(), (Instant::now(), report.clone()));
    }

    /// Records a message without a report of a worker that is already known.
    pub fn worker_seen_again(&self, name: &str) {
        let mut workers = self.workers.lock().expect("nothing panics under this lock");
        if let Some((when, _)) = workers.get_mut(name) {
            *when = Instant::now();
        }
    }

    /// Returns the names of the present workers and the backend of the worker heard from last.
    pub fn workers(&self) -> (Vec<String>, Option<BackendReport>) {
        let workers = self.workers.lock().expect("nothing panics under this lock");
        let last = workers.values().max_by_key(|(when, _)| *when);
        let backend = last.map(|(_, report)| report.backend.clone());
        let present = workers.iter().filter(|(_, (when, _))| when.elapsed() < PRESENT);
        let mut names: Vec<_> = present.map(|(name, _)| name.clone()).collect();
        names.sort();
        (names, backend)
    }
}
