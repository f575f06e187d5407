//! Routes for brood's own workers: leases, heartbeats, results and downloads, as binary messages.
//! This module has what the routes of all kinds of jobs share.

pub mod download;
pub mod export;
pub mod render;
pub mod search;

use std::time::Duration;

use axum::body::Body;
use axum::extract::{FromRequest, FromRequestParts};
use axum::response::{IntoResponse, Response};
use brood_protocol::{CONTENT_TYPE, Ticket, decode, encode};
use http::{HeaderMap, Request, StatusCode, header};
use serde::Serialize;
use serde::de::DeserializeOwned;

use crate::client::Client;
use crate::extract::{ContentType, Path, read_message};
use crate::layer::token;
use crate::limit;
use crate::problem::{ApiError, quote};
use crate::state::App;

const NAME_CHARS: usize = 200;

/// Message of a worker of at most `MAX` bytes.
pub struct Message<T, const MAX: usize>(T);

impl<T: DeserializeOwned, const MAX: usize, S: Send + Sync> FromRequest<S> for Message<T, MAX> {
    type Rejection = ApiError;

    async fn from_request(request: Request<Body>, _: &S) -> Result<Self, ApiError> {
        let (head, body) = request.into_parts();
        ContentType::of(&head.headers).require(&[CONTENT_TYPE])?;
        let bytes = read_message(&head.headers, body, MAX).await?;
        let read = decode(&bytes).map(Self);
        read.map_err(|error| ApiError::bad_request(quote(&error.to_string())))
    }
}

/// Ticket in the body, of the lease that the address names.
pub struct Held<T>(T);

impl<T: Ticket<Key: DeserializeOwned>, S: Send + Sync> FromRequest<S> for Held<T> {
    type Rejection = ApiError;

    async fn from_request(request: Request<Body>, state: &S) -> Result<Self, ApiError> {
        let (mut head, body) = request.into_parts();
        let Path(key) = Path::<T::Key>::from_request_parts(&mut head, state).await?;
        let request = Request::from_parts(head, body);
        let Message(ticket) =
            Message::<T, { limit::JSON_BYTES }>::from_request(request, state).await?;
        check_same(key, &ticket)?;
        Ok(Self(ticket))
    }
}

/// Error if the address names another lease than the ticket.
fn check_same<T: Ticket>(key: T::Key, ticket: &T) -> Result<(), ApiError> {
    if key == ticket.key() {
        return Ok(());
    }
    Err(ApiError::bad_request("the ticket and the address name different leases"))
}

/// Records the client of a worker that the server did not start. Waits while the client's workers
/// get no jobs; returns false if that takes longer than the request may wait.
async fn may_work(app: &App, headers: &HeaderMap, worker: &str, wait_ms: u32) -> bool {
    if !is_own(app, headers) {
        app.workers.run_by(worker, Client::current());
    }
    let held_back = app.workers.held_back(Client::current());
    let wait = limit::LEASE_WAIT.min(Duration::from_millis(wait_ms.into()));
    tokio::time::sleep(held_back.min(wait)).await;
    held_back <= wait
}

/// True if the server has started the worker that sent the request.
fn is_own(app: &App, headers: &HeaderMap) -> bool {
    token(headers).is_some_and(|token| app.access.is_own_worker(token))
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
