//! Processors: limits CPU-heavy work to one call per processor, and runs long work on threads of
//! low priority beside it.

use std::sync::{Arc, OnceLock};

use brood_protocol::{Queue, lower_thread_priority};
use rayon::ThreadPool;
use tokio::sync::Semaphore;

use crate::limit;
use crate::problem::ApiError;

/// Number of calls of long work that share the processors.
const LONG_CALLS: usize = 2;

/// Permits for CPU-heavy work.
#[derive(Debug, Clone)]
pub struct Processors {
    short: Permits,
    long: Permits,
    /// Threads for long work, started by its first call.
    pool: Arc<OnceLock<Option<ThreadPool>>>,
}

/// Permits of one kind of work.
#[derive(Debug, Clone)]
struct Permits {
    running: Arc<Semaphore>,
    /// One permit per call that may wait.
    waiting: Arc<Semaphore>,
}

impl Permits {
    fn new(running: usize) -> Self {
        let waiting = Arc::new(Semaphore::new(limit::WAITING_BROODS));
        Self { running: Arc::new(Semaphore::new(running)), waiting }
    }

    /// Runs `work` on a blocking thread once there is a permit.
    async fn run<T: Send + 'static>(
        &self,
        work: impl FnOnce() -> T + Send + 'static,
    ) -> Result<T, ApiError> {
        let waiting = self.waiting.try_acquire();
        let waiting = waiting.map_err(|_| ApiError::busy("all processors are busy"))?;
        let permit = self.running.clone().acquire_owned().await;
        let permit = permit.map_err(|error| ApiError::internal(error.to_string()))?;
        drop(waiting);
        run_blocking(move || {
            // Dropped when the work ends, not when the request is cancelled.
            let _permit = permit;
            work()
        })
        .await
    }
}

impl Processors {
    /// Creates the permits of this machine.
    pub fn new() -> Self {
        let processors = std::thread::available_parallelism().map_or(1, usize::from);
        Self {
            short: Permits::new(processors),
            long: Permits::new(LONG_CALLS),
            pool: Arc::default(),
        }
    }

    /// Runs `work` on a blocking thread, at most one call per processor.
    ///
    /// # Errors
    /// 503 if [`limit::WAITING_BROODS`] calls are already waiting.
    pub async fn run<T: Send + 'static>(
        &self,
        work: impl FnOnce() -> T + Send + 'static,
    ) -> Result<T, ApiError> {
        self.short.run(work).await
    }

    /// As [`Processors::run`]; batch work runs on threads of low priority, a few calls at a time.
    ///
    /// # Errors
    /// As [`Processors::run`].
    pub async fn run_from<T: Send + 'static>(
        &self,
        queue: Queue,
        work: impl FnOnce() -> T + Send + 'static,
    ) -> Result<T, ApiError> {
        if queue == Queue::Interactive {
            return self.run(work).await;
        }
        let pool = self.pool.clone();
        let run = move || match pool.get_or_init(low_pool) {
            Some(pool) => pool.install(work),
            None => work(),
        };
        self.long.run(run).await
    }
}

/// Starts threads of low priority, one per processor.
fn low_pool() -> Option<ThreadPool> {
    let made = rayon::ThreadPoolBuilder::new()
        .thread_name(|index| format!("long-{index}"))
        .start_handler(|_| lower_thread_priority())
        .build();
    made.inspect_err(|error| tracing::warn!(%error, "long work has no threads of its own")).ok()
}

/// Runs `work` on a blocking thread.
///
/// # Errors
/// 500 if `work` panics.
pub async fn run_blocking<T: Send + 'static>(
    work: impl FnOnce() -> T + Send + 'static,
) -> Result<T, ApiError> {
    let done = tokio::task::spawn_blocking(work).await;
    done.map_err(|error| ApiError::internal(error.to_string()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[tokio::test]
    async fn short_work_does_not_wait_for_long_work() {
        let processors = Processors::new();
        let (end, ended) = std::sync::mpsc::channel::<()>();
        let ended = Arc::new(std::sync::Mutex::new(ended));
        let long: Vec<_> = (0..2 * LONG_CALLS)
            .map(|_| {
                let (processors, ended) = (processors.clone(), ended.clone());
                tokio::spawn(async move {
                    let wait = move || drop(ended.lock().map(|ended| ended.recv()));
                    processors.run_from(Queue::Batch, wait).await
                })
            })
            .collect();
        tokio::task::yield_now().await;
        assert_eq!(processors.run(|| 7).await.unwrap(), 7);
        assert_eq!(processors.run_from(Queue::Interactive, || 8).await.unwrap(), 8);
        drop(end);
        for one in long {
            one.await.unwrap().unwrap();
        }
    }

    #[cfg(target_os = "linux")]
    #[tokio::test]
    async fn long_work_has_a_low_priority() {
        let nice = || rustix::process::nice(0).unwrap();
        let processors = Processors::new();
        let short = processors.run(nice).await.unwrap();
        let long = processors.run_from(Queue::Batch, nice).await.unwrap();
        assert!(long > short, "{long} {short}");
    }
}
