//! `brood worker`: renders for a server, or searches for it, on this machine or another.

use std::io::Read;
use std::num::NonZeroUsize;
use std::time::Duration;

use anyhow::{Context, Result};
use brood_protocol::Backend;
use brood_worker::{SearcherConfig, WorkerConfig};
use clap::Args;
use tokio_util::sync::CancellationToken;

use crate::supervisor::TOKEN_VARIABLE;
use crate::{logging, place, serve};

/// The lowest priority that there is.
#[cfg(unix)]
const LAST: i32 = 19;

/// Options of `brood worker`.
#[derive(Args)]
pub struct WorkerArgs {
    /// URL of the server
    #[arg(long, value_name = "URL")]
    server: String,
    /// A token of scope work
    #[arg(long, value_name = "TOKEN", env = TOKEN_VARIABLE, hide_env_values = true)]
    token: String,
    /// auto, cpu, gpu or reference
    #[arg(long, value_name = "BACKEND", default_value = "auto")]
    backend: Backend,
    /// What the server calls it; the machine's name and the process id unless said
    #[arg(long, value_name = "NAME")]
    name: Option<String>,
    /// Threads that render; all cores unless said
    #[arg(long, value_name = "N")]
    threads: Option<NonZeroUsize>,
    /// Room for sample sets and meshes
    #[arg(long, value_name = "MIB", default_value_t = 512)]
    cache_mib: u64,
    /// Search instead of rendering, with what other programs leave of the processors
    #[arg(long)]
    searches: bool,
    /// End when stdin is closed
    #[arg(long, hide = true)]
    while_stdin_is_open: bool,
}

/// Runs the command until SIGINT or SIGTERM, or until the server refuses the token.
pub fn run(args: WorkerArgs) -> Result<()> {
    logging::start_service();
    if args.searches {
        // Before any thread is started: on Linux each has a priority of its own, which it gets from the one that starts it.
        step_back();
    }
    let runtime = place::runtime()?;
    let result = runtime.block_on(work(args));
    // A render that nobody waits for any more must not hold the process back.
    runtime.shutdown_timeout(Duration::from_millis(100));
    result
}

/// Lets everything else go first: whoever breeds by eye must not wait for a search.
fn step_back() {
    #[cfg(unix)]
    if let Err(error) = rustix::process::nice(LAST) {
        tracing::warn!(%error, "searches run at the priority of everything else");
    }
}

async fn work(args: WorkerArgs) -> Result<()> {
    let shutdown = serve::shutdown_on_signal()?;
    if args.while_stdin_is_open {
        // A thread rather than async stdin, which would keep the runtime from ending.
        let shutdown: CancellationToken = shutdown.clone();
        std::thread::Builder::new()
            .name("stdin".to_owned())
            .spawn(move || {
                let mut byte = [0];
                while matches!(std::io::stdin().read(&mut byte), Ok(1)) {}
                shutdown.cancel();
            })
            .context("watch stdin")?;
    }
    if args.searches {
        let config = SearcherConfig {
            server: args.server,
            token: args.token,
            name: args.name.unwrap_or_else(default_name),
            threads: args.threads,
        };
        return Ok(brood_worker::run_searches(config, shutdown).await?);
    }
    let config = WorkerConfig {
        server: args.server,
        token: args.token,
        backend: args.backend,
        name: args.name.unwrap_or_else(default_name),
        threads: args.threads,
        cache_bytes: args.cache_mib << 20,
    };
    Ok(brood_worker::run(config, shutdown).await?)
}

fn default_name() -> String {
    let host = std::env::var("HOSTNAME").ok().filter(|name| !name.is_empty());
    format!("{}-{}", host.as_deref().unwrap_or("worker"), std::process::id())
}
