//! Worker routes of render jobs.

use axum::extract::State;
use axum::response::Response;
use brood_protocol::{LeaseGrant, LeaseId, LeaseRenewal, LeaseRequest, LeaseResults, LeaseTicket};
use http::{HeaderMap, StatusCode};

use super::{Held, Message, check_same, for_logs, granted, is_own, may_work};
use crate::client::Client;
use crate::dispatch::{JobKind, claim_lease};
use crate::extract::Path;
use crate::limit;
use crate::problem::ApiError;
use crate::state::App;

/// Waits for a render job: 200 with a grant, 204 if there was none in time.
#[utoipa::path(post, path = "/v1/leases", operation_id = "claim_render_job", tag = "workers",
    request_body(content = Vec<u8>, content_type = "application/vnd.brood.lease"),
    responses((status = 200, description = "grant of a render job",
        content_type = "application/vnd.brood.lease"),
        (status = 204, description = "no render job in time")))]
pub async fn claim(
    State(app): State<App>,
    headers: HeaderMap,
    Message(request): Message<LeaseRequest, { limit::JSON_BYTES }>,
) -> Result<Response, ApiError> {
    let LeaseRequest { worker, queue, report, wait_ms } = request;
    let worker = for_logs(&worker);
    app.workers.seen(&worker, &report);
    if !may_work(&app, &headers, &worker, wait_ms).await {
        return Ok(granted::<LeaseGrant>(None));
    }
    Ok(granted(claim_lease(&app.pictures, &worker, queue, wait_ms).await?))
}

/// Renews a lease and stores the progress of its job. 409 if no client waits for its pictures
/// any more.
#[utoipa::path(post, path = "/v1/leases/{id}/heartbeat", operation_id = "renew_render_lease", tag = "workers",
    params(("id" = LeaseId, Path)),
    request_body(content = Vec<u8>, content_type = "application/vnd.brood.lease"),
    responses((status = 204, description = "lease renewed")))]
pub async fn heartbeat(
    State(app): State<App>,
    Path(id): Path<LeaseId>,
    Message(renewal): Message<LeaseRenewal, { limit::JSON_BYTES }>,
) -> Result<StatusCode, ApiError> {
    check_same(id, &renewal.ticket)?;
    let renewed = app.pictures.renew(&renewal)?;
    app.workers.seen_again(&renewed.worker);
    Ok(StatusCode::NO_CONTENT)
}

/// Accepts the results of a lease.
#[utoipa::path(post, path = "/v1/leases/{id}/results", operation_id = "store_render_results", tag = "workers",
    params(("id" = LeaseId, Path)),
    request_body(content = Vec<u8>, content_type = "application/vnd.brood.lease"),
    responses((status = 204, description = "results stored")))]
pub async fn results(
    State(app): State<App>,
    Path(id): Path<LeaseId>,
    headers: HeaderMap,
    Message(results): Message<LeaseResults, { limit::LEASE_BYTES }>,
) -> Result<StatusCode, ApiError> {
    check_same(id, &results.ticket)?;
    let is_own = is_own(&app, &headers);
    let stored = app.pictures.results(results, is_own).await;
    match &stored {
        Ok(()) => app.workers.succeeded(Client::current()),
        Err(error) if error.status() == 422 && !is_own => app.workers.failed(Client::current()),
        Err(_) => {}
    }
    stored.map(|()| StatusCode::NO_CONTENT)
}

/// Returns a lease without results.
#[utoipa::path(delete, path = "/v1/leases/{id}", operation_id = "release_render_job", tag = "workers",
    params(("id" = LeaseId, Path)),
    request_body(content = Vec<u8>, content_type = "application/vnd.brood.lease"),
    responses((status = 204, description = "render job queued again")))]
pub async fn release(
    State(app): State<App>,
    Held(ticket): Held<LeaseTicket>,
) -> Result<StatusCode, ApiError> {
    app.pictures.give_back(&ticket).await?;
    Ok(StatusCode::NO_CONTENT)
}
