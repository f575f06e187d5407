//! Recently finished jobs and their mean waiting time. In memory only, and bounded.

use std::sync::Mutex;
use std::time::{Duration, Instant};

use brood_protocol::{JobId, JobTimes, RenderStats};
use moka::sync::Cache;

/// Number of jobs kept.
const JOBS: u64 = 4096;
/// Weight of the newest wait in the running mean.
const NEWEST: f64 = 0.2;
/// Age at which the mean waiting time is dropped.
const STALE: Duration = Duration::from_secs(60);

/// Cost and duration of a finished job.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FinishedJob {
    /// Counters of the job.
    pub work: RenderStats,
    /// Time in the queue and time leased.
    pub times: JobTimes,
}

/// Recently finished jobs.
#[derive(Debug)]
pub struct History {
    jobs: Cache<JobId, FinishedJob>,
    wait_s: Mutex<Option<(Instant, f64)>>,
}

impl History {
    /// Creates an empty history.
    pub fn new() -> Self {
        Self { jobs: Cache::new(JOBS), wait_s: Mutex::default() }
    }

    /// Records a finished job.
    pub fn note(&self, job: JobId, finished: FinishedJob) {
        let wait_s = Duration::from_micros(finished.times.queued_us + finished.times.leased_us);
        let mut mean = self.wait_s.lock().expect("nothing panics under this lock");
        let fresh = (*mean).filter(|(when, _)| when.elapsed() < STALE);
        let before = fresh.map_or(wait_s.as_secs_f64(), |(_, before)| before);
        *mean = Some((Instant::now(), before + NEWEST * (wait_s.as_secs_f64() - before)));
        drop(mean);
        self.jobs.insert(job, finished);
    }

    /// Returns a recently finished job.
    pub fn get(&self, job: JobId) -> Option<FinishedJob> {
        self.jobs.get(&job)
    }

    /// Returns the recent mean time from a job's creation to its end.
    pub fn wait(&self) -> Option<Duration> {
        let mean = *self.wait_s.lock().expect("nothing panics under this lock");
        let (_, mean) = mean.filter(|(when, _)| when.elapsed() < STALE)?;
        Some(Duration::from_secs_f64(mean))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn finished(queued_us: u64, leased_us: u64) -> FinishedJob {
        FinishedJob { work: RenderStats::default(), times: JobTimes { queued_us, leased_us } }
    }

    #[test]
    fn wait_follows_recent_jobs() {
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
    fn job_is_kept_with_its_cost() {
        let history = History::new();
        let (job, done) = (JobId::fresh(), finished(1, 2));
        history.note(job, done);
        assert_eq!(history.get(job), Some(done));
        assert_eq!(history.get(JobId::fresh()), None);
    }
}
