//! What became of jobs lately: what they took, and how long they waited. In memory only, and bounded.

use std::sync::Mutex;
use std::time::{Duration, Instant};

use brood_protocol::{JobId, JobTimes, Work};
use moka::sync::Cache;

/// Jobs that are remembered.
const JOBS: u64 = 4096;
/// Weight of the newest wait in the running mean.
const NEWEST: f64 = 0.2;
/// A mean that nobody has added to for so long says nothing about now.
const STALE: Duration = Duration::from_secs(60);

/// What became of a job.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Finished {
    /// What it took.
    pub work: Work,
    /// How long its stages took.
    pub times: JobTimes,
}

/// Jobs that were done lately.
#[derive(Debug)]
pub struct History {
    jobs: Cache<JobId, Finished>,
    wait_s: Mutex<Option<(Instant, f64)>>,
}

impl History {
    /// None were done.
    pub fn new() -> Self {
        Self { jobs: Cache::new(JOBS), wait_s: Mutex::default() }
    }

    /// Notes that a job is done.
    pub fn note(&self, job: JobId, finished: Finished) {
        let wait_s = Duration::from_micros(finished.times.queued_us + finished.times.leased_us);
        let mut mean = self.wait_s.lock().expect("nothing panics under this lock");
        let fresh = (*mean).filter(|(when, _)| when.elapsed() < STALE);
        let before = fresh.map_or(wait_s.as_secs_f64(), |(_, before)| before);
        *mean = Some((Instant::now(), before + NEWEST * (wait_s.as_secs_f64() - before)));
        drop(mean);
        self.jobs.insert(job, finished);
    }

    /// What became of a job, if that was lately.
    pub fn of(&self, job: JobId) -> Option<Finished> {
        self.jobs.get(&job)
    }

    /// How long jobs took of late, from being made to being done.
    pub fn wait(&self) -> Option<Duration> {
        let mean = *self.wait_s.lock().expect("nothing panics under this lock");
        let (_, mean) = mean.filter(|(when, _)| when.elapsed() < STALE)?;
        Some(Duration::from_secs_f64(mean))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn finished(queued_us: u64, leased_us: u64) -> Finished {
        Finished { work: Work::default(), times: JobTimes { queued_us, leased_us } }
    }

    #[test]
    fn wait_follows_the_jobs_of_late() {
        let history = History::new();
        assert_eq!(history.wait(), None);
        history.note(JobId::fresh(), finished(500_000, 500_000));
        assert_eq!(history.wait(), Some(Duration::from_secs(1)));
        for _ in 0..50 {
            history.note(JobId::fresh(), finished(9_000_000, 1_000_000));
        }
        let wait = history.wait().unwrap();
        assert!(wait > Duration::from_secs(9) && wait <= Duration::from_secs(10), "{wait:?}");
    }

    #[test]
    fn job_is_remembered_with_what_it_took() {
        let history = History::new();
        let (job, done) = (JobId::fresh(), finished(1, 2));
        history.note(job, done);
        assert_eq!(history.of(job), Some(done));
        assert_eq!(history.of(JobId::fresh()), None);
    }
}
