//! Workers heard from recently, and clients whose workers get no jobs for a while, because a lease
//! expired or pictures were invalid.

use std::collections::HashMap;
use std::sync::Mutex;
use std::time::{Duration, Instant};

use brood_protocol::{BackendReport, WorkerReport};

use crate::client::Client;

/// Number of workers kept.
const WORKERS: usize = 256;
/// Most names of workers whose client is known.
const NAMES: usize = 4096;
/// Time since its last message for which a worker counts as present.
const PRESENT: Duration = Duration::from_secs(60);

/// Time after a finished job of a client. A lease that the client loses in this time does not count
/// as its failure, because other workers of the client still finish jobs.
const DOES_JOBS: Duration = Duration::from_secs(10);
/// Time without jobs after the first failure of a client's worker; doubled with each further one.
const FIRST_WAIT: Duration = Duration::from_secs(1);
const LONGEST_WAIT: Duration = Duration::from_secs(60);

/// Workers with their last message and report.
#[derive(Debug, Default)]
pub struct Workers {
    workers: Mutex<HashMap<String, (Instant, WorkerReport)>>,
    /// Clients that run workers, by the workers' names, with the time of the last request for a
    /// job. Workers of the server are left out.
    clients: Mutex<HashMap<String, (Instant, Client)>>,
    failures: Mutex<HashMap<Client, Failures>>,
    /// Clients with the time of the last job that one of their workers did.
    done: Mutex<HashMap<Client, Instant>>,
}

/// Failures of a client's workers since the last job that one did.
#[derive(Debug, Clone, Copy)]
struct Failures {
    count: u32,
    last: Instant,
}

impl Failures {
    fn wait(self) -> Duration {
        let wait = FIRST_WAIT.saturating_mul(1 << (self.count - 1).min(16)).min(LONGEST_WAIT);
        wait.saturating_sub(self.last.elapsed())
    }
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

    /// Records which client runs a worker that the server did not start.
    pub fn run_by(&self, name: &str, client: Client) {
        let mut clients = self.clients.lock().expect("nothing panics under this lock");
        if clients.len() >= WORKERS && !clients.contains_key(name) {
            clients.retain(|_, (when, _)| when.elapsed() < PRESENT);
        }
        if clients.len() < NAMES {
            clients.insert(name.to_owned(), (Instant::now(), client));
        }
    }

    /// Records that a lease of a worker has expired.
    pub fn lost(&self, name: &str) {
        let clients = self.clients.lock().expect("nothing panics under this lock");
        let client = clients.get(name).map(|known| known.1);
        drop(clients);
        let Some(client) = client else { return };
        let done = self.done.lock().expect("nothing panics under this lock");
        let does_jobs = done.get(&client).is_some_and(|last| last.elapsed() < DOES_JOBS);
        drop(done);
        if !does_jobs {
            self.failed(client);
        }
    }

    /// Records a failure of a client's worker.
    pub fn failed(&self, client: Client) {
        let mut failures = self.failures.lock().expect("nothing panics under this lock");
        failures.retain(|_, known| known.last.elapsed() < 2 * LONGEST_WAIT);
        let count = failures.get(&client).map_or(0, |known| known.count) + 1;
        failures.insert(client, Failures { count, last: Instant::now() });
    }

    /// Records that a client's worker has done a job.
    pub fn succeeded(&self, client: Client) {
        let mut done = self.done.lock().expect("nothing panics under this lock");
        if done.len() >= WORKERS && !done.contains_key(&client) {
            done.retain(|_, last| last.elapsed() < DOES_JOBS);
        }
        if done.len() < NAMES {
            done.insert(client, Instant::now());
        }
        drop(done);
        self.failures.lock().expect("nothing panics under this lock").remove(&client);
    }

    /// Returns the time for which a client's workers get no jobs.
    pub fn held_back(&self, client: Client) -> Duration {
        let failures = self.failures.lock().expect("nothing panics under this lock");
        failures.get(&client).map_or(Duration::ZERO, |known| known.wait())
    }

    /// Forgets a worker of the server that has ended.
    pub fn gone(&self, name: &str) {
        self.workers.lock().expect("nothing panics under this lock").remove(name);
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

#[cfg(test)]
mod tests {
    use std::net::Ipv4Addr;

    use super::*;

    #[test]
    fn client_waits_longer_after_each_failure_until_its_worker_does_a_job() {
        let (workers, one) = (Workers::default(), Client::Address(Ipv4Addr::LOCALHOST.into()));
        assert_eq!(workers.held_back(one), Duration::ZERO);
        workers.run_by("far", one);
        workers.lost("local-1");
        assert_eq!(workers.held_back(one), Duration::ZERO);
        let within = |from: u64| {
            let wait = workers.held_back(one);
            assert!(wait > Duration::from_millis(1000 * from - 500), "{wait:?}");
            assert!(wait <= Duration::from_secs(from), "{wait:?}");
        };
        for (round, seconds) in [1, 2, 4, 8, 16, 32, 60, 60].into_iter().enumerate() {
            if round % 2 == 0 {
                workers.lost("far");
            } else {
                workers.failed(one);
            }
            within(seconds);
        }
        assert_eq!(workers.held_back(Client::Token([1; 32])), Duration::ZERO);
        workers.succeeded(one);
        assert_eq!(workers.held_back(one), Duration::ZERO);
        workers.lost("far");
        assert_eq!(workers.held_back(one), Duration::ZERO, "another of its workers does jobs");
        workers.failed(one);
        within(1);
    }
}
