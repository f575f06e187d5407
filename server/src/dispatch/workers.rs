//! Workers heard from recently.

use std::collections::HashMap;
use std::sync::Mutex;
use std::time::{Duration, Instant};

use brood_protocol::{BackendReport, WorkerReport};

/// Number of workers kept.
const WORKERS: usize = 256;
/// Time since its last message for which a worker counts as present.
const PRESENT: Duration = Duration::from_secs(60);

/// Workers with their last message and report.
#[derive(Debug, Default)]
pub struct Workers {
    workers: Mutex<HashMap<String, (Instant, WorkerReport)>>,
}

impl Workers {
    /// Records a message of a worker with its report.
    pub fn seen(&self, name: &str, report: &WorkerReport) {
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
    pub fn seen_again(&self, name: &str) {
        let mut workers = self.workers.lock().expect("nothing panics under this lock");
        if let Some((when, _)) = workers.get_mut(name) {
            *when = Instant::now();
        }
    }

    /// Returns the names of the present workers and the backend of the worker heard from last.
    pub fn present(&self) -> (Vec<String>, Option<BackendReport>) {
        let workers = self.workers.lock().expect("nothing panics under this lock");
        let last = workers.values().max_by_key(|(when, _)| *when);
        let backend = last.map(|(_, report)| report.backend.clone());
        let present = workers.iter().filter(|(_, (when, _))| when.elapsed() < PRESENT);
        let mut names: Vec<_> = present.map(|(name, _)| name.clone()).collect();
        names.sort();
        (names, backend)
    }
}
