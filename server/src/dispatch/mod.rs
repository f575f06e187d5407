//! Job dispatch: picture requests become jobs, jobs become leases, and results become pictures.
//!
//! [`render`] serves picture requests. [`lease`] serves workers, the same for all kinds of jobs,
//! with the leases in [`table`] and the waiting workers in [`queue`]. [`kind`] defines what
//! differs; [`render_job`] and [`search`] are the kinds. [`history`] remembers finished render
//! jobs.

mod history;
mod kind;
mod lease;
mod queue;
mod render;
mod render_job;
mod search;
mod table;

use std::collections::HashMap;
use std::sync::Mutex;
use std::time::{Duration, Instant};

use brood_protocol::{BackendReport, WorkerReport};

pub use history::{FinishedJob, History};
use kind::Jobs;
pub use lease::LeaseEnd;
pub use queue::WaitingWorker;
pub use render::{FrameId, PictureRequest, queued_job, render_work};
pub use render_job::Render;
pub use search::{Search, search_json};

/// Number of workers remembered.
const WORKERS: usize = 256;
/// Time since its last message for which a worker counts as present.
const PRESENT: Duration = Duration::from_secs(60);

/// Leases, finished jobs and workers.
pub struct Dispatch {
    /// Leases of render jobs.
    pub renders: Jobs<Render>,
    /// Leases of searches.
    pub searches: Jobs<Search>,
    /// Recently finished render jobs.
    pub history: History,
    workers: Mutex<HashMap<String, (Instant, WorkerReport)>>,
}

impl Dispatch {
    /// Creates a dispatch without leases and workers.
    pub fn new() -> Self {
        Self {
            renders: Jobs::new(),
            searches: Jobs::new(),
            history: History::new(),
            workers: Mutex::default(),
        }
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
