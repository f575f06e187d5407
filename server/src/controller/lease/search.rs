//! Worker routes of searches.

use axum::extract::State;
use axum::response::Response;
use brood_protocol::{JobId, SearchGrant, SearchReport, SearchRequest, SearchTicket, encode};
use http::{HeaderMap, StatusCode};

use super::{Held, Message, check_same, for_logs, granted, may_work, message};
use crate::dispatch::{JobKind, claim_lease};
use crate::extract::Path;
use crate::limit;
use crate::problem::ApiError;
use crate::state::App;

/// Waits for a search: 200 with a grant, 204 if there was none in time.
#[utoipa::path(post, path = "/v1/leases/searches", operation_id = "claim_search", tag = "workers",
    request_body(content = Vec<u8>, content_type = "application/vnd.brood.lease"),
    responses((status = 200, description = "grant of a search", content_type = "application/vnd.brood.lease"),
        (status = 204, description = "no search in time")))]
pub async fn claim(
    State(app): State<App>,
    headers: HeaderMap,
    Message(request): Message<SearchRequest, { limit::JSON_BYTES }>,
) -> Result<Response, ApiError> {
    let SearchRequest { worker, wait_ms } = request;
    let worker = for_logs(&worker);
    if !may_work(&app, &headers, &worker, wait_ms).await {
        return Ok(granted::<SearchGrant>(None));
    }
    Ok(granted(claim_lease(&app.searches, &worker, (), wait_ms).await?))
}

/// Renews the lease of a search.
#[utoipa::path(post, path = "/v1/leases/searches/{id}/heartbeat", operation_id = "renew_search_lease", tag = "workers",
    params(("id" = JobId, Path)),
    request_body(content = Vec<u8>, content_type = "application/vnd.brood.lease"),
    responses((status = 204, description = "lease renewed")))]
pub async fn heartbeat(
    State(app): State<App>,
    Held(ticket): Held<SearchTicket>,
) -> Result<StatusCode, ApiError> {
    app.searches.renew(&ticket).await?;
    Ok(StatusCode::NO_CONTENT)
}

/// Stores a report of a search and returns a directive.
#[utoipa::path(post, path = "/v1/leases/searches/{id}/report", operation_id = "report_search", tag = "workers",
    params(("id" = JobId, Path)),
    request_body(content = Vec<u8>, content_type = "application/vnd.brood.lease"),
    responses((status = 200, description = "directive to the worker",
        content_type = "application/vnd.brood.lease")))]
pub async fn report(
    State(app): State<App>,
    Path(id): Path<JobId>,
    Message(report): Message<SearchReport, { limit::SEARCH_REPORT_BYTES }>,
) -> Result<Response, ApiError> {
    check_same(id, &report.ticket)?;
    Ok(message(encode(&app.searches.report(report).await?)))
}

/// Returns a search to its queue.
#[utoipa::path(delete, path = "/v1/leases/searches/{id}", operation_id = "release_search", tag = "workers",
    params(("id" = JobId, Path)),
    request_body(content = Vec<u8>, content_type = "application/vnd.brood.lease"),
    responses((status = 204, description = "search queued again")))]
pub async fn release(
    State(app): State<App>,
    Held(ticket): Held<SearchTicket>,
) -> Result<StatusCode, ApiError> {
    app.searches.give_back(&ticket).await?;
    Ok(StatusCode::NO_CONTENT)
}
