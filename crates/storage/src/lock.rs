//! Lock of the data directory: at most one server per directory.

use std::fs::{DirBuilder, File, TryLockError};
use std::path::Path;

use crate::StorageError;
use crate::error::Result;

/// Held while the write connection is open.
#[derive(Debug)]
pub(crate) struct DirectoryLock {
    _file: File,
}

impl DirectoryLock {
    /// Creates the directory if needed and locks it.
    pub(crate) fn take(dir: &Path) -> Result<Self> {
        let mut builder = DirBuilder::new();
        builder.recursive(true);
        #[cfg(unix)]
        std::os::unix::fs::DirBuilderExt::mode(&mut builder, 0o700);
        builder.create(dir).map_err(StorageError::Directory)?;
        let file = File::options()
            .create(true)
            .truncate(false)
            .write(true)
            .open(dir.join("brood.lock"))
            .map_err(StorageError::Directory)?;
        match file.try_lock() {
            Ok(()) => Ok(Self { _file: file }),
            Err(TryLockError::WouldBlock) => Err(StorageError::Locked),
            Err(TryLockError::Error(error)) => Err(StorageError::Directory(error)),
        }
    }
}
