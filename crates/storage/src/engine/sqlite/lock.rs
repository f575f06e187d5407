//! Lock of the data directory: at most one server per directory, for as long as lock and database
//! are in it.

use std::fs::{DirBuilder, File, Metadata, TryLockError};
use std::path::{Path, PathBuf};

use crate::StorageError;
use crate::error::Result;

/// Held while the write connection is open.
#[derive(Debug)]
pub(crate) struct DirectoryLock {
    _file: File,
    /// Files that must stay in the directory, as they were when it was opened.
    watched: Vec<(PathBuf, FileId)>,
}

/// Identity of a file: device and number on it.
type FileId = (u64, u64);

impl DirectoryLock {
    /// Creates the directory if needed and locks it.
    pub(crate) fn take(dir: &Path) -> Result<Self> {
        let mut builder = DirBuilder::new();
        builder.recursive(true);
        #[cfg(unix)]
        std::os::unix::fs::DirBuilderExt::mode(&mut builder, 0o700);
        builder.create(dir).map_err(StorageError::Directory)?;
        let path = dir.join("brood.lock");
        let mut options = File::options();
        options.create(true).truncate(false).write(true);
        let file = options.open(&path).map_err(StorageError::Directory)?;
        keep_private(&path).map_err(StorageError::Directory)?;
        match file.try_lock() {
            Ok(()) => Self { _file: file, watched: Vec::new() }.watching(path),
            Err(TryLockError::WouldBlock) => Err(StorageError::Locked),
            Err(TryLockError::Error(error)) => Err(StorageError::Directory(error)),
        }
    }

    /// Also watches a file, which must exist.
    pub(crate) fn watching(mut self, path: PathBuf) -> Result<Self> {
        let known = std::fs::metadata(&path).map_err(StorageError::Directory)?;
        self.watched.push((path, id(&known)));
        Ok(self)
    }

    /// True if lock and database are still in the directory. Otherwise writes go to files that
    /// cannot be opened again, or another server may have taken the lock.
    pub(crate) fn is_in_place(&self) -> bool {
        let same = |(path, known): &(PathBuf, FileId)| {
            std::fs::metadata(path).is_ok_and(|found| id(&found) == *known)
        };
        self.watched.iter().all(same)
    }
}

/// Takes the permissions of other users off a file, whatever the directory is. SQLite gives the
/// files beside the database the same permissions.
pub(crate) fn keep_private(path: &Path) -> std::io::Result<()> {
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        let permissions = std::fs::metadata(path)?.permissions();
        if permissions.mode() & 0o077 != 0 {
            std::fs::set_permissions(path, PermissionsExt::from_mode(0o600))?;
        }
    }
    #[cfg(not(unix))]
    let _ = path;
    Ok(())
}

#[cfg(unix)]
fn id(of: &Metadata) -> FileId {
    use std::os::unix::fs::MetadataExt;
    (of.dev(), of.ino())
}

/// Without numbers of files, a file that was replaced is taken for the same.
#[cfg(not(unix))]
fn id(_: &Metadata) -> FileId {
    (0, 0)
}
