//! Worker routes: leases, heartbeats, results, meshes and light files. Binary messages, for brood's
//! own workers.

use axum::body::Body;
use axum::extract::State;
use axum::response::{IntoResponse, Response};
use brood_protocol::{
    CONTENT_TYPE, LeaseId, LeaseRequest, LeaseResults, LeaseTicket, LightAssetFile, decode, encode,
};
use http::{Request, StatusCode, header};
use serde::Serialize;
use serde::de::DeserializeOwned;

use crate::extract::{ContentType, NoQuery, Path, read_message};
use crate::limit;
use crate::problem::{ApiError, quote};
use crate::state::App;

const NAME_CHARS: usize = 200;

/// Waits for a render job: 200 with a grant, 204 if there was none in time.
#[utoipa::path(post, path = "/v1/leases", tag = "workers",
    request_body(content = Vec<u8>, content_type = "application/vnd.brood.lease"),
    responses((status = 200, content_type = "application/vnd.brood.lease"), (status = 204)))]
pub async fn claim(
    State(app): State<App>,
    NoQuery: NoQuery,
    request: Request<Body>,
) -> Result<Response, ApiError> {
    let mut asked: LeaseRequest = read(request, limit::JSON_BYTES).await?;
    asked.worker = for_logs(&asked.worker);
    Ok(granted(app.lease(&asked).await?))
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
    let ticket: LeaseTicket = read(request, limit::JSON_BYTES).await?;
    check_same(id, &ticket)?;
    app.heartbeat(&ticket)?;
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
    let ticket: LeaseTicket = read(request, limit::JSON_BYTES).await?;
    check_same(id, &ticket)?;
    app.release(&ticket).await?;
    Ok(StatusCode::NO_CONTENT)
}

/// Returns an uploaded mesh by its content hash.
#[utoipa::path(get, path = "/v1/leases/meshes/{hash}", tag = "workers",
    params(("hash" = String, Path)),
    responses((status = 200, content_type = "application/vnd.brood.lease")))]
pub async fn mesh(
    State(app): State<App>,
    NoQuery: NoQuery,
    Path(hash): Path<String>,
) -> Result<Response, ApiError> {
    let hash = blake3::Hash::from_hex(&hash)
        .map_err(|_| ApiError::not_found("a mesh hash must be 64 hexadecimal digits"))?;
    // The stored encoding is the wire encoding.
    let data = app.store.mesh_data(*hash.as_bytes()).await?;
    Ok(([(header::CONTENT_TYPE, CONTENT_TYPE)], data).into_response())
}

/// Returns a light's file by its hash.
#[utoipa::path(get, path = "/v1/leases/light-assets/{hash}", tag = "workers",
    params(("hash" = String, Path)),
    responses((status = 200, content_type = "application/vnd.brood.lease")))]
pub async fn light_asset(
    State(app): State<App>,
    NoQuery: NoQuery,
    Path(hash): Path<String>,
) -> Result<Response, ApiError> {
    let hash = blake3::Hash::from_hex(&hash)
        .map_err(|_| ApiError::not_found("a file hash must be 64 hexadecimal digits"))?;
    let (kind, bytes) = app.store.light_asset(*hash.as_bytes()).await?;
    let file = encode(&LightAssetFile { kind, bytes });
    Ok(([(header::CONTENT_TYPE, CONTENT_TYPE)], file).into_response())
}

/// Reads a worker's message of at most `max` bytes.
///
/// # Errors
/// [`ApiError`] if the content type is wrong, the body is too large, or it cannot be decoded.
pub(super) async fn read<T: DeserializeOwned>(
    request: Request<Body>,
    max: usize,
) -> Result<T, ApiError> {
    let (head, body) = request.into_parts();
    ContentType::of(&head.headers).require(&[CONTENT_TYPE])?;
    let bytes = read_message(&head.headers, body, max).await?;
    decode(&bytes).map_err(|error| ApiError::bad_request(quote(&error.to_string())))
}

/// Returns a worker's name without control characters, shortened for logs.
pub(super) fn for_logs(name: &str) -> String {
    name.chars().map(|c| if c.is_control() { ' ' } else { c }).take(NAME_CHARS).collect()
}

/// Returns 200 with the grant, or 204 if there is none.
pub(super) fn granted<T: Serialize>(grant: Option<T>) -> Response {
    match grant {
        Some(grant) => ([(header::CONTENT_TYPE, CONTENT_TYPE)], encode(&grant)).into_response(),
        None => StatusCode::NO_CONTENT.into_response(),
    }
}

fn check_same(id: LeaseId, ticket: &LeaseTicket) -> Result<(), ApiError> {
    if id == ticket.lease {
        return Ok(());
    }
    Err(ApiError::bad_request("the ticket and the address name different leases"))
}
