//! Supervisor of the local worker processes: starts them, restarts them when they die or are
//! stopped, stops them with the server.
//!
//! A worker's stdin is a pipe from the supervisor, and the worker exits when it closes; so no
//! worker outlives its server, even if the server is killed. Its stdout is a pipe to the
//! supervisor, by which it shows that it runs. The token is passed in the
//! environment, which other users of the machine cannot read.

use std::num::NonZeroUsize;
use std::process::{ExitStatus, Stdio};
use std::time::Duration;

use anyhow::{Context, Result};
use brood_protocol::{Backend, TOKEN_VARIABLE};
use brood_server::WorkerReaper;
use tokio::io::AsyncReadExt;
use tokio::process::{Child, ChildStdout, Command};
use tokio::task::JoinSet;
use tokio::time::{Instant, sleep, timeout};
use tokio_util::sync::CancellationToken;

/// Delay before the first restart; doubled after each early death.
const INITIAL_BACKOFF: Duration = Duration::from_millis(200);
/// Largest delay before a restart.
const MAX_BACKOFF: Duration = Duration::from_secs(10);
/// A worker that ran longer than this resets the back-off.
const STABLE_AFTER: Duration = Duration::from_secs(30);
/// Time without output after which a worker is replaced: one that renders, and one that searches at
/// the lowest priority.
const SILENT: Duration = Duration::from_secs(4);
const SEARCHER_SILENT: Duration = Duration::from_secs(30);
/// Time for a worker to exit before it is killed.
const STOP_TIMEOUT: Duration = Duration::from_secs(5);

/// Settings of the local workers.
#[derive(Clone)]
pub struct WorkerPlan {
    /// URL of the server.
    pub server: String,
    /// Token of scope work.
    pub token: String,
    /// Evaluator.
    pub backend: Backend,
    /// Number of threads of each worker; all cores if absent.
    pub threads: Option<NonZeroUsize>,
    /// True if the worker searches instead of rendering.
    pub searches: bool,
    /// Notified of each worker that died.
    pub worker_reaper: WorkerReaper,
}

/// Keeps `workers` rendering workers running until `stop`, plus one search worker if there is at
/// least one, then stops them.
pub async fn supervise(workers: u16, plan: WorkerPlan, stop: CancellationToken) {
    let mut tasks = JoinSet::new();
    for number in 1..=workers {
        tasks.spawn(keep(format!("local-{number}"), plan.clone(), stop.clone()));
    }
    if workers > 0 {
        let plan = WorkerPlan { searches: true, threads: None, ..plan };
        tasks.spawn(keep("search-1".to_owned(), plan, stop.clone()));
    }
    while tasks.join_next().await.is_some() {}
}

/// Runs one worker until `stop`: starts it again when it dies, after a delay that grows while
/// deaths are frequent, and returns its jobs to their queues.
async fn keep(name: String, plan: WorkerPlan, stop: CancellationToken) {
    let mut backoff = INITIAL_BACKOFF;
    while !stop.is_cancelled() {
        let started = Instant::now();
        match start(&name, &plan) {
            Ok(mut child) => {
                tracing::debug!(name, pid = child.id(), "worker started");
                // Taken out of the child, because `wait` closes its stdin.
                let (stdin, stdout) = (child.stdin.take(), child.stdout.take());
                let limit = if plan.searches { SEARCHER_SILENT } else { SILENT };
                tokio::select! {
                    ended = child.wait() => {
                        report(&name, ended);
                        plan.worker_reaper.requeue_jobs_of(&name).await;
                    }
                    () = silent(stdout, limit) => {
                        tracing::warn!(name, "worker no longer reports that it runs; replacing it");
                        kill(&name, child).await;
                        plan.worker_reaper.requeue_jobs_of(&name).await;
                    }
                    () = stop.cancelled() => {
                        drop(stdin);
                        return end(&name, child).await;
                    }
                }
            }
            Err(error) => tracing::error!(name, "{error:#}"),
        }
        let is_stable = started.elapsed() > STABLE_AFTER;
        backoff = if is_stable { INITIAL_BACKOFF } else { (backoff * 2).min(MAX_BACKOFF) };
        tokio::select! {
            () = sleep(backoff) => {}
            () = stop.cancelled() => {}
        }
    }
}

/// Starts a worker process.
fn start(name: &str, plan: &WorkerPlan) -> Result<Child> {
    let binary = std::env::current_exe().context("find this binary")?;
    let mut command = Command::new(binary);
    command
        .args(["worker", "--while-stdin-is-open", "--name", name])
        .args(["--server", &plan.server, "--backend", plan.backend.name()])
        .env(TOKEN_VARIABLE, &plan.token)
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .kill_on_drop(true);
    if std::env::var_os("XDG_RUNTIME_DIR").is_none() {
        // Without this, Vulkan drivers print warnings about the missing directory on servers.
        command.env("XDG_RUNTIME_DIR", std::env::temp_dir());
    }
    if plan.searches {
        command.arg("--searches");
    }
    if let Some(threads) = plan.threads {
        command.args(["--threads", &threads.to_string()]);
    }
    command.spawn().context("start a worker")
}

fn report(name: &str, ended: std::io::Result<ExitStatus>) {
    match ended {
        Ok(status) => tracing::warn!(name, %status, "worker died; restarting it"),
        Err(error) => tracing::error!(name, %error, "waiting for the worker failed"),
    }
}

/// Waits for a worker whose stdin was closed, and kills it if it does not exit in time.
async fn end(name: &str, mut child: Child) {
    if timeout(STOP_TIMEOUT, child.wait()).await.is_err() {
        tracing::warn!(name, "worker did not stop in time; killing it");
        kill(name, child).await;
    }
}

async fn kill(name: &str, mut child: Child) {
    if let Err(error) = child.kill().await {
        tracing::error!(name, %error, "worker cannot be killed");
    }
}

/// Completes once the worker has written nothing for this time. Never if stdout is closed: then the
/// process is ending.
async fn silent(stdout: Option<ChildStdout>, limit: Duration) {
    let Some(mut stdout) = stdout else { return std::future::pending().await };
    let mut beats = [0; 64];
    loop {
        match timeout(limit, stdout.read(&mut beats)).await {
            Ok(Ok(count)) if count > 0 => {}
            Ok(_) => std::future::pending().await,
            Err(_) => return,
        }
    }
}
