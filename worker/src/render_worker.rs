//! Worker that renders: configuration and start. See [`job`](crate::job) for its jobs.

use std::num::NonZeroUsize;
use std::sync::Arc;
use std::time::Duration;

use brood_protocol::{Backend, WorkerClient};
use tokio::sync::oneshot;
use tokio_util::sync::CancellationToken;

use crate::job::RenderContext;
use crate::lease::{WorkerError, run_jobs};
use crate::light_asset_cache::LightAssetCache;
use crate::render_thread;
use crate::renderer::Renderer;

/// Wait for the GPU survey before the first lease request, so that a fast survey is part of its
/// report.
const SURVEY_TIMEOUT: Duration = Duration::from_millis(500);

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
    let shutdown = shutdown.child_token();
    let context = RenderContext {
        client: client.clone(),
        asset_cache: LightAssetCache::new(renderer.entries()),
        renderer,
        requests,
        shutdown: shutdown.clone(),
    };
    run_jobs(&client, &config.name, context, shutdown).await
}
