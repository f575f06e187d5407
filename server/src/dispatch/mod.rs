//! Dispatch: pictures that are wanted become jobs, jobs become leases, results become pictures.
//!
//! [`table`] holds the leases on the monotonic clock, [`render`] is the road of those who want pictures, [`lease`] that
//! of those who make them, [`search`] that of those who search, [`queue`] knows the workers that wait, and [`history`] what became of jobs.

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

pub use history::{Finished, History};
use queue::Waiters;
pub use queue::{Handed, Waiting};
pub use render::{FrameId, queued_job, render_work};
pub use search::{Holds, search_json};
pub use table::{Lease, Table};

/// Workers that are remembered.
const WORKERS: usize = 256;
/// A worker is said to be there this long after it was heard of.
const PRESENT: Duration = Duration::from_secs(60);

/// Leases and workers.
pub struct Dispatch {
    /// Leases that are out.
    pub table: Table,
    /// Rung once for each job that is queued.
    pub bell: Notify,
    /// Jobs that were done lately.
    pub history: History,
    /// Searches that are out.
    pub holds: Holds,
    /// Rung for each search that is queued.
    pub search_bell: Notify,
    waiters: Waiters,
    workers: Mutex<HashMap<String, (Instant, WorkerReport)>>,
}

impl Dispatch {
    /// No leases, no workers.
    pub fn new() -> Self {
        Self {
            table: Table::new(),
            bell: Notify::new(),
            history: History::new(),
            holds: Holds::default(),
            search_bell: Notify::new(),
            waiters: Waiters::default(),
            workers: Mutex::default(),
        }
    }

    /// The worker that has waited longest for a job; whoever takes it gives it one.
    pub fn next_waiting(&self) -> Option<Waiting> {
        self.waiters.next()
    }

    /// A place where a worker waits for a job.
    pub fn join(&self, worker: &str) -> oneshot::Receiver<Handed> {
        self.waiters.join(worker)
    }

    /// Notes that a worker was heard of.
    pub fn heard(&self, name: &str, report: &WorkerReport) {
        let mut workers = self.workers.lock().expect("nothing panics under this lock");
        if workers.len() >= WORKERS && !workers.contains_key(name) {
            workers.retain(|_, (when, _)| when.elapsed() < PRESENT);
            if workers.len() >= WORKERS {
                return;
            }
        }
        workers.insert(name.to_owned(), (Instant::now(), report.clone()));
    }

    /// Notes that a worker was heard of that had told about itself before.
    pub fn heard_again(&self, name: &str) {
        let mut workers = self.workers.lock().expect("nothing panics under this lock");
        if let Some((when, _)) = workers.get_mut(name) {
            *when = Instant::now();
        }
    }

    /// Workers heard of lately, by name, and the evaluator of the one heard of last.
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
