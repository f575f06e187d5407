//! Parsing of uploaded targets on blocking threads, few at a time.

use tokio::sync::Semaphore;

use crate::problem::ApiError;

/// Number of targets parsed at a time: parsing takes several times the file's memory.
pub const READ_PERMITS: u32 = 2;
static READING: Semaphore = Semaphore::const_new(READ_PERMITS as usize);

/// Runs `work`, which parses a target, on a blocking thread under `permits` of the
/// [`READ_PERMITS`]. A cancelled request releases its place in the queue.
///
/// # Errors
/// 500 if `work` panics.
pub async fn read_blocking<T: Send + 'static>(
    permits: u32,
    work: impl FnOnce() -> T + Send + 'static,
) -> Result<T, ApiError> {
    let permit = READING.acquire_many(permits).await;
    let permit = permit.map_err(|error| ApiError::internal(error.to_string()))?;
    let done = tokio::task::spawn_blocking(move || {
        let result = work();
        drop(permit);
        result
    });
    done.await.map_err(|error| ApiError::internal(error.to_string()))
}
