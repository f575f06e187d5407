//! What rendering took since it was last asked: the part of [`Work`] that only the renderer and its caches know.

use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

use brood_protocol::Work;

/// Counters that grow until they are taken.
#[derive(Debug, Default)]
pub(crate) struct Tally(Mutex<Work>);

impl Tally {
    pub(crate) fn add(&self, work: Work) {
        *self.0.lock().unwrap_or_else(PoisonError::into_inner) += work;
    }

    /// What came together, and back to nothing.
    pub(crate) fn take(&self) -> Work {
        std::mem::take(&mut *self.0.lock().unwrap_or_else(PoisonError::into_inner))
    }

    /// Runs something and adds its time by `counted`.
    pub(crate) fn timed<T>(&self, run: impl FnOnce() -> T, counted: fn(u64) -> Work) -> T {
        let start = Instant::now();
        let result = run();
        self.add(counted(micros(start.elapsed())));
        result
    }
}

pub(crate) fn micros(time: Duration) -> u64 {
    u64::try_from(time.as_micros()).unwrap_or(u64::MAX)
}
