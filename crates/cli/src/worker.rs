//! `brood worker`: renders, or searches and exports, for a server, on this machine or another.

use std::io::{Read, Write};
use std::num::NonZeroUsize;
use std::path::PathBuf;
use std::time::Duration;

use anyhow::{Context, Result, bail};
use brood_bench::logging;
use brood_protocol::{Backend, TOKEN_VARIABLE, random_bytes};
use brood_worker::{SearcherConfig, WorkerConfig};
use clap::Args;
use tokio_util::sync::CancellationToken;

use crate::{place, secret, serve};

/// Interval of the bytes by which a supervisor sees that its worker runs.
const BEAT: Duration = Duration::from_millis(500);
/// Lowest scheduling priority.
#[cfg(unix)]
const LOWEST_PRIORITY: i32 = 19;

/// Options of `brood worker`.
#[derive(Args)]
pub struct WorkerArgs {
    /// URL of the server: http, or https behind a proxy with TLS
    #[arg(long, value_name = "URL", env = "BROOD_SERVER")]
    server: String,
    /// Token of scope work
    #[arg(long, value_name = "TOKEN", env = TOKEN_VARIABLE, hide_env_values = true)]
    #[arg(required_unless_present = "token_file")]
    token: Option<String>,
    /// File with the token
    #[arg(long, value_name = "FILE", env = "BROOD_TOKEN_FILE", conflicts_with = "token")]
    token_file: Option<PathBuf>,
    /// Evaluator: auto, cpu, gpu or reference
    #[arg(long, value_name = "BACKEND", env = "BROOD_BACKEND", default_value = "auto")]
    backend: Backend,
    /// Name of the worker; by default the host name and a random number
    #[arg(long, value_name = "NAME")]
    name: Option<String>,
    /// Number of threads; all cores by default
    #[arg(long, value_name = "N")]
    threads: Option<NonZeroUsize>,
    /// Largest size of the cache of sample sets, meshes and files in MiB
    #[arg(long, value_name = "MIB", default_value_t = 256)]
    cache_mib: u64,
    /// Search and export instead of rendering, at the lowest CPU priority
    #[arg(long)]
    searches: bool,
    /// Exit when stdin is closed, and write a byte to stdout every half a second
    #[arg(long, hide = true)]
    while_stdin_is_open: bool,
}

/// Runs the command until SIGINT, SIGTERM, or until the server rejects the token.
pub fn run(args: WorkerArgs) -> Result<()> {
    logging::start_service();
    if args.searches {
        // Before any thread starts: on Linux priority is per thread and inherited from the parent
        // thread.
        lower_priority();
    }
    let runtime = place::runtime()?;
    let result = runtime.block_on(work(args));
    // An unfinished render must not delay the exit.
    runtime.shutdown_timeout(Duration::from_millis(100));
    result
}

/// Lowers the priority, so that searches do not slow down interactive breeding.
fn lower_priority() {
    #[cfg(unix)]
    if let Err(error) = rustix::process::nice(LOWEST_PRIORITY) {
        tracing::warn!(%error, "cannot lower the priority; searches run at normal priority");
    }
}

/// Runs the renderer or the searcher until a signal, or until stdin is closed if that was
/// requested.
async fn work(args: WorkerArgs) -> Result<()> {
    let token = match (args.token, &args.token_file) {
        (Some(token), _) => token,
        (None, Some(file)) => secret::read(file).context("read the token")?,
        (None, None) => bail!("a worker needs --token or --token-file"),
    };
    let shutdown = serve::shutdown_on_signal()?;
    if args.while_stdin_is_open {
        // A thread instead of async stdin, which would block the shutdown of the runtime.
        let shutdown: CancellationToken = shutdown.clone();
        std::thread::Builder::new()
            .name("stdin".to_owned())
            .spawn(move || {
                let mut byte = [0];
                while matches!(std::io::stdin().read(&mut byte), Ok(1)) {}
                shutdown.cancel();
            })
            .context("watch stdin")?;
        std::thread::Builder::new().name("beat".to_owned()).spawn(beat).context("start to beat")?;
    }
    if args.searches {
        let config = SearcherConfig {
            server: args.server,
            token,
            name: args.name.unwrap_or_else(default_name),
            threads: args.threads,
        };
        // One ends with the other: only a rejected token or the shutdown ends them.
        let (server, token, name) = (&config.server, &config.token, &config.name);
        let (server, token, name) = (server.clone(), token.clone(), name.clone());
        let exports = brood_worker::run_exports((&server, &token, &name), shutdown.clone());
        tokio::try_join!(brood_worker::run_searches(config, shutdown), exports)?;
        return Ok(());
    }
    let config = WorkerConfig {
        server: args.server,
        token,
        backend: args.backend,
        name: args.name.unwrap_or_else(default_name),
        threads: args.threads,
        cache_bytes: args.cache_mib << 20,
    };
    Ok(brood_worker::run(config, shutdown).await?)
}

/// Writes a byte every [`BEAT`], until the reader has closed its end.
fn beat() {
    let mut stdout = std::io::stdout();
    while stdout.write_all(b".").and_then(|()| stdout.flush()).is_ok() {
        std::thread::sleep(BEAT);
    }
}

/// Returns a name for this process, unique among all machines. Containers may have the same host
/// name and the same process ids.
pub fn default_name() -> String {
    let host = std::env::var("HOSTNAME").ok().filter(|name| !name.is_empty());
    let number = random_bytes().map_or_else(|_| std::process::id(), u32::from_be_bytes);
    format!("{}-{number:08x}", host.as_deref().unwrap_or("worker"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn default_names_differ_when_host_and_process_are_the_same() {
        assert_ne!(default_name(), default_name());
    }
}
