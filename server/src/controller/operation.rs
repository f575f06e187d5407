//! Health checks and metrics.

use axum::extract::State;
use axum::response::{IntoResponse, Response};
use brood_protocol::Queue;
use http::header;

use crate::dispatch::JobState;
use crate::metric::GaugeName;
use crate::problem::ApiError;
use crate::state::App;

/// Answers `ok` while the process runs.
#[utoipa::path(get, path = "/healthz", tag = "operation",
    responses((status = 200, description = "`ok`", body = String, content_type = "text/plain")))]
pub async fn health() -> &'static str {
    "ok\n"
}

/// Answers `ready` if the server can read and write its data and is not stopping. Further lines
/// say what is limited meanwhile.
#[utoipa::path(get, path = "/readyz", tag = "operation",
    responses((status = 200, description = "`ready`, and lines on what is limited", body = String, content_type = "text/plain")))]
pub async fn ready(State(app): State<App>) -> Result<String, ApiError> {
    if app.leaving.is_cancelled() || app.stopping.is_cancelled() {
        return Err(ApiError::stopping("retry after the restart"));
    }
    if app.store.is_poisoned() {
        return Err(ApiError::busy("the database takes no writes of this server; restart it"));
    }
    app.store.any_token().await?;
    let mut text = String::from("ready\n");
    if app.store.is_unchecked() {
        text += "the last shutdown was not clean: the database is being checked\n";
    }
    if app.workers.present().0.is_empty() {
        text += "no worker renders: pictures wait\n";
    }
    Ok(text)
}

/// Returns metrics in the Prometheus text format.
#[utoipa::path(get, path = "/metrics", tag = "operation",
    responses((status = 200, description = "metrics", body = String, content_type = "text/plain")))]
pub async fn metrics(State(app): State<App>) -> Result<Response, ApiError> {
    let counts = app.store.counts().await?;
    let rows = [
        ("lineage", counts.lineages),
        ("generation", counts.generations),
        ("individual", counts.individuals),
        ("genome", counts.genomes),
        ("scene", counts.scenes),
        ("mesh", counts.meshes),
        ("light_asset", counts.light_assets),
        ("picture", counts.pictures),
        ("idempotency", counts.idempotency),
        ("token", counts.tokens),
    ];
    let metrics = &app.metrics;
    for (table, rows) in rows {
        metrics.gauge(GaugeName::Rows, &[("table", table)], rows as f64);
    }
    let jobs = &app.pictures.queue;
    for queue in [Queue::Interactive, Queue::Batch] {
        let label = ("queue", queue.name());
        for state in [JobState::Queued, JobState::Leased, JobState::Failed, JobState::Dead] {
            let labels = [label, ("state", state.name())];
            metrics.gauge(GaugeName::Jobs, &labels, jobs.count(queue, state) as f64);
        }
        let wait = jobs.oldest(queue).unwrap_or_default();
        metrics.gauge(GaugeName::OldestRenderWait, &[label], wait.as_secs_f64());
    }
    for (state, searches) in app.store.search_counts().await? {
        metrics.gauge(GaugeName::Searches, &[("state", state)], searches as f64);
    }
    for (state, exports) in app.store.export_counts().await? {
        metrics.gauge(GaugeName::Exports, &[("state", state)], exports as f64);
    }
    let (in_flight, memory_bytes) = app.pictures.cache.size();
    let (disk_bytes, pictures) = app.pictures.cache.disk().size();
    let (connections, of_workers) = app.connections.counts();
    metrics.gauge(GaugeName::DeferredRequests, &[], app.deferred.running() as f64);
    metrics.gauge(GaugeName::Connections, &[], connections as f64);
    metrics.gauge(GaugeName::WorkerConnections, &[], of_workers as f64);
    metrics.gauge(GaugeName::LogBytes, &[], app.store.log_bytes() as f64);
    metrics.gauge(GaugeName::Leases, &[], app.pictures.leases.len() as f64);
    metrics.gauge(GaugeName::PicturesUnderWay, &[], in_flight as f64);
    metrics.gauge(GaugeName::CacheMemoryBytes, &[], memory_bytes as f64);
    metrics.gauge(GaugeName::CacheDiskBytes, &[], disk_bytes as f64);
    metrics.gauge(GaugeName::CacheDiskPictures, &[], pictures as f64);
    metrics.refused_writes.absolute(app.store.refused_writes());
    let content_type = (header::CONTENT_TYPE, "text/plain; version=0.0.4; charset=utf-8");
    Ok(([content_type], metrics.render()).into_response())
}
