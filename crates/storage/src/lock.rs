//! The lock of the data directory: one server a directory. Owns the lock file; refuses to know what else is there.

use std::fs::{DirBuilder, File, TryLockError};
use std::path::Path;

use crate::StorageError;

/// Held for as long as the write connection is open.
#[derive(Debug)]
pub(crate) struct DirectoryLock {
    _file: File,
}

impl DirectoryLock {
    /// Makes the directory where it is missing, and takes its lock.
    pub(crate) fn take(dir: &Path) -> Result<Self, StorageError> {
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
