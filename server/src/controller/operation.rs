//! Health and figures, for those who run the server.

use axum::extract::State;
use axum::response::{IntoResponse, Response};
use brood_storage::{JobState, Queue};
use http::header;

use crate::problem::ApiError;
use crate::state::App;

/// The process lives.
#[utoipa::path(get, path = "/healthz", tag = "operation",
    responses((status = 200, body = String, content_type = "text/plain")))]
pub async fn health() -> &'static str {
    "ok\n"
}

/// The server takes work: facts can be read and written, and it is not stopping.
#[utoipa::path(get, path = "/readyz", tag = "operation",
    responses((status = 200, body = String, content_type = "text/plain")))]
pub async fn ready(State(app): State<App>) -> Result<&'static str, ApiError> {
    if app.stopping.is_cancelled() {
        return Err(ApiError::stopping("come back when it runs again"));
    }
    if app.store.is_poisoned() {
        return Err(ApiError::busy("a write to the disk failed; the server must be started again"));
    }
    app.store.any_token().await?;
    Ok("ready\n")
}

/// Figures as Prometheus reads them.
#[utoipa::path(get, path = "/metrics", tag = "operation",
    responses((status = 200, body = String, content_type = "text/plain")))]
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
    let depth = app.store.queue_depth().await?;
    for queue in [Queue::Interactive, Queue::Batch] {
        for state in [JobState::Queued, JobState::Leased, JobState::Failed, JobState::Dead] {
            let labels = [("queue", queue.name()), ("state", state.name())];
            app.metrics.gauge("brood_jobs", &labels, depth.of(queue, state) as f64);
        }
    }
    for (state, searches) in app.store.search_counts().await? {
        app.metrics.gauge("brood_searches", &[("state", state)], searches as f64);
    }
    let (flights, memory_bytes) = app.gallery.size();
    let (disk_bytes, pictures) = app.gallery.disk().size();
    app.metrics.gauge("brood_leases", &[], app.dispatch.table.len() as f64);
    app.metrics.gauge("brood_pictures_under_way", &[], flights as f64);
    app.metrics.gauge("brood_cache_memory_bytes", &[], memory_bytes as f64);
    app.metrics.gauge("brood_cache_disk_bytes", &[], disk_bytes as f64);
    app.metrics.gauge("brood_cache_disk_pictures", &[], pictures as f64);
    let content_type = (header::CONTENT_TYPE, "text/plain; version=0.0.4; charset=utf-8");
    Ok(([content_type], app.metrics.render()).into_response())
}
