//! Large files of rows in an object store: uploads and checkpoints of searches over 1 MiB.
//!
//! A row has its file, or the name of an object in the column `object`. The object is written
//! before the row, and removed after it. `blob_sweep` removes what a lost server leaves behind.

use std::time::{Duration, SystemTime};

use crate::blob_join::confirm_owner;
use crate::blob_store::{BlobKind, Blobs};
use crate::error::Result;
use crate::sql::{Conn, Query, SqlRow, query};
use crate::{StorageError, Store};

/// Most bytes of a file in a row, if there is an object store.
pub(crate) const ROW_BYTES: usize = 1 << 20;
/// Time in which the row of an object must be written. Objects without a row are removed after a
/// day.
const WRITE: Duration = Duration::from_secs(3600);
/// Time for which a replaced object is kept, for a standby of PostgreSQL that is behind.
const KEPT: Duration = Duration::from_secs(600);

/// Place of a file: a row or an object.
#[derive(Debug, Clone, Default)]
pub(crate) struct PlacedFile {
    /// The file, if it is in the row.
    pub bytes: Option<Vec<u8>>,
    /// Name of the object with the file.
    pub object: Option<String>,
    /// Address of the object's store.
    store: String,
    /// Time at which the object was written.
    written: Option<SystemTime>,
}

impl PlacedFile {
    /// File in a row.
    pub fn in_row(bytes: Vec<u8>) -> Self {
        Self { bytes: Some(bytes), ..Self::default() }
    }

    /// Allows a transaction to store the name of the object: the store is still that of the
    /// database, and stays so until the transaction has ended.
    ///
    /// # Errors
    /// Returns [`StorageError::BlobsUnreachable`] if the database has another store now,
    /// [`StorageError::Busy`] if the object is so old that it may be removed.
    pub async fn admit(&self, conn: &mut Conn) -> Result<()> {
        let Some(written) = self.written else { return Ok(()) };
        let is_late = written.elapsed().is_ok_and(|age| age > WRITE);
        if is_late {
            return Err(StorageError::Busy);
        }
        let lock = query("SELECT id FROM blob_store WHERE address = ? /*pg: FOR SHARE*/");
        match lock.bind(self.store.as_str()).fetch_optional(conn).await? {
            Some(_) => Ok(()),
            None => Err(StorageError::BlobsUnreachable(format!(
                "{}: the database has another store now; restart this server",
                self.store
            ))),
        }
    }
}

impl Store {
    /// Writes a file to the object store if it is large and there is one. The row that gets it is
    /// written afterwards.
    ///
    /// # Errors
    /// Returns [`StorageError::BlobsUnreachable`] if the store does not take it.
    pub(crate) async fn place_file(&self, kind: BlobKind, bytes: Vec<u8>) -> Result<PlacedFile> {
        match self.blobs() {
            Some(blobs) if bytes.len() > ROW_BYTES => {
                confirm_owner(self, blobs).await?;
                let written = Some(SystemTime::now());
                let object = Some(blobs.put(kind, bytes).await?);
                Ok(PlacedFile { bytes: None, object, store: blobs.address().to_string(), written })
            }
            _ => Ok(PlacedFile::in_row(bytes)),
        }
    }

    /// Removes an object that has never had a row, in the background. If that fails, the sweep
    /// removes it.
    pub(crate) fn discard_object(&self, object: Option<String>) {
        self.discard_after(Duration::ZERO, object);
    }

    /// Removes an object that was replaced, in the background after a while. If that fails, the
    /// sweep removes it.
    pub(crate) fn discard_replaced(&self, object: Option<String>) {
        self.discard_after(KEPT, object);
    }

    fn discard_after(&self, time: Duration, object: Option<String>) {
        let (Some(blobs), Some(object)) = (self.blobs().cloned(), object) else { return };
        tokio::spawn(async move {
            tokio::time::sleep(time).await;
            // The failure is logged.
            let _ = blobs.remove(&object).await;
        });
    }

    /// Reads a row with a file, from the columns `file` and `object` of a query.
    ///
    /// # Errors
    /// Returns [`StorageError::NotFound`] if there is no row, [`StorageError::BlobsUnreachable`] if
    /// the object store does not answer.
    pub(crate) async fn read_file(
        &self,
        select: impl Fn() -> Query + Send,
    ) -> Result<(SqlRow, Vec<u8>)> {
        let mut missed: Option<String> = None;
        loop {
            let row = select().fetch_one(&mut self.reader().await?).await?;
            let bytes: Option<Vec<u8>> = row.column("file")?;
            if let Some(bytes) = bytes {
                return Ok((row, bytes));
            }
            let object: String = row.column("object")?;
            // The row may have got another object since it was read.
            if missed.as_ref() == Some(&object) {
                return Err(StorageError::BlobDamaged(object));
            }
            match self.object(&object).await? {
                Some(bytes) => return Ok((row, bytes)),
                None => missed = Some(object),
            }
        }
    }

    /// Returns an object; `None` if it was removed.
    ///
    /// # Errors
    /// Returns [`StorageError::BlobsUnreachable`] if the object store does not answer.
    pub(crate) async fn object(&self, name: &str) -> Result<Option<Vec<u8>>> {
        let blobs = blobs_of(self.blobs().map(AsRef::as_ref))?;
        let found = blobs.get(name).await?;
        if found.is_none() {
            // A store at another endpoint does not have it either.
            confirm_owner(self, blobs).await?;
        }
        Ok(found)
    }
}

/// Returns the object store. Error for a server that was started before another one used it.
fn blobs_of(blobs: Option<&Blobs>) -> Result<&Blobs> {
    blobs.ok_or_else(|| {
        let reason = "of the database: restart this server with --blobs".to_owned();
        tracing::error!(reason, "a file is in an object store, and this server has none");
        StorageError::BlobsUnreachable(reason)
    })
}
