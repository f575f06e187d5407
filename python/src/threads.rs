//! Threads of a call: all of the process, or a pool of a given number.

use std::collections::HashMap;
use std::sync::{LazyLock, Mutex, PoisonError};

use pyo3::prelude::*;
use rayon::{ThreadPool, ThreadPoolBuilder};

use crate::error::value_error;

/// Largest number of threads of a call.
const MOST: usize = 1024;

/// Idle pools by their number of threads; starting one takes longer than a small call. Calls do not
/// share a pool: one that waits for the cache of another would take the other's work and wait for
/// itself.
static IDLE: LazyLock<Mutex<HashMap<usize, Vec<ThreadPool>>>> = LazyLock::new(Mutex::default);

/// Threads of a call; its pool is idle again afterwards.
pub(crate) struct Threads(Option<ThreadPool>);

impl Drop for Threads {
    fn drop(&mut self) {
        if let Some(pool) = self.0.take() {
            let mut idle = IDLE.lock().unwrap_or_else(PoisonError::into_inner);
            idle.entry(pool.current_num_threads()).or_default().push(pool);
        }
    }
}

impl Threads {
    /// Returns the threads of a call. `None` means those of the process: as many as
    /// `RAYON_NUM_THREADS` says, or one per core.
    pub(crate) fn of(count: Option<usize>) -> PyResult<Self> {
        let Some(count) = count else { return Ok(Self(None)) };
        if !(1..=MOST).contains(&count) {
            return Err(value_error(format!("`threads` must be 1 to {MOST}, got {count}")));
        }
        Ok(Self(Some(pool(count)?)))
    }

    /// Runs `work` on the threads. The caller has released Python's lock.
    pub(crate) fn install<R: Send>(&self, work: impl FnOnce() -> R + Send) -> R {
        match &self.0 {
            None => work(),
            Some(pool) => pool.install(work),
        }
    }
}

/// Runs `work` on the threads of a call, without Python's lock.
pub(crate) fn run<R: Send>(
    py: Python<'_>,
    threads: Option<usize>,
    work: impl FnOnce() -> R + Send,
) -> PyResult<R> {
    let threads = Threads::of(threads)?;
    Ok(py.detach(|| threads.install(work)))
}

fn pool(count: usize) -> PyResult<ThreadPool> {
    let mut idle = IDLE.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some(pool) = idle.get_mut(&count).and_then(Vec::pop) {
        return Ok(pool);
    }
    drop(idle);
    ThreadPoolBuilder::new().num_threads(count).build().map_err(value_error)
}
