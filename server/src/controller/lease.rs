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
use brood_protocol::{
    CONTENT_TYPE, Ticket, WORKER_HEADER, WireError, decode, decode_stored, encode, worker_version,
};
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

/// Message of a worker of this server's version, of at most `MAX` bytes.
pub struct Message<T, const MAX: usize>(T);

impl<T: DeserializeOwned, const MAX: usize, S: Send + Sync> FromRequest<S> for Message<T, MAX> {
    type Rejection = ApiError;

    async fn from_request(request: Request<Body>, _: &S) -> Result<Self, ApiError> {
        check_version(request.headers())?;
        read(request, MAX, decode).await.map(Self)
    }
}

/// Ticket in the body, of the lease that the address names. Workers of other versions send tickets,
/// too: the server that granted the lease may have ended.
pub struct Held<T>(T);

impl<T: Ticket<Key: DeserializeOwned>, S: Send + Sync> FromRequest<S> for Held<T> {
    type Rejection = ApiError;

    async fn from_request(request: Request<Body>, state: &S) -> Result<Self, ApiError> {
        let (mut head, body) = request.into_parts();
        let Path(key) = Path::<T::Key>::from_request_parts(&mut head, state).await?;
        let request = Request::from_parts(head, body);
        let ticket: T = read(request, limit::JSON_BYTES, decode_stored).await?;
        check_same(key, &ticket)?;
        Ok(Self(ticket))
    }
}

/// Error if a worker does not have the version of this server. It would not understand its jobs.
fn check_version(headers: &HeaderMap) -> Result<(), ApiError> {
    let given = headers.get(WORKER_HEADER).map(|value| value.to_str().unwrap_or_default());
    let own = worker_version();
    if given == Some(own.as_str()) {
        return Ok(());
    }
    let given = given.map_or_else(|| "none".to_owned(), quote);
    Err(ApiError::other_worker(format!(
        "the worker must be of version {own}, like this server, got {given}"
    )))
}

/// Reads and decodes a body of at most `most` bytes.
async fn read<T>(
    request: Request<Body>,
    most: usize,
    decode: impl FnOnce(&[u8]) -> Result<T, WireError>,
) -> Result<T, ApiError> {
    let (head, body) = request.into_parts();
    ContentType::of(&head.headers).require(&[CONTENT_TYPE])?;
    let bytes = read_message(&head.headers, body, most).await?;
    decode(&bytes).map_err(|error| ApiError::bad_request(quote(&error.to_string())))
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

#[cfg(test)]
mod tests {
    use brood_protocol::{JobId, SearchRequest, SearchTicket};

    use super::*;

    fn request(version: Option<&str>, body: Vec<u8>) -> Request<Body> {
        let mut request = Request::builder().header(header::CONTENT_TYPE, CONTENT_TYPE);
        if let Some(version) = version {
            request = request.header(WORKER_HEADER, version);
        }
        request.body(Body::from(body)).unwrap()
    }

    #[tokio::test]
    async fn only_workers_of_the_own_version_get_jobs() {
        let body = encode(&SearchRequest { worker: "w".to_owned(), wait_ms: 0 });
        let status = async |version: Option<&str>| {
            let request = request(version, body.clone());
            let read = Message::<SearchRequest, 1000>::from_request(request, &()).await;
            read.map_or_else(|error| error.status(), |_| 200)
        };
        let own = worker_version();
        assert_eq!(status(Some(own.as_str())).await, 200);
        assert_eq!(status(Some("z.1")).await, 412);
        assert_eq!(status(Some(&own[..own.len() - 1])).await, 412);
        assert_eq!(status(None).await, 412);
    }

    #[tokio::test]
    async fn workers_of_another_version_return_searches() {
        let ticket = SearchTicket { job: JobId::fresh(), epoch: 7 };
        let mut body = encode(&ticket);
        body[6] = b'z';
        let read = read::<SearchTicket>(request(Some("z.1"), body), 1000, decode_stored).await;
        assert_eq!(read.unwrap(), ticket);
    }
}
