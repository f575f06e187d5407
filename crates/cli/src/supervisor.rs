//! Worker processes of this binary: started, started again when they die, ended with the server.
//!
//! A worker's stdin is a pipe from here: it ends when the pipe closes, so no worker outlives its server however that
//! one ended. The token travels in the environment, where other users of the machine cannot read it.

use std::num::NonZeroUsize;
use std::process::{ExitStatus, Stdio};
use std::time::Duration;

use anyhow::{Context, Result};
use brood_protocol::Backend;
use brood_server::Undertaker;
use tokio::process::{Child, Command};
use tokio::task::JoinSet;
use tokio::time::{Instant, sleep, timeout};
use tokio_util::sync::CancellationToken;

/// The environment variable that carries a worker's token.
pub const TOKEN_VARIABLE: &str = "BROOD_TOKEN";
const FIRST_WAIT: Duration = Duration::from_millis(200);
const LONGEST_WAIT: Duration = Duration::from_secs(10);
/// A worker that lived this long did not die of its start.
const STEADY: Duration = Duration::from_secs(30);
const FAREWELL: Duration = Duration::from_secs(5);

/// How workers are started, and who is told when one dies.
#[derive(Clone)]
pub struct WorkerPlan {
    /// URL of the server.
    pub server: String,
    /// Token of scope work.
    pub token: String,
    /// Which evaluator.
    pub backend: Backend,
    /// Threads of each; all cores where absent.
    pub threads: Option<NonZeroUsize>,
    /// Whether they search instead of rendering.
    pub searches: bool,
    /// Told of each death.
    pub undertaker: Undertaker,
}

/// Keeps that many workers alive until `stop`, and where there is one, another that searches; then ends them.
pub async fn supervise(workers: u16, plan: WorkerPlan, stop: CancellationToken) {
    let mut keepers = JoinSet::new();
    for number in 1..=workers {
        keepers.spawn(keep(format!("local-{number}"), plan.clone(), stop.clone()));
    }
    if workers > 0 {
        let plan = WorkerPlan { searches: true, threads: None, ..plan };
        keepers.spawn(keep("search-1".to_owned(), plan, stop.clone()));
    }
    while keepers.join_next().await.is_some() {}
}

async fn keep(name: String, plan: WorkerPlan, stop: CancellationToken) {
    let mut wait = FIRST_WAIT;
    while !stop.is_cancelled() {
        let born = Instant::now();
        match start(&name, &plan) {
            Ok(mut child) => {
                tracing::debug!(name, pid = child.id(), "worker started");
                // Held here, because waiting for a child closes its stdin.
                let stdin = child.stdin.take();
                tokio::select! {
                    ended = child.wait() => {
                        report(&name, ended);
                        plan.undertaker.bury(&name).await;
                    }
                    () = stop.cancelled() => {
                        drop(stdin);
                        return end(&name, child).await;
                    }
                }
            }
            Err(error) => tracing::error!(name, "{error:#}"),
        }
        wait = if born.elapsed() > STEADY { FIRST_WAIT } else { (wait * 2).min(LONGEST_WAIT) };
        tokio::select! {
            () = sleep(wait) => {}
            () = stop.cancelled() => {}
        }
    }
}

fn start(name: &str, plan: &WorkerPlan) -> Result<Child> {
    let binary = std::env::current_exe().context("find this binary")?;
    let mut command = Command::new(binary);
    command
        .args(["worker", "--while-stdin-is-open", "--name", name])
        .args(["--server", &plan.server, "--backend", plan.backend.name()])
        .env(TOKEN_VARIABLE, &plan.token)
        .stdin(Stdio::piped())
        .stdout(Stdio::null())
        .kill_on_drop(true);
    if std::env::var_os("XDG_RUNTIME_DIR").is_none() {
        // Vulkan drivers look for a desktop there and complain on stderr where a server has none.
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
        Ok(status) => tracing::warn!(name, %status, "worker died; starting it again"),
        Err(error) => tracing::error!(name, %error, "worker lost"),
    }
}

async fn end(name: &str, mut child: Child) {
    if timeout(FAREWELL, child.wait()).await.is_err() {
        tracing::warn!(name, "worker does not end; killing it");
        if let Err(error) = child.kill().await {
            tracing::error!(name, %error, "worker cannot be killed");
        }
    }
}
