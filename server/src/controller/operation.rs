//! Health checks and metrics.

use axum::extract::State;
use axum::response::{IntoResponse, Response};
use brood_protocol::Queue;
use http::header;

use crate::dispatch::JobState;
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
        return Err(ApiError::busy("a write to the disk failed; restart the server"));
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
    for (table, rows) in rows {
        app.metrics.gauge("brood_rows", &[("table", table)], rows as f64);
    }
    for queue in [Queue::Interactive, Queue::Batch] {
        for state in [JobState::Queued, JobState::Leased, JobState::Failed, JobState::Dead] {
            let labels = [("queue", queue.name()), ("state", state.name())];
            app.metrics.gauge("brood_jobs", &labels, app.pictures.queue.count(queue, state) as f64);
        }
    }
    for (state, searches) in app.store.search_counts().await? {
        app.metrics.gauge("brood_searches", &[("state", state)], searches as f64);
    }
    for (state, exports) in app.store.export_counts().await? {
        app.metrics.gauge("brood_exports", &[("state", state)], exports as f64);
    }
    app.metrics.gauge("brood_deferred_requests", &[], app.deferred.running() as f64);
    let (in_flight, memory_bytes) = app.pictures.cache.size();
    let (disk_bytes, pictures) = app.pictures.cache.disk().size();
    let (connections, of_workers) = app.connections.counts();
    app.metrics.gauge("brood_connections", &[], connections as f64);
    app.metrics.gauge("brood_worker_connections", &[], of_workers as f64);
    app.metrics.gauge("brood_log_bytes", &[], app.store.log_bytes() as f64);
    app.metrics.gauge("brood_refused_writes", &[], app.store.refused_writes() as f64);
    app.metrics.gauge("brood_leases", &[], app.pictures.leases.len() as f64);
    app.metrics.gauge("brood_pictures_under_way", &[], in_flight as f64);
    app.metrics.gauge("brood_cache_memory_bytes", &[], memory_bytes as f64);
    app.metrics.gauge("brood_cache_disk_bytes", &[], disk_bytes as f64);
    app.metrics.gauge("brood_cache_disk_pictures", &[], pictures as f64);
    let content_type = (header::CONTENT_TYPE, "text/plain; version=0.0.4; charset=utf-8");
    Ok(([content_type], app.metrics.render()).into_response())
}
