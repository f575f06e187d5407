//! Supervisor of the local worker processes: starts them, restarts them when they die or are
//! stopped, stops them with the server.
//!
//! A worker's stdin is a pipe from the supervisor, and the worker exits when it closes; so no
//! worker outlives its server, even if the server is killed. Its stdout is a pipe to the
//! supervisor, by which it shows that it runs. The token is passed in the environment, which other
//! users of the machine cannot read. Each worker has a process group of its own: Ctrl-C in a
//! terminal reaches the server alone, which then stops the workers in order.

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
/// Time between the exit of a worker and the stop of the server by one signal to all processes.
const SIGNAL_DELAY: Duration = Duration::from_millis(500);

/// Settings of the local workers.
#[derive(Clone)]
pub struct WorkerPlan {
    /// URL of the server.
    pub server: String,
    /// Start of the names of the workers, unique among the servers of a database.
    pub prefix: String,
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
    /// Cancelled by the signal that stops the server, before the workers are stopped.
    pub shutdown: CancellationToken,
}

/// Keeps `workers` rendering workers running until `stop`, then stops them.
pub async fn supervise(workers: u16, plan: WorkerPlan, stop: CancellationToken) {
    let mut tasks = JoinSet::new();
    for number in 1..=workers {
        let name = format!("{}local-{number}", plan.prefix);
        tasks.spawn(keep(name, plan.clone(), stop.clone()));
    }
    while tasks.join_next().await.is_some() {}
}

/// Keeps a worker that searches running until `stop` if there is at least one that renders, then
/// stops it.
pub async fn supervise_searches(workers: u16, plan: WorkerPlan, stop: CancellationToken) {
    if workers > 0 {
        let name = format!("{}search-1", plan.prefix);
        keep(name, WorkerPlan { searches: true, threads: None, ..plan }, stop).await;
    }
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
                        let is_stop = is_stop(&ended, &plan.shutdown).await;
                        plan.worker_reaper.requeue_jobs_of(&name, is_stop).await;
                        match is_stop {
                            true if plan.searches => return,
                            // The server still needs workers that render.
                            true => tracing::debug!(name, "worker was stopped; restarting it"),
                            false => report(&name, ended),
                        }
                    }
                    () = silent(stdout, limit) => {
                        tracing::warn!(name, "worker no longer reports that it runs; replacing it");
                        kill(&name, child).await;
                        plan.worker_reaper.requeue_jobs_of(&name, false).await;
                    }
                    () = stop.cancelled() => {
                        drop(stdin);
                        end(&name, child).await;
                        // A killed worker has returned nothing. If the server has ended, its own
                        // end has requeued the jobs, and this does nothing.
                        return plan.worker_reaper.requeue_jobs_of(&name, true).await;
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
        .env_remove("BROOD_TOKEN_FILE")
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .kill_on_drop(true);
    #[cfg(unix)]
    command.process_group(0);
    // Those of the object store.
    for (name, _) in std::env::vars_os() {
        if name.to_string_lossy().starts_with("AWS_") {
            command.env_remove(name);
        }
    }
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

/// True if a worker has exited cleanly and the server stops too, within [`SIGNAL_DELAY`]: a signal
/// was sent to all processes, as in a container.
async fn is_stop(ended: &std::io::Result<ExitStatus>, shutdown: &CancellationToken) -> bool {
    ended.as_ref().is_ok_and(ExitStatus::success)
        && timeout(SIGNAL_DELAY, shutdown.cancelled()).await.is_ok()
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

#[cfg(all(test, unix))]
mod tests {
    use std::os::unix::process::ExitStatusExt;

    use super::*;

    #[tokio::test]
    async fn exit_of_a_worker_is_a_stop_only_without_error_and_while_the_server_stops() {
        let shutdown = CancellationToken::new();
        let exit = |status| Ok(ExitStatus::from_raw(status));
        assert!(!is_stop(&exit(0), &shutdown).await);
        shutdown.cancel();
        assert!(is_stop(&exit(0), &shutdown).await);
        assert!(!is_stop(&exit(9), &shutdown).await);
    }
}
