//! Files of exports: in a folder of the data directory with SQLite, in the database with
//! PostgreSQL, since several servers share the database but no folder.

use brood_protocol::JobId;
use brood_storage::{Store, StoredExportFile};
use bytes::Bytes;
use tokio_util::sync::CancellationToken;
use tokio_util::task::TaskTracker;

use crate::export_folder::ExportFolder;
use crate::problem::ApiError;
use crate::processors::run_blocking;

/// Place of the files of all exports.
#[derive(Debug, Clone)]
pub enum ExportFiles {
    /// Folder of the data directory.
    Folder(ExportFolder),
    /// Rows of the database.
    Rows {
        /// Database.
        store: Store,
        /// Tasks that remove files.
        tasks: TaskTracker,
        /// Cancelled when the server begins to stop.
        stopping: CancellationToken,
    },
}

impl ExportFiles {
    /// Writes a file that survives a loss of power. Returns its bytes instead if they are to be
    /// stored with its record.
    ///
    /// # Errors
    /// 507 if the disk is full.
    pub async fn write(
        &self,
        job: JobId,
        number: u32,
        bytes: Vec<u8>,
    ) -> Result<Option<Vec<u8>>, ApiError> {
        match self {
            Self::Folder(folder) => {
                let folder = folder.clone();
                run_blocking(move || folder.write(job, number, &bytes)).await?.map_err(disk)?;
                Ok(None)
            }
            Self::Rows { .. } => Ok(Some(bytes)),
        }
    }

    /// Returns the numbers of recorded files that are missing or have another size.
    ///
    /// # Errors
    /// [`ApiError`] if the store fails.
    pub async fn lost(&self, job: JobId, files: &[StoredExportFile]) -> Result<Vec<u32>, ApiError> {
        match self {
            Self::Folder(folder) => {
                Ok(without(files, |file| folder.has(job, file.number, file.bytes)))
            }
            Self::Rows { store, .. } => {
                let sizes = store.export_file_sizes(job).await?;
                let size = |number: u32| sizes.get(&number).copied().unwrap_or(0);
                Ok(without(files, |file| size(file.number) == file.bytes))
            }
        }
    }

    /// Reads a file.
    ///
    /// # Errors
    /// 404 or 500 if it is lost.
    pub async fn read(&self, job: JobId, file: &StoredExportFile) -> Result<Bytes, ApiError> {
        match self {
            Self::Folder(folder) => {
                let path = folder.path(job, file.number);
                let read = run_blocking(move || std::fs::read(path)).await?;
                Ok(read.map_err(|error| ApiError::internal(error.to_string()))?.into())
            }
            Self::Rows { store, .. } => {
                Ok(store.read_export_file((job, file.number), file.bytes).await?.into())
            }
        }
    }

    /// Deletes the files of a job of which none is recorded any more. What cannot be deleted is
    /// deleted at the next start, or by [`Self::remove_unused`].
    pub async fn remove(&self, job: JobId) {
        match self {
            Self::Folder(folder) => {
                let folder = folder.clone();
                let removed = run_blocking(move || folder.remove(job)).await;
                if !matches!(removed, Ok(Ok(()))) {
                    tracing::warn!(%job, "files of an export cannot be deleted");
                }
            }
            Self::Rows { .. } => self.remove_unused(),
        }
    }

    /// Deletes files in the database that are not recorded, in a task: it takes seconds for
    /// gigabytes.
    pub fn remove_unused(&self) {
        let Self::Rows { store, tasks, stopping } = self else { return };
        let (store, stopping) = (store.clone(), stopping.clone());
        tasks.spawn(async move {
            let removal = stopping.run_until_cancelled(store.remove_unused_export_files()).await;
            if let Some(Err(error)) = removal {
                tracing::warn!(%error, "files of exports are deleted later");
            }
        });
    }
}

/// Returns the numbers of the files that are not there.
fn without(files: &[StoredExportFile], has: impl Fn(&StoredExportFile) -> bool) -> Vec<u32> {
    files.iter().filter(|file| !has(file)).map(|file| file.number).collect()
}

fn disk(error: std::io::Error) -> ApiError {
    match error.kind() {
        std::io::ErrorKind::StorageFull | std::io::ErrorKind::QuotaExceeded => {
            ApiError::disk_full("an export needs more space").with_inner(error.to_string())
        }
        _ => ApiError::internal(error.to_string()),
    }
}
