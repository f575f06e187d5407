//! Worker that renders: configuration and start. See [`job`](crate::job) for its jobs.
//!
//! Interactive and batch jobs run beside each other, on threads of their own. Those of batch jobs
//! have a low priority, so that they use the processors that interactive jobs leave.

use std::num::NonZeroUsize;
use std::sync::Arc;
use std::time::Duration;

use brood_protocol::{Backend, Queue, WorkerClient};
use tokio::sync::oneshot;
use tokio_util::sync::CancellationToken;

use crate::claim::run_jobs;
use crate::job::RenderContext;
use crate::lease::WorkerError;
use crate::light_asset_cache::LightAssetCache;
use crate::render_thread;
use crate::renderer::Renderer;

/// Wait for the GPU survey before the first lease request, so that a fast survey is part of its
/// report.
const SURVEY_TIMEOUT: Duration = Duration::from_millis(500);

/// Inverse of the share of the cache that batch jobs have.
const BATCH_SHARE: u64 = 4;

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
    /// Limit of the renderer's cache in bytes.
    pub cache_bytes: u64,
}

/// Renders jobs of both queues until `shutdown` is cancelled.
///
/// # Errors
/// Returns [`WorkerError::Refused`] if the server rejects the token, the other variants if the
/// worker cannot start.
pub async fn run(config: WorkerConfig, shutdown: CancellationToken) -> Result<(), WorkerError> {
    let client = WorkerClient::new(&config.server, &config.token).map_err(WorkerError::Client)?;
    let (backend, cache_bytes) = (config.backend, config.cache_bytes);
    let batch_bytes = cache_bytes / BATCH_SHARE;
    let own_bytes = cache_bytes - batch_bytes;
    let made = tokio::task::spawn_blocking(move || Renderer::with_cache(backend, own_bytes));
    let renderer = Arc::new(made.await.map_err(std::io::Error::other)?);
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
    let shutdown = shutdown.child_token();
    let batch = Arc::new(renderer.beside(batch_bytes));
    let run = |queue, renderer: Arc<Renderer>| {
        let requests = render_thread::start(renderer.clone(), queue, config.threads)?;
        let context = RenderContext {
            client: client.clone(),
            queue,
            asset_cache: LightAssetCache::new(renderer.entries()),
            renderer,
            requests,
            shutdown: shutdown.clone(),
        };
        Ok::<_, std::io::Error>(run_jobs(&client, &config.name, context, shutdown.clone()))
    };
    let interactive = run(Queue::Interactive, renderer)?;
    let batch = run(Queue::Batch, batch)?;
    // One ends with the other: only a rejected token or the shutdown ends them.
    let (interactive, batch) = tokio::join!(interactive, batch);
    interactive.and(batch)
}
