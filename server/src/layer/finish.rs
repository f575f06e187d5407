//! Outermost layer: request ids, tracing spans, metrics, problem bodies and security headers.

use std::sync::atomic::Ordering;
use std::time::Instant;

use axum::body::Body;
use axum::extract::{MatchedPath, Request, State};
use axum::middleware::Next;
use axum::response::Response;
use brood_protocol::RequestId;
use http::{HeaderMap, HeaderName, HeaderValue, Method, StatusCode, header};
use tracing::Instrument;

use super::watch::watch;
use crate::problem::{Pending, plain};
use crate::state::App;

const REQUEST_ID: HeaderName = HeaderName::from_static("x-request-id");
const POLICY: &str = "default-src 'self'; img-src 'self' blob: data:; style-src 'self'; \
                      object-src 'none'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'";
/// Policy of the documentation page, which sets styles inline. Its scripts are files.
const DOCS_POLICY: &str = "default-src 'self'; img-src 'self' blob: data:; \
                           style-src 'self' 'unsafe-inline'; object-src 'none'; base-uri 'none'; \
                           frame-ancestors 'none'";

/// Runs a request under a new id and completes the answer.
pub async fn finish(State(app): State<App>, request: Request, next: Next) -> Response {
    let start = Instant::now();
    let id = RequestId::fresh();
    let method = request.method().clone();
    let docs = request.uri().path().starts_with("/docs");
    let route = request.extensions().get::<MatchedPath>().cloned();
    let route = route.as_ref().map_or("none", MatchedPath::as_str);
    let span = tracing::info_span!("request", %id, %method, route);
    let (request, read_to_the_end) = watch(request);
    let mut response = next.run(request).instrument(span.clone()).await;
    let status = response.status();
    let pending = response.extensions().get::<Pending>();
    if status == StatusCode::SERVICE_UNAVAILABLE
        && !pending.is_some_and(|pending| pending.is_outage)
        && response.headers().contains_key(header::RETRY_AFTER)
    {
        let seconds = app.pictures.retry_after_s();
        response.headers_mut().insert(header::RETRY_AFTER, HeaderValue::from(seconds));
    }
    if status.is_client_error() || status.is_server_error() {
        let _entered = span.enter();
        write_problem(&mut response, &method, id);
    }
    let headers = response.headers_mut();
    if let Ok(value) = HeaderValue::from_str(&id.to_string()) {
        headers.insert(REQUEST_ID, value);
    }
    secure(headers, docs);
    if !read_to_the_end.load(Ordering::Relaxed) {
        // The unread rest of the body closes the connection. Without this header, a client would
        // send its next request into the closing connection.
        headers.insert(header::CONNECTION, HeaderValue::from_static("close"));
    }
    let elapsed = start.elapsed();
    app.metrics.request(method.as_str(), route, status.as_u16(), elapsed);
    span.in_scope(|| {
        tracing::debug!(
            status = status.as_u16(),
            elapsed_us = elapsed.as_micros() as u64,
            "answered"
        );
    });
    response
}

fn secure(headers: &mut HeaderMap, docs: bool) {
    let policy = if docs { DOCS_POLICY } else { POLICY };
    headers.insert(header::CONTENT_SECURITY_POLICY, HeaderValue::from_static(policy));
    headers.insert(header::X_CONTENT_TYPE_OPTIONS, HeaderValue::from_static("nosniff"));
    headers.insert(header::REFERRER_POLICY, HeaderValue::from_static("same-origin"));
}

/// Writes the body of an error: its own problem, or one made from the status.
fn write_problem(response: &mut Response, method: &Method, id: RequestId) {
    let pending = response.extensions_mut().remove::<Pending>();
    let status = response.status();
    let (mut problem, inner) = match pending {
        Some(pending) => (pending.problem, pending.inner),
        None => (plain(status), None),
    };
    if let Some(inner) = inner.as_deref().filter(|_| status.is_client_error()) {
        tracing::debug!(status = status.as_u16(), reason = %inner, "request refused");
    } else if let Some(inner) = inner {
        tracing::error!(status = status.as_u16(), reason = %inner, "request failed");
    } else if status == StatusCode::INTERNAL_SERVER_ERROR {
        tracing::error!(status = status.as_u16(), reason = %problem.detail, "request failed");
    }
    problem.request_id = Some(id.to_string());
    let body = serde_json::to_vec(&problem).expect("problems serialise without errors");
    let headers = response.headers_mut();
    let problem_json = HeaderValue::from_static("application/problem+json");
    headers.insert(header::CONTENT_TYPE, problem_json);
    headers.insert(header::CACHE_CONTROL, HeaderValue::from_static("no-store"));
    headers.insert(header::CONTENT_LENGTH, HeaderValue::from(body.len()));
    *response.body_mut() = if method == Method::HEAD { Body::empty() } else { Body::from(body) };
}
