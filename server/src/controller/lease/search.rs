//! Worker routes of searches.

use axum::body::Body;
use axum::extract::State;
use axum::response::Response;
use brood_protocol::{JobId, SearchReport, SearchRequest, SearchTicket, encode};
use http::{Request, StatusCode};

use super::{check_same, for_logs, granted, message, read, read_ticket};
use crate::dispatch::Search;
use crate::extract::{NoQuery, Path};
use crate::limit;
use crate::problem::ApiError;
use crate::state::App;

/// Waits for a search: 200 with a grant, 204 if there was none in time.
#[utoipa::path(post, path = "/v1/leases/searches", tag = "workers",
    request_body(content = Vec<u8>, content_type = "application/vnd.brood.lease"),
    responses((status = 200, content_type = "application/vnd.brood.lease"), (status = 204)))]
pub async fn claim(
    State(app): State<App>,
    NoQuery: NoQuery,
    request: Request<Body>,
) -> Result<Response, ApiError> {
    let SearchRequest { worker, wait_ms } = read(request, limit::JSON_BYTES).await?;
    Ok(granted(app.lease::<Search>(&for_logs(&worker), wait_ms).await?))
}

/// Renews the lease of a search.
#[utoipa::path(post, path = "/v1/leases/searches/{id}/heartbeat", tag = "workers",
    params(("id" = JobId, Path)),
    request_body(content = Vec<u8>, content_type = "application/vnd.brood.lease"),
    responses((status = 204)))]
pub async fn heartbeat(
    State(app): State<App>,
    NoQuery: NoQuery,
    Path(id): Path<JobId>,
    request: Request<Body>,
) -> Result<StatusCode, ApiError> {
    let ticket: SearchTicket = read_ticket(id, request).await?;
    app.renew_lease::<Search>(&ticket)?;
    Ok(StatusCode::NO_CONTENT)
}

/// Stores a report of a search and returns a directive.
#[utoipa::path(post, path = "/v1/leases/searches/{id}/report", tag = "workers",
    params(("id" = JobId, Path)),
    request_body(content = Vec<u8>, content_type = "application/vnd.brood.lease"),
    responses((status = 200, content_type = "application/vnd.brood.lease")))]
pub async fn report(
    State(app): State<App>,
    NoQuery: NoQuery,
    Path(id): Path<JobId>,
    request: Request<Body>,
) -> Result<Response, ApiError> {
    let report: SearchReport = read(request, limit::SEARCH_REPORT_BYTES).await?;
    check_same(id, &report.ticket)?;
    Ok(message(encode(&app.report_search(report).await?)))
}

/// Returns a search to its queue.
#[utoipa::path(delete, path = "/v1/leases/searches/{id}", tag = "workers",
    params(("id" = JobId, Path)),
    request_body(content = Vec<u8>, content_type = "application/vnd.brood.lease"),
    responses((status = 204)))]
pub async fn release(
    State(app): State<App>,
    NoQuery: NoQuery,
    Path(id): Path<JobId>,
    request: Request<Body>,
) -> Result<StatusCode, ApiError> {
    let ticket: SearchTicket = read_ticket(id, request).await?;
    app.release_lease::<Search>(&ticket).await?;
    Ok(StatusCode::NO_CONTENT)
}
