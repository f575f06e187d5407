//! Worker routes of render jobs.

use axum::body::Body;
use axum::extract::State;
use axum::response::Response;
use brood_protocol::{LeaseId, LeaseRequest, LeaseResults, LeaseTicket};
use http::{Request, StatusCode};

use super::{check_same, for_logs, granted, read, read_ticket};
use crate::dispatch::Render;
use crate::extract::{NoQuery, Path};
use crate::limit;
use crate::problem::ApiError;
use crate::state::App;

/// Waits for a render job: 200 with a grant, 204 if there was none in time.
#[utoipa::path(post, path = "/v1/leases", tag = "workers",
    request_body(content = Vec<u8>, content_type = "application/vnd.brood.lease"),
    responses((status = 200, content_type = "application/vnd.brood.lease"), (status = 204)))]
pub async fn claim(
    State(app): State<App>,
    NoQuery: NoQuery,
    request: Request<Body>,
) -> Result<Response, ApiError> {
    let LeaseRequest { worker, report, wait_ms } = read(request, limit::JSON_BYTES).await?;
    let worker = for_logs(&worker);
    app.dispatch.worker_seen(&worker, &report);
    Ok(granted(app.lease::<Render>(&worker, wait_ms).await?))
}

/// Renews a lease.
#[utoipa::path(post, path = "/v1/leases/{id}/heartbeat", tag = "workers",
    params(("id" = LeaseId, Path)),
    request_body(content = Vec<u8>, content_type = "application/vnd.brood.lease"),
    responses((status = 204)))]
pub async fn heartbeat(
    State(app): State<App>,
    NoQuery: NoQuery,
    Path(id): Path<LeaseId>,
    request: Request<Body>,
) -> Result<StatusCode, ApiError> {
    let ticket: LeaseTicket = read_ticket(id, request).await?;
    let renewed = app.renew_lease::<Render>(&ticket)?;
    app.dispatch.worker_seen_again(&renewed.worker);
    Ok(StatusCode::NO_CONTENT)
}

/// Accepts the results of a lease.
#[utoipa::path(post, path = "/v1/leases/{id}/results", tag = "workers",
    params(("id" = LeaseId, Path)),
    request_body(content = Vec<u8>, content_type = "application/vnd.brood.lease"),
    responses((status = 204)))]
pub async fn results(
    State(app): State<App>,
    NoQuery: NoQuery,
    Path(id): Path<LeaseId>,
    request: Request<Body>,
) -> Result<StatusCode, ApiError> {
    let results: LeaseResults = read(request, limit::LEASE_BYTES).await?;
    check_same(id, &results.ticket)?;
    app.results(results).await?;
    Ok(StatusCode::NO_CONTENT)
}

/// Returns a lease without results.
#[utoipa::path(delete, path = "/v1/leases/{id}", tag = "workers",
    params(("id" = LeaseId, Path)),
    request_body(content = Vec<u8>, content_type = "application/vnd.brood.lease"),
    responses((status = 204)))]
pub async fn release(
    State(app): State<App>,
    NoQuery: NoQuery,
    Path(id): Path<LeaseId>,
    request: Request<Body>,
) -> Result<StatusCode, ApiError> {
    let ticket: LeaseTicket = read_ticket(id, request).await?;
    app.release_lease::<Render>(&ticket).await?;
    Ok(StatusCode::NO_CONTENT)
}
