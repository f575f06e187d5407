//! Claim loop of a worker that renders: leases jobs, at most two at a time, until shutdown or until
//! the server rejects the token.

use std::num::NonZeroUsize;
use std::sync::Arc;
use std::time::Duration;

use brood_protocol::{Backend, ClientError, LeaseRequest, WorkerClient};
use tokio::sync::{Semaphore, oneshot};
use tokio::task::JoinSet;
use tokio_util::sync::CancellationToken;

use crate::backoff::Backoff;
use crate::job::RenderContext;
use crate::light_asset_cache::LightAssetCache;
use crate::render_thread;
use crate::renderer::Renderer;

/// One job renders while the next is downloaded and waits.
const CONCURRENT_JOBS: usize = 2;
/// Number of consecutive failures after which a warning is logged.
pub(crate) const WARN_AFTER_FAILURES: u32 = 3;
pub(crate) const LONG_POLL: Duration = Duration::from_secs(20);
/// Wait for the GPU survey before the first lease request, so that a fast survey is part of its
/// report.
const SURVEY_TIMEOUT: Duration = Duration::from_millis(500);
/// Time for returning leases at shutdown. Leases not returned by then expire.
pub(crate) const SHUTDOWN_GRACE: Duration = Duration::from_secs(3);

/// Configuration of a worker that renders.
#[derive(Debug, Clone)]
pub struct WorkerConfig {
    /// URL of the server.
    pub server: String,
    /// Token with the scope `work`.
    pub token: String,
    /// Evaluator to use.
    pub backend: Backend,
    /// Name for logs and `/v1/system`.
    pub name: String,
    /// Number of render threads; `None` for all cores.
    pub threads: Option<NonZeroUsize>,
    /// Size of the caches of sample sets and meshes, in bytes.
    pub cache_bytes: u64,
}

/// Error that ends a worker.
#[derive(Debug, thiserror::Error)]
pub enum WorkerError {
    /// The token is missing, unknown or of another scope.
    #[error("{0}")]
    Refused(ClientError),
    /// The URL of the server is invalid, or the HTTP client cannot be set up.
    #[error("cannot set up the connection to the server: {0}")]
    Client(ClientError),
    /// A thread could not be started.
    #[error("cannot start the render threads: {0}")]
    Threads(#[from] std::io::Error),
}

/// Renders jobs until `shutdown` is cancelled.
///
/// # Errors
/// Returns [`WorkerError::Refused`] if the server rejects the token, the other variants if the
/// worker cannot start.
pub async fn run(config: WorkerConfig, shutdown: CancellationToken) -> Result<(), WorkerError> {
    let client = WorkerClient::new(&config.server, &config.token).map_err(WorkerError::Client)?;
    let (backend, cache_bytes) = (config.backend, config.cache_bytes);
    let made = tokio::task::spawn_blocking(move || Renderer::with_cache(backend, cache_bytes));
    let renderer = Arc::new(made.await.map_err(std::io::Error::other)?);
    let requests = render_thread::start(renderer.clone(), config.threads)?;
    if backend == Backend::Auto {
        let (renderer, (done, surveyed)) = (renderer.clone(), oneshot::channel());
        std::thread::Builder::new().name("gpu-survey".to_owned()).spawn(move || {
            renderer.survey();
            // The receiver is gone if the survey took longer than the timeout below.
            let _ = done.send(());
        })?;
        // On a timeout the CPU renders until the survey ends; a later lease request reports the
        // result.
        let _ = tokio::time::timeout(SURVEY_TIMEOUT, surveyed).await;
    }
    // Jobs have their own token, so that leases are also returned if the server has rejected the
    // worker.
    let stop = shutdown.child_token();
    let (asset_cache, shutdown) = (LightAssetCache::default(), stop.clone());
    let context = RenderContext { client, renderer, requests, asset_cache, shutdown };
    let mut jobs = JoinSet::new();
    let result = claim(&config, &context, &mut jobs).await;
    stop.cancel();
    let finished = async { while jobs.join_next().await.is_some() {} };
    if tokio::time::timeout(SHUTDOWN_GRACE, finished).await.is_err() {
        tracing::warn!("some leases were not returned in time; they will expire");
    }
    result
}

/// Leases jobs and spawns a task for each.
async fn claim(
    config: &WorkerConfig,
    context: &RenderContext,
    jobs: &mut JoinSet<()>,
) -> Result<(), WorkerError> {
    let slots = Arc::new(Semaphore::new(CONCURRENT_JOBS));
    let mut backoff = Backoff::default();
    tracing::info!(server = config.server, worker = config.name, "requesting jobs");
    loop {
        while jobs.try_join_next().is_some() {}
        let slot = tokio::select! {
            slot = slots.clone().acquire_owned() => slot.expect("the semaphore is never closed"),
            () = context.shutdown.cancelled() => return Ok(()),
        };
        let request = LeaseRequest {
            worker: config.name.clone(),
            report: context.renderer.worker_report(),
            wait_ms: u32::try_from(LONG_POLL.as_millis()).expect("seconds"),
        };
        let answer = tokio::select! {
            answer = context.client.lease(&request) => answer,
            () = context.shutdown.cancelled() => return Ok(()),
        };
        match answer {
            Ok(grant) => {
                if backoff.failures() >= WARN_AFTER_FAILURES {
                    tracing::info!("the server responds again");
                }
                backoff.reset();
                if let Some(grant) = grant {
                    let context = context.clone();
                    jobs.spawn(async move {
                        context.run(grant).await;
                        drop(slot);
                    });
                }
            }
            Err(error @ ClientError::Refused(_)) => return Err(WorkerError::Refused(error)),
            Err(error) => {
                let wait = backoff.next();
                // A single failure is normal while a server restarts. Warn once if failures
                // continue.
                if backoff.failures() == WARN_AFTER_FAILURES {
                    tracing::warn!(%error, "cannot lease jobs from the server; retrying");
                } else {
                    tracing::debug!(%error, "no job leased");
                }
                tokio::select! {
                    () = tokio::time::sleep(wait) => {}
                    () = context.shutdown.cancelled() => return Ok(()),
                }
            }
        }
    }
}
