//! Files of exports on disk: one folder for each job, one file for each number. A file is complete
//! once it has its name.

use std::collections::HashSet;
use std::fs::{self, File};
use std::io::{self, ErrorKind, Write as _};
use std::path::{Path, PathBuf};

use brood_protocol::JobId;

/// Folder of all exports.
#[derive(Debug, Clone)]
pub struct ExportFolder {
    root: PathBuf,
}

impl ExportFolder {
    /// Opens the folder, and deletes what belongs to none of these jobs.
    ///
    /// # Errors
    /// Returns the error of the file system.
    pub fn open(root: PathBuf, known: &HashSet<JobId>) -> io::Result<Self> {
        fs::create_dir_all(&root)?;
        for entry in fs::read_dir(&root)? {
            let entry = entry?;
            let id = entry.file_name().to_str().and_then(|name| name.parse().ok());
            if id.is_none_or(|id| !known.contains(&id)) {
                fs::remove_dir_all(entry.path())?;
            }
        }
        Ok(Self { root })
    }

    /// Path of a file.
    pub fn path(&self, job: JobId, number: u32) -> PathBuf {
        self.of(job).join(number.to_string())
    }

    /// Writes a file so that it survives a loss of power.
    ///
    /// # Errors
    /// Returns the error of the file system.
    pub fn write(&self, job: JobId, number: u32, bytes: &[u8]) -> io::Result<()> {
        let (folder, path) = (self.of(job), self.path(job, number));
        fs::create_dir_all(&folder)?;
        let partial = path.with_extension("partial");
        let mut file = File::create(&partial)?;
        file.write_all(bytes)?;
        file.sync_all()?;
        fs::rename(&partial, &path)?;
        sync(&folder)?;
        sync(&self.root)
    }

    /// True if a file is complete and has this size.
    pub fn has(&self, job: JobId, number: u32, bytes: u64) -> bool {
        fs::metadata(self.path(job, number)).is_ok_and(|meta| meta.len() == bytes)
    }

    /// Deletes the files of a job.
    ///
    /// # Errors
    /// Returns the error of the file system.
    pub fn remove(&self, job: JobId) -> io::Result<()> {
        match fs::remove_dir_all(self.of(job)) {
            Err(error) if error.kind() == ErrorKind::NotFound => Ok(()),
            other => other,
        }
    }

    fn of(&self, job: JobId) -> PathBuf {
        self.root.join(job.to_string())
    }
}

/// Flushes the entries of a folder.
fn sync(folder: &Path) -> io::Result<()> {
    #[cfg(unix)]
    File::open(folder)?.sync_all()?;
    #[cfg(not(unix))]
    let _ = folder;
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_of_unknown_jobs_are_deleted_and_others_kept() {
        let dir = tempfile::TempDir::new().unwrap();
        let root = dir.path().join("exports");
        let folder = ExportFolder::open(root.clone(), &HashSet::new()).unwrap();
        let (kept, lost) = (JobId::fresh(), JobId::fresh());
        folder.write(kept, 3, b"abc").unwrap();
        folder.write(kept, 3, b"abcd").unwrap();
        folder.write(lost, 0, b"").unwrap();
        let folder = ExportFolder::open(root, &HashSet::from([kept])).unwrap();
        assert!(folder.has(kept, 3, 4) && !folder.has(kept, 3, 3) && !folder.has(kept, 0, 4));
        assert!(!folder.has(lost, 0, 0));
        folder.remove(kept).unwrap();
        folder.remove(kept).unwrap();
        assert!(!folder.has(kept, 3, 4));
    }
}
