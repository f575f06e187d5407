//! Parsing of uploaded targets on blocking threads, few at a time.

use brood_target::{TargetFile, TargetFileError, TargetKind};
use tokio::sync::Semaphore;

use crate::problem::ApiError;
use crate::processors::run_blocking;

/// Number of targets parsed at a time: parsing takes several times the file's memory.
pub const READ_PERMITS: u32 = 2;
static READING: Semaphore = Semaphore::const_new(READ_PERMITS as usize);

/// Longest error text about an unreadable file, which may quote names from the file.
pub const REASON_CHARS: usize = 160;

/// Parsed target and its stored file.
pub struct ParsedTarget {
    /// Target.
    pub read: TargetFile,
    /// File of the target.
    pub bytes: Vec<u8>,
    /// Content hash of the file.
    pub hash: blake3::Hash,
}

impl ParsedTarget {
    /// Parses a file of this kind.
    ///
    /// # Errors
    /// Returns the error of the format.
    pub fn read(kind: TargetKind, bytes: Vec<u8>) -> Result<Self, TargetFileError> {
        let read = TargetFile::read(kind, &bytes)?;
        let hash = blake3::hash(&bytes);
        Ok(Self { read, bytes, hash })
    }
}

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
    run_blocking(move || {
        let _permit = permit;
        work()
    })
    .await
}

/// Returns the start of an error text, without control characters.
pub fn clean(reason: &str, most_chars: usize) -> String {
    let clean = reason.chars().map(|c| if c.is_control() { ' ' } else { c });
    clean.take(most_chars).collect()
}
