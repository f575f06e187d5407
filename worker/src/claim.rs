//! The claim loop: asks for work, keeps one job rendering and one waiting, ends when told to or when refused.
//!
//! It refuses to know what a job is made of.

use std::num::NonZeroUsize;
use std::sync::Arc;
use std::time::Duration;

use brood_protocol::{Backend, ClientError, LeaseRequest, WorkerClient};
use tokio::sync::{Semaphore, oneshot};
use tokio::task::JoinSet;
use tokio_util::sync::CancellationToken;

use crate::backoff::Backoff;
use crate::job::Desk;
use crate::lamp::Lamps;
use crate::render_thread;
use crate::renderer::Renderer;

/// One job renders while the next is fetched and waits.
const JOBS_IN_HAND: usize = 2;
/// Failures in a row before the log says so.
pub(crate) const FAILURES_TOLD: u32 = 3;
pub(crate) const LONG_POLL: Duration = Duration::from_secs(20);
/// So that the first request tells which evaluator runs, where that is found out quickly.
const SURVEY_PATIENCE: Duration = Duration::from_millis(500);
/// Leases are given back within this time at shutdown; the rest lapse.
pub(crate) const FAREWELL: Duration = Duration::from_secs(3);

/// What a worker needs to know.
#[derive(Debug, Clone)]
pub struct WorkerConfig {
    /// URL of the server.
    pub server: String,
    /// A token of scope work.
    pub token: String,
    /// Which evaluator.
    pub backend: Backend,
    /// For logs and `/v1/system`.
    pub name: String,
    /// Threads that render; all cores where absent.
    pub threads: Option<NonZeroUsize>,
    /// Room for sample sets and meshes.
    pub cache_bytes: u64,
}

/// Why a worker ended before it was told to.
#[derive(Debug, thiserror::Error)]
pub enum WorkerError {
    /// The token is missing, wrong or of another scope.
    #[error("{0}")]
    Refused(ClientError),
    /// The server's URL is not one, or the HTTP client cannot be set up.
    #[error("the connection cannot be set up: {0}")]
    Client(ClientError),
    /// Threads could not be started.
    #[error("the render threads cannot be started: {0}")]
    Threads(#[from] std::io::Error),
}

/// Works until `shutdown`; ends by itself only where the server refuses the token.
pub async fn run(config: WorkerConfig, shutdown: CancellationToken) -> Result<(), WorkerError> {
    let client = WorkerClient::new(&config.server, &config.token).map_err(WorkerError::Client)?;
    let (backend, cache_bytes) = (config.backend, config.cache_bytes);
    let made = tokio::task::spawn_blocking(move || Renderer::with_cache(backend, cache_bytes));
    let renderer = Arc::new(made.await.map_err(std::io::Error::other)?);
    let orders = render_thread::start(renderer.clone(), config.threads)?;
    if backend == Backend::Auto {
        let (renderer, (done, surveyed)) = (renderer.clone(), oneshot::channel());
        std::thread::Builder::new().name("gpu-survey".to_owned()).spawn(move || {
            renderer.survey();
            // Nobody listens any more where it took longer than the patience below.
            let _ = done.send(());
        })?;
        // Either way it goes on: the answer comes with a later request, and the CPU renders until then.
        let _ = tokio::time::timeout(SURVEY_PATIENCE, surveyed).await;
    }
    // Jobs stop by a token of their own: a refused worker gives its leases back as well.
    let stop = shutdown.child_token();
    let (lamps, shutdown) = (Lamps::default(), stop.clone());
    let desk = Desk { client, renderer, orders, lamps, shutdown };
    let mut jobs = JoinSet::new();
    let result = claim(&config, &desk, &mut jobs).await;
    stop.cancel();
    let farewell = async { while jobs.join_next().await.is_some() {} };
    if tokio::time::timeout(FAREWELL, farewell).await.is_err() {
        tracing::warn!("leases left to lapse");
    }
    result
}

async fn claim(
    config: &WorkerConfig,
    desk: &Desk,
    jobs: &mut JoinSet<()>,
) -> Result<(), WorkerError> {
    let slots = Arc::new(Semaphore::new(JOBS_IN_HAND));
    let mut backoff = Backoff::default();
    tracing::info!(server = config.server, worker = config.name, "asking for work");
    loop {
        while jobs.try_join_next().is_some() {}
        let slot = tokio::select! {
            slot = slots.clone().acquire_owned() => slot.expect("the semaphore is never closed"),
            () = desk.shutdown.cancelled() => return Ok(()),
        };
        let request = LeaseRequest {
            worker: config.name.clone(),
            report: desk.renderer.worker_report(),
            wait_ms: u32::try_from(LONG_POLL.as_millis()).expect("seconds"),
        };
        let answer = tokio::select! {
            answer = desk.client.lease(&request) => answer,
            () = desk.shutdown.cancelled() => return Ok(()),
        };
        match answer {
            Ok(grant) => {
                if backoff.failures() >= FAILURES_TOLD {
                    tracing::info!("the server answers again");
                }
                backoff.reset();
                if let Some(grant) = grant {
                    let desk = desk.clone();
                    jobs.spawn(async move {
                        desk.work(grant).await;
                        drop(slot);
                    });
                }
            }
            Err(error @ ClientError::Refused(_)) => return Err(WorkerError::Refused(error)),
            Err(error) => {
                let wait = backoff.next();
                // One failure is what a server that stops looks like; more are worth a line, but not one each.
                if backoff.failures() == FAILURES_TOLD {
                    tracing::warn!(%error, "the server gives no work; trying again and again");
                } else {
                    tracing::debug!(%error, "no work to be had");
                }
                tokio::select! {
                    () = tokio::time::sleep(wait) => {}
                    () = desk.shutdown.cancelled() => return Ok(()),
                }
            }
        }
    }
}
