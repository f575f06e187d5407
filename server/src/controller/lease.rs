//! Routes for brood's own workers: leases, heartbeats, results and downloads, as binary messages.
//! This module has what the routes of render jobs and searches share.

pub mod download;
pub mod render;
pub mod search;

use axum::body::Body;
use axum::response::{IntoResponse, Response};
use brood_protocol::{CONTENT_TYPE, Ticket, decode, encode};
use http::{Request, StatusCode, header};
use serde::Serialize;
use serde::de::DeserializeOwned;

use crate::extract::{ContentType, read_message};
use crate::limit;
use crate::problem::{ApiError, quote};

const NAME_CHARS: usize = 200;

/// Reads a worker's message of at most `max` bytes.
///
/// # Errors
/// [`ApiError`] if the content type is wrong, the body is too large, or it cannot be decoded.
async fn read<T: DeserializeOwned>(request: Request<Body>, max: usize) -> Result<T, ApiError> {
    let (head, body) = request.into_parts();
    ContentType::of(&head.headers).require(&[CONTENT_TYPE])?;
    let bytes = read_message(&head.headers, body, max).await?;
    decode(&bytes).map_err(|error| ApiError::bad_request(quote(&error.to_string())))
}

/// Reads the ticket of the lease that the address names.
///
/// # Errors
/// [`ApiError`] if the message is invalid or its ticket has another key.
async fn read_ticket<T: Ticket>(key: T::Key, request: Request<Body>) -> Result<T, ApiError> {
    let ticket = read(request, limit::JSON_BYTES).await?;
    check_same(key, &ticket)?;
    Ok(ticket)
}

fn check_same<T: Ticket>(key: T::Key, ticket: &T) -> Result<(), ApiError> {
    if key == ticket.key() {
        return Ok(());
    }
    Err(ApiError::bad_request("the ticket and the address name different leases"))
}

/// Returns a worker's name without control characters, shortened for logs.
fn for_logs(name: &str) -> String {
    name.chars().map(|c| if c.is_control() { ' ' } else { c }).take(NAME_CHARS).collect()
}

/// Returns 200 with the grant, or 204 if there is none.
fn granted<T: Serialize>(grant: Option<T>) -> Response {
    grant.map_or_else(|| StatusCode::NO_CONTENT.into_response(), |grant| message(encode(&grant)))
}

/// Returns 200 with an encoded message.
fn message(bytes: Vec<u8>) -> Response {
    ([(header::CONTENT_TYPE, CONTENT_TYPE)], bytes).into_response()
}
