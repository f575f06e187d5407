//! Server process for benchmarks: this binary, on a free port and a temporary data directory.

use std::process::Stdio;
use std::time::Duration;

use anyhow::{Context, Result, bail};
use brood_protocol::Backend;
use tokio::io::{AsyncBufReadExt, BufReader};
use tokio::process::{Child, Command};
use tokio::time::timeout;

/// Server that runs until it is stopped or dropped.
pub struct OwnServer {
    child: Child,
    url: String,
    // Declared last: fields drop in order, and the directory must outlive the server.
    _data: tempfile::TempDir,
}

impl OwnServer {
    /// Starts the server and waits for its address.
    pub async fn start(workers: u16, backend: Backend) -> Result<Self> {
        let data = tempfile::tempdir().context("create a temporary directory")?;
        let binary = std::env::current_exe().context("find this binary")?;
        let mut child = Command::new(binary)
            .args(["serve", "--listen", "127.0.0.1:0", "--backend", backend.name()])
            .args(["--workers", &workers.to_string(), "--data"])
            .arg(data.path())
            .env("BROOD_LOG", std::env::var("BROOD_LOG").unwrap_or_else(|_| "error".to_owned()))
            .stdin(Stdio::null())
            .stdout(Stdio::piped())
            .kill_on_drop(true)
            .spawn()
            .context("start a server")?;
        let stdout = child.stdout.take().context("capture the server's output")?;
        let mut lines = BufReader::new(stdout).lines();
        let line = timeout(Duration::from_secs(30), lines.next_line())
            .await
            .context("wait for the server")?
            .context("read the server's address")?;
        let url = line.as_deref().and_then(|line| line.strip_prefix("brood is listening on "));
        let Some(url) = url.map(str::to_owned) else {
            bail!("the server ended without printing its address")
        };
        Ok(Self { child, url, _data: data })
    }

    /// URL of the server.
    pub fn url(&self) -> &str {
        &self.url
    }

    /// Kills the server; its data is temporary, so there is no clean shutdown.
    pub async fn stop(mut self) -> Result<()> {
        self.child.kill().await.context("stop the server")
    }
}
