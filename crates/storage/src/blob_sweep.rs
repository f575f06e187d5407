//! Removal of objects that no row has: those of removed rows, and those whose server ended before
//! it had written the row.
//!
//! A name is given once, and a row gets it within an hour after the object was written. So an
//! object that is a day old and has no row gets none while it is removed.

use std::time::Duration;

use futures::TryStreamExt as _;
use tokio::time::timeout;

use crate::blob_join::{assert_owner, used_objects};
use crate::error::Result;
use crate::{StorageError, Store};

/// Time for a page of the list of objects.
const PAGE: Duration = Duration::from_secs(60);
/// Number of failed removals after which a sweep ends.
const FAILURES: u32 = 3;

impl Store {
    /// Removes the objects without a row that are older than `age` by the clock of the object
    /// store. Returns their number; 0 without an object store.
    ///
    /// # Errors
    /// Returns [`StorageError::BlobsUnreachable`] if the object store does not answer or another
    /// database owns its folder, others if the database cannot be read.
    pub async fn sweep_blobs(&self, age: Duration) -> Result<u64> {
        let Some(blobs) = self.blobs() else { return Ok(0) };
        assert_owner(self, blobs).await?;
        let now_ms = blobs.probe().await?;
        let age_ms = i64::try_from(age.as_millis()).unwrap_or(i64::MAX);
        let (mut pages, mut removed, mut failures) = (blobs.list(), 0, 0);
        loop {
            let page = timeout(PAGE, pages.try_next()).await.map_err(|_| {
                StorageError::BlobsUnreachable(format!("{}: no list in time", blobs.address()))
            })?;
            let Some(page) = page? else { return Ok(removed) };
            let is_old = |changed_ms: i64| now_ms.saturating_sub(changed_ms) >= age_ms;
            let old = page.into_iter().filter(|found| is_old(found.changed_ms));
            let names: Vec<String> = old.map(|found| found.name).collect();
            let (Some(first), Some(last)) = (names.iter().min(), names.iter().max()) else {
                continue;
            };
            assert_owner(self, blobs).await?;
            // Read after the list: a row that is written meanwhile has a newer object.
            let used =
                used_objects(&mut self.reader().await?, (first.as_str(), last.as_str())).await?;
            for name in names.iter().filter(|name| !used.contains(*name)) {
                match blobs.remove(name).await {
                    Ok(()) => removed += 1,
                    Err(error) => {
                        failures += 1;
                        if failures == FAILURES {
                            return Err(error);
                        }
                    }
                }
            }
        }
    }
}
