//! Server under load: the measured binary on a free port, with a data directory of its own.

use std::fs;
use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdout, Stdio};

use anyhow::{Context, Result, bail};

use super::cgroup::CpuGroup;
use super::cpu;
use crate::shell;

/// Environment variable with the address of the PostgreSQL database.
const DATABASE: &str = "BROOD_DATABASE";

/// Server that is killed, and whose data are removed, when it is dropped.
pub struct Server {
    child: Child,
    url: String,
    data: PathBuf,
    /// Kept open, so that the server can write to it.
    _stdout: BufReader<ChildStdout>,
    /// Dropped after the process has ended.
    group: Option<CpuGroup>,
}

impl Server {
    /// Starts a server without workers, on SQLite or on a PostgreSQL database, and waits until it
    /// listens.
    pub fn start(brood: &Path, data: &Path, database: Option<&str>) -> Result<Self> {
        fs::create_dir_all(data).with_context(|| format!("create {}", data.display()))?;
        let mut command = shell::command(brood);
        command.args(["serve", "--listen", "127.0.0.1:0", "--workers", "0"]);
        command.arg("--data").arg(data).env("BROOD_LOG", "error").env_remove(DATABASE);
        if let Some(address) = database {
            command.env(DATABASE, address);
        }
        let mut child = command.stdout(Stdio::piped()).spawn().context("start a server")?;
        let mut stdout = BufReader::new(child.stdout.take().context("read a server's output")?);
        let mut line = String::new();
        let read = stdout.read_line(&mut line);
        let Some(url) = line.trim().strip_prefix("brood is listening on ") else {
            let _ = child.kill();
            let _ = child.wait();
            read.context("read a server's output")?;
            bail!("a server ended before it listened")
        };
        let url = url.trim_end_matches('/').to_owned();
        Ok(Self { child, url, data: data.to_owned(), _stdout: stdout, group: None })
    }

    /// Limits the server to this share of one processor.
    pub fn limit(&mut self, share: f64) -> Result<()> {
        let process = self.child.id();
        let group = CpuGroup::new(&format!("brood-scale-{process}"), share)?;
        group.add(process)?;
        self.group = Some(group);
        Ok(())
    }

    /// Adds a token of a scope; returns it.
    pub fn add_token(&self, brood: &Path, scope: &str, database: Option<&str>) -> Result<String> {
        let mut command = shell::command(brood);
        command.args(["token", "add", scope, "--scope", scope]).arg("--data").arg(&self.data);
        command.env_remove(DATABASE);
        if let Some(address) = database {
            command.env(DATABASE, address);
        }
        Ok(shell::output(&mut command)?.trim().to_owned())
    }

    /// URL of the server.
    pub fn url(&self) -> &str {
        &self.url
    }

    /// CPU time that it has used, in seconds.
    pub fn cpu_s(&self) -> Result<f64> {
        cpu::own(self.child.id())
    }
}

impl Drop for Server {
    fn drop(&mut self) {
        // It may have ended already.
        let _ = self.child.kill();
        let _ = self.child.wait();
        if let Err(error) = fs::remove_dir_all(&self.data) {
            eprintln!("cannot remove {}: {error}", self.data.display());
        }
    }
}
