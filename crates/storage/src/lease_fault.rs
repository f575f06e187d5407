//! Failed writes of leases: while the database cannot be written, no lease can be renewed.

use std::sync::Mutex;
use std::time::{Duration, Instant};

use crate::StorageError;
use crate::error::Result;

/// Time after a failed write of a lease in which no lease expires: workers renew theirs as soon as
/// the database can be written again.
pub(crate) const RENEWAL: Duration = Duration::from_secs(20);
/// Time after a failed write of a lease in which an expired lease does not count as a death.
pub(crate) const FORGIVEN: Duration = Duration::from_secs(60);

/// Failed writes of leases: the disk is full, or PostgreSQL cannot be reached.
#[derive(Debug, Default)]
pub(crate) struct LeaseFaults {
    last: Mutex<Option<Instant>>,
}

impl LeaseFaults {
    /// Notes the result of a write.
    pub(crate) fn note<T>(&self, written: &Result<T>) {
        let is_fault = |error: &StorageError| {
            !matches!(error, StorageError::Conflict { .. } | StorageError::NotFound)
        };
        if written.as_ref().is_err_and(is_fault) {
            *self.last.lock().expect("nothing panics under this lock") = Some(Instant::now());
        }
    }

    /// Moves the last fault into the past.
    #[cfg(test)]
    pub(crate) fn pass(&self, time: Duration) {
        let mut last = self.last.lock().expect("nothing panics under this lock");
        *last = last.and_then(|last| last.checked_sub(time));
    }

    /// True if the last fault was within this time.
    pub(crate) fn is_within(&self, time: Duration) -> bool {
        let last = *self.last.lock().expect("nothing panics under this lock");
        last.is_some_and(|last| last.elapsed() < time)
    }
}
