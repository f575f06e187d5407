//! Worker routes of searches: leases, reports, and files of targets. Binary messages, for brood's
//! own workers.

use axum::body::Body;
use axum::extract::State;
use axum::response::{IntoResponse, Response};
use brood_protocol::{
    CONTENT_TYPE, JobId, SearchReport, SearchRequest, SearchTicket, TargetBytes, encode,
};
use http::{Request, StatusCode, header};

use super::lease::{for_logs, granted, read};
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
    let mut asked: SearchRequest = read(request, limit::JSON_BYTES).await?;
    asked.worker = for_logs(&asked.worker);
    Ok(granted(app.lease_search(&asked).await?))
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
    let ticket: SearchTicket = read(request, limit::JSON_BYTES).await?;
    check_same(id, &ticket)?;
    app.renew_search(&ticket)?;
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
    let directive = app.report_search(report).await?;
    Ok(([(header::CONTENT_TYPE, CONTENT_TYPE)], encode(&directive)).into_response())
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
    let ticket: SearchTicket = read(request, limit::JSON_BYTES).await?;
    check_same(id, &ticket)?;
    app.release_search(&ticket).await?;
    Ok(StatusCode::NO_CONTENT)
}

/// Returns a target's file by its hash.
#[utoipa::path(get, path = "/v1/leases/targets/{hash}", tag = "workers",
    params(("hash" = String, Path)),
    responses((status = 200, content_type = "application/vnd.brood.lease")))]
pub async fn target(
    State(app): State<App>,
    NoQuery: NoQuery,
    Path(hash): Path<String>,
) -> Result<Response, ApiError> {
    let hash = blake3::Hash::from_hex(&hash)
        .map_err(|_| ApiError::not_found("a file hash must be 64 hexadecimal digits"))?;
    let bytes = app.store.target_file(*hash.as_bytes()).await?;
    let file = encode(&TargetBytes { bytes });
    Ok(([(header::CONTENT_TYPE, CONTENT_TYPE)], file).into_response())
}

fn check_same(id: JobId, ticket: &SearchTicket) -> Result<(), ApiError> {
    if id == ticket.job {
        return Ok(());
    }
    Err(ApiError::bad_request("the ticket and the address name different searches"))
}
