//! Worker routes of exports.

use axum::extract::State;
use axum::response::Response;
use brood_protocol::{ExportGrant, ExportReport, ExportRequest, ExportTicket, JobId, encode};
use http::{HeaderMap, StatusCode};

use super::{Held, Message, check_same, for_logs, granted, may_work, message};
use crate::dispatch::{JobKind, claim_lease};
use crate::extract::Path;
use crate::limit;
use crate::problem::ApiError;
use crate::state::App;

/// Waits for an export: 200 with a grant, 204 if there was none in time.
#[utoipa::path(post, path = "/v1/leases/exports", operation_id = "claim_export", tag = "workers",
    request_body(content = Vec<u8>, content_type = "application/vnd.brood.lease"),
    responses((status = 200, description = "grant of an export", content_type = "application/vnd.brood.lease"),
        (status = 204, description = "no export in time")))]
pub async fn claim(
    State(app): State<App>,
    headers: HeaderMap,
    Message(request): Message<ExportRequest, { limit::JSON_BYTES }>,
) -> Result<Response, ApiError> {
    let ExportRequest { worker, wait_ms } = request;
    let worker = for_logs(&worker);
    if !may_work(&app, &headers, &worker, wait_ms).await {
        return Ok(granted::<ExportGrant>(None));
    }
    Ok(granted(claim_lease(&app.exports, &worker, (), wait_ms).await?))
}

/// Renews the lease of an export.
#[utoipa::path(post, path = "/v1/leases/exports/{id}/heartbeat", operation_id = "renew_export_lease", tag = "workers",
    params(("id" = JobId, Path)),
    request_body(content = Vec<u8>, content_type = "application/vnd.brood.lease"),
    responses((status = 204, description = "lease renewed")))]
pub async fn heartbeat(
    State(app): State<App>,
    Held(ticket): Held<ExportTicket>,
) -> Result<StatusCode, ApiError> {
    app.exports.renew(&ticket).await?;
    Ok(StatusCode::NO_CONTENT)
}

/// Stores a file of an export, or its failure, and returns a directive.
#[utoipa::path(post, path = "/v1/leases/exports/{id}/report", operation_id = "report_export", tag = "workers",
    params(("id" = JobId, Path)),
    request_body(content = Vec<u8>, content_type = "application/vnd.brood.lease"),
    responses((status = 200, description = "directive to the worker",
        content_type = "application/vnd.brood.lease")))]
pub async fn report(
    State(app): State<App>,
    Path(id): Path<JobId>,
    Message(report): Message<ExportReport, { limit::EXPORT_REPORT_BYTES }>,
) -> Result<Response, ApiError> {
    check_same(id, &report.ticket)?;
    Ok(message(encode(&app.exports.report(report).await?)))
}

/// Returns an export to its queue.
#[utoipa::path(delete, path = "/v1/leases/exports/{id}", operation_id = "release_export", tag = "workers",
    params(("id" = JobId, Path)),
    request_body(content = Vec<u8>, content_type = "application/vnd.brood.lease"),
    responses((status = 204, description = "export queued again")))]
pub async fn release(
    State(app): State<App>,
    Held(ticket): Held<ExportTicket>,
) -> Result<StatusCode, ApiError> {
    app.exports.give_back(&ticket).await?;
    Ok(StatusCode::NO_CONTENT)
}
