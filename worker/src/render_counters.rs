//! Accumulated render counters: the part of [`RenderStats`] that the renderer and its caches count.

use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

use brood_protocol::RenderStats;

/// Thread-safe counters that grow until they are taken.
#[derive(Debug, Default)]
pub(crate) struct RenderCounters(Mutex<RenderStats>);

impl RenderCounters {
    pub(crate) fn add(&self, work: RenderStats) {
        *self.0.lock().unwrap_or_else(PoisonError::into_inner) += work;
    }

    /// Returns the counters and resets them to zero.
    pub(crate) fn take(&self) -> RenderStats {
        std::mem::take(&mut *self.0.lock().unwrap_or_else(PoisonError::into_inner))
    }

    /// Runs a closure and adds its duration in microseconds, converted by `counted`.
    pub(crate) fn timed<T>(&self, run: impl FnOnce() -> T, counted: fn(u64) -> RenderStats) -> T {
        let start = Instant::now();
        let result = run();
        self.add(counted(micros(start.elapsed())));
        result
    }
}

pub(crate) fn micros(time: Duration) -> u64 {
    u64::try_from(time.as_micros()).unwrap_or(u64::MAX)
}
