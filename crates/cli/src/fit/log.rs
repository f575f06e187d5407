//! NDJSON log of a search's generations: the lines of `GET /v1/jobs/{id}/log` without individuals.

use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};
use std::time::Duration;

use anyhow::{Context, Result};
use brood_search::{Probe, Progress};
use serde_json::json;

/// Log that is written while the search runs.
pub struct Log {
    path: PathBuf,
    file: BufWriter<File>,
    /// First write error; the search continues without its log and `finish` returns it.
    error: Option<std::io::Error>,
}

impl Log {
    /// Creates or replaces the file.
    pub fn create(path: &Path) -> Result<Self> {
        let file = File::create(path).with_context(|| format!("write {}", path.display()))?;
        Ok(Self { path: path.to_owned(), file: BufWriter::new(file), error: None })
    }

    /// Appends a generation; unknown values are null.
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
        // Flushed per line, so that the log can be followed.
        let written = writeln!(self.file, "{line}").and_then(|()| self.file.flush());
        if let Err(error) = written {
            self.error.get_or_insert(error);
        }
    }

    /// Returns an error if any line was not written.
    pub fn finish(self) -> Result<()> {
        let done = self.error.map_or(Ok(()), Err);
        done.with_context(|| format!("write {}", self.path.display()))
    }
}
