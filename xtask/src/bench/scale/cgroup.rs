//! CPU quota of a process, by a cgroup of version 1 or 2. Needs root.

use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail};

/// Folders of the controller `cpu` of version 1.
const FIRST: [&str; 2] = ["/sys/fs/cgroup/cpu", "/sys/fs/cgroup/cpu,cpuacct"];
/// Folder of version 2.
const SECOND: &str = "/sys/fs/cgroup";
/// Time in which a process may use its quota, in microseconds. Shorter than the default of 100 ms,
/// so that a process that has used its quota waits less.
const PERIOD_US: u32 = 20_000;

/// Group of processes with a quota. Removed when it is dropped, after its processes have ended.
pub struct CpuGroup {
    folder: PathBuf,
}

impl CpuGroup {
    /// Creates a group whose processes together use at most this share of one processor.
    pub fn new(name: &str, share: f64) -> Result<Self> {
        let quota_us = (f64::from(PERIOD_US) * share).round();
        for root in FIRST.map(Path::new) {
            let group = Self { folder: root.join(name) };
            if !root.is_dir() || fs::create_dir(&group.folder).is_err() {
                continue;
            }
            if group.folder.join("cpu.cfs_quota_us").exists() {
                group.write("cpu.cfs_period_us", &PERIOD_US.to_string())?;
                group.write("cpu.cfs_quota_us", &quota_us.to_string())?;
                return Ok(group);
            }
        }
        let root = Path::new(SECOND);
        // Refused if it is enabled already.
        let _ = fs::write(root.join("cgroup.subtree_control"), "+cpu");
        let group = Self { folder: root.join(name) };
        if fs::create_dir(&group.folder).is_ok() && group.folder.join("cpu.max").exists() {
            group.write("cpu.max", &format!("{quota_us} {PERIOD_US}"))?;
            return Ok(group);
        }
        bail!(
            "no CPU quota can be set: neither {} nor {SECOND} with the controller `cpu` is writable; \
             run it as root, on a machine or in a container with writable cgroups",
            FIRST[0]
        )
    }

    /// Moves a process with its threads into the group.
    pub fn add(&self, process: u32) -> Result<()> {
        self.write("cgroup.procs", &process.to_string())
    }

    fn write(&self, file: &str, text: &str) -> Result<()> {
        let file = self.folder.join(file);
        fs::write(&file, text).with_context(|| format!("write {text} to {}", file.display()))
    }
}

impl Drop for CpuGroup {
    fn drop(&mut self) {
        // Missing if it could not be created.
        if self.folder.exists()
            && let Err(error) = fs::remove_dir(&self.folder)
        {
            eprintln!("cannot remove {}: {error}", self.folder.display());
        }
    }
}
