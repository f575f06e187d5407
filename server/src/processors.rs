//! Processors: limits CPU-heavy work to one call per processor.

use std::sync::Arc;

use tokio::sync::Semaphore;

use crate::limit;
use crate::problem::ApiError;

/// Permits for CPU-heavy work.
#[derive(Debug, Clone)]
pub struct Processors {
    /// One permit per processor.
    running: Arc<Semaphore>,
    /// One permit per call that may wait for a processor.
    waiting: Arc<Semaphore>,
}

impl Processors {
    /// Creates the permits of this machine.
    pub fn new() -> Self {
        let processors = std::thread::available_parallelism().map_or(1, usize::from);
        Self {
            running: Arc::new(Semaphore::new(processors)),
            waiting: Arc::new(Semaphore::new(limit::WAITING_BROODS)),
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
