//! `brood serve`: runs the server and its local worker processes.

use std::net::{IpAddr, Ipv4Addr, Ipv6Addr, SocketAddr};
use std::num::NonZeroUsize;
use std::path::PathBuf;

use anyhow::{Context, Result};
use brood_bench::{logging, output};
use brood_protocol::Backend;
use brood_server::{Server, ServerConfig};
use brood_storage::DatabaseAddress;
use clap::Args;
use serde_json::json;
use tokio_util::sync::CancellationToken;

use crate::place::{self, BlobPlace, DataPlace};
use crate::supervisor::{self, WorkerPlan};
use crate::worker::default_name;

/// Options of `brood serve`.
#[derive(Debug, Args)]
pub struct ServeArgs {
    /// Address and port to listen on; port 0 selects a free one
    #[arg(long, value_name = "ADDRESS", env = "BROOD_LISTEN", default_value = "127.0.0.1:7320")]
    pub listen: SocketAddr,
    #[command(flatten)]
    pub place: DataPlace,
    #[command(flatten)]
    pub blobs: BlobPlace,
    /// Number of worker processes that render; one more runs searches and exports. 0 starts none,
    /// for a server with remote workers only
    #[arg(long, value_name = "N", env = "BROOD_WORKERS", default_value_t = 1, value_parser = clap::value_parser!(u16).range(0..=256))]
    pub workers: u16,
    /// Evaluator: auto, cpu, gpu or reference
    #[arg(long, value_name = "BACKEND", env = "BROOD_BACKEND", default_value = "auto")]
    pub backend: Backend,
    /// Largest size of the cache of rendered pictures in MiB
    #[arg(long, value_name = "MIB", env = "BROOD_CACHE_MIB", default_value_t = 1024)]
    pub cache_mib: u64,
    /// Connections to PostgreSQL for reads and writes; a server holds four more
    #[arg(long, value_name = "N", env = "BROOD_DATABASE_CONNECTIONS", default_value_t = 24, value_parser = clap::value_parser!(u32).range(2..=1000))]
    pub database_connections: u32,
    /// Additional host name to answer to, besides localhost; may be given several times, or as a
    /// list with commas
    #[arg(
        long = "allow-host",
        value_name = "NAME",
        env = "BROOD_ALLOW_HOSTS",
        value_delimiter = ','
    )]
    pub allow_hosts: Vec<String>,
    /// Serve the page from this directory instead of the embedded copy
    #[arg(long, value_name = "DIR", hide = true)]
    pub web_dir: Option<PathBuf>,
}

/// Runs the command until SIGINT or SIGTERM.
pub fn run(args: &ServeArgs, json: bool) -> Result<()> {
    logging::start_service();
    place::runtime()?.block_on(serve(args, json))
}

/// Number of open files that a server with all its connections needs.
#[cfg(unix)]
const FILES: u64 = 4096;

/// Raises the limit of open files, as far as the system allows: each connection is one.
#[cfg(unix)]
fn raise_file_limit() {
    use rustix::process::{Resource, getrlimit, setrlimit};
    let mut limit = getrlimit(Resource::Nofile);
    let possible = limit.maximum.map_or(FILES, |most| most.min(FILES));
    if limit.current.is_none_or(|files| files >= possible) {
        return;
    }
    limit.current = Some(possible);
    if let Err(error) = setrlimit(Resource::Nofile, limit) {
        tracing::warn!(%error, "cannot raise the limit of open files");
    }
}

async fn serve(args: &ServeArgs, json: bool) -> Result<()> {
    #[cfg(unix)]
    raise_file_limit();
    let connected =
        |database: DatabaseAddress| database.with_connections(args.database_connections);
    let config = ServerConfig {
        cache_mib: args.cache_mib,
        allow_hosts: args.allow_hosts.clone(),
        backend: args.backend,
        web_dir: args.web_dir.clone(),
        database: args.place.database()?.map(connected),
        blobs: args.blobs.address.clone(),
        ..ServerConfig::new(args.listen, place::data_dir(args.place.data.as_ref())?)
    };
    // Before the printed line: its reader may send a signal at once.
    let shutdown = shutdown_on_signal()?;
    let is_shared = config.database.is_some();
    let server = Server::bind(config).await?;
    let address = server.local_addr();
    let url = format!("http://{address}");
    if json {
        output::print_json(&json!({ "listening": url }))?;
    } else {
        output::print(&format!("brood is listening on {url}\n"))?;
    }
    let plan = WorkerPlan {
        server: format!("http://{}", reachable(address)),
        // Other servers of the database have workers of their own.
        prefix: if is_shared { default_name() + "-" } else { String::new() },
        token: server.worker_token(),
        backend: args.backend,
        threads: threads_each(args.workers),
        searches: false,
        worker_reaper: server.worker_reaper(),
        shutdown: shutdown.clone(),
    };
    let (drain, stop, leaving) =
        (CancellationToken::new(), CancellationToken::new(), server.leaving());
    // Workers also stop if this function ends early.
    let _guards = [shutdown.clone(), stop.clone()].map(CancellationToken::drop_guard);
    let searches = supervisor::supervise_searches(args.workers, plan.clone(), shutdown.clone());
    let searches = tokio::spawn({
        let (drain, shutdown) = (drain.clone().drop_guard(), shutdown.clone());
        async move {
            let left = async {
                shutdown.cancelled().await;
                leaving.cancel();
            };
            // The searches report their checkpoints, then the server drains, even after a panic.
            tokio::join!(searches, left);
            drop(drain);
        }
    });
    // Workers stop after the server has drained, so that pending renders are still done.
    let workers = tokio::spawn(supervisor::supervise(args.workers, plan, stop.clone()));
    let result = server.run(drain).await;
    // The server may have stopped by itself.
    shutdown.cancel();
    stop.cancel();
    let (searches, workers) = tokio::join!(searches, workers);
    searches.and(workers).context("stop the workers")?;
    Ok(result?)
}

/// Returns a token that SIGINT or SIGTERM cancels.
pub fn shutdown_on_signal() -> Result<CancellationToken> {
    let token = CancellationToken::new();
    #[cfg(unix)]
    {
        use tokio::signal::unix::{SignalKind, signal};
        let mut terminate = signal(SignalKind::terminate()).context("listen for SIGTERM")?;
        let mut interrupt = signal(SignalKind::interrupt()).context("listen for SIGINT")?;
        let token = token.clone();
        tokio::spawn(async move {
            tokio::select! {
                _ = terminate.recv() => tracing::info!("SIGTERM: stopping"),
                _ = interrupt.recv() => tracing::info!("SIGINT: stopping"),
            }
            token.cancel();
        });
    }
    #[cfg(not(unix))]
    {
        let token = token.clone();
        tokio::spawn(async move {
            if tokio::signal::ctrl_c().await.is_ok() {
                token.cancel();
            }
        });
    }
    Ok(token)
}

/// Address that a process on this machine can connect to.
fn reachable(listen: SocketAddr) -> SocketAddr {
    let ip = match listen.ip() {
        IpAddr::V4(ip) if ip.is_unspecified() => IpAddr::V4(Ipv4Addr::LOCALHOST),
        IpAddr::V6(ip) if ip.is_unspecified() => IpAddr::V6(Ipv6Addr::LOCALHOST),
        ip => ip,
    };
    SocketAddr::new(ip, listen.port())
}

/// Threads of each worker when several share the cores; `None` for a single worker, which uses all.
fn threads_each(workers: u16) -> Option<NonZeroUsize> {
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    (workers > 1).then(|| NonZeroUsize::new(cores.div_ceil(workers.into()))).flatten()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn workers_connect_to_loopback_when_the_server_listens_everywhere() {
        let check = |listen: &str, expected: &str| {
            assert_eq!(reachable(listen.parse().unwrap()).to_string(), expected);
        };
        check("0.0.0.0:7320", "127.0.0.1:7320");
        check("[::]:7320", "[::1]:7320");
        check("127.0.0.1:1", "127.0.0.1:1");
    }

    #[test]
    fn cores_are_shared_when_there_are_several_workers() {
        assert_eq!(threads_each(1), None);
        assert!(threads_each(2).unwrap() >= threads_each(200).unwrap());
    }
}
