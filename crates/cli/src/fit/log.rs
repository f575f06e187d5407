//! The generations of a search as NDJSON: the lines of `GET /v1/jobs/{id}/log`, but for individuals.

use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};
use std::time::Duration;

use anyhow::{Context, Result};
use brood_search::{Probe, Progress};
use serde_json::json;

/// A log that is written as the search goes on.
pub struct Log {
    path: PathBuf,
    file: BufWriter<File>,
    /// The first trouble: a search does not end for its log.
    trouble: Option<std::io::Error>,
}

impl Log {
    /// Begins one, in the place of what was there.
    pub fn create(path: &Path) -> Result<Self> {
        let file = File::create(path).with_context(|| format!("write {}", path.display()))?;
        Ok(Self { path: path.to_owned(), file: BufWriter::new(file), trouble: None })
    }

    /// A generation more. What is not known yet is null.
    pub fn add(&mut self, progress: &Progress, probe: &Probe, elapsed: Duration) {
        let line = json!({
            "generation": progress.generation,
            "evaluations": progress.evaluations,
            "fitted": progress.fitted,
            "held": progress.held,
            "median": probe.median,
            "diversity": probe.diversity,
            "repeats": probe.repeats,
            "members": probe.members,
            "seconds": elapsed.as_secs_f64(),
        });
        // Whoever watches sees each line as it comes.
        let written = writeln!(self.file, "{line}").and_then(|()| self.file.flush());
        if let Err(error) = written {
            self.trouble.get_or_insert(error);
        }
    }

    /// Tells whether everything is on the disk.
    pub fn finish(self) -> Result<()> {
        let done = self.trouble.map_or(Ok(()), Err);
        done.with_context(|| format!("write {}", self.path.display()))
    }
}
