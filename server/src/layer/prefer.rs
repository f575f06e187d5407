//! `Prefer: respond-async` (RFC 7240): defers the answers of requests that take long.

use std::sync::Arc;
use std::time::Duration;

use axum::Json;
use axum::body::Body;
use axum::extract::{Request, State};
use axum::middleware::Next;
use axum::response::{IntoResponse, Response};
use http::{HeaderMap, HeaderName, HeaderValue, Method, StatusCode, header};
use tokio_util::task::AbortOnDropHandle;
use tracing::Instrument;

use crate::client::Client;
use crate::deferred::{AnswerProgress, RequestOutline};
use crate::extract::read_body;
use crate::limit;
use crate::problem::ApiError;
use crate::state::App;

const PREFER: HeaderName = HeaderName::from_static("prefer");
const APPLIED: HeaderName = HeaderName::from_static("preference-applied");
/// Time after which an answer is deferred if the request has no `wait`.
const WAIT: Duration = Duration::from_millis(100);

/// Answers with 202 and a job if the request has `Prefer: respond-async` and its answer is not
/// ready in time.
///
/// # Errors
/// 503 if too many answers are deferred.
pub async fn defer(
    State(app): State<App>,
    request: Request,
    next: Next,
) -> Result<Response, ApiError> {
    let wait = match *request.method() {
        Method::GET | Method::POST => wait(request.headers()),
        _ => None,
    };
    let Some(wait) = wait else { return Ok(next.run(request).await) };
    let client = Client::current();
    let place = app.deferred.place(client)?;
    let (mut head, body) = request.into_parts();
    // The answer is kept for a client that may have none.
    head.headers.remove(header::IF_NONE_MATCH);
    let bytes = read_body(&head.headers, body, limit::JSON_BYTES).await?;
    let outline = RequestOutline { method: head.method.clone(), uri: head.uri.clone(), client };
    let progress = Arc::new(AnswerProgress::default());
    let handled = next.run(Request::from_parts(head, Body::from(bytes)));
    let handled = client.run(progress.clone().run(handled)).in_current_span();
    // Dropping it ends the handler if the client disconnects before the 202.
    let mut task = AbortOnDropHandle::new(app.tasks.spawn(handled));
    if let Ok(answered) = tokio::time::timeout(wait, &mut task).await {
        return answered.map_err(|error| ApiError::internal(format!("a handler ended: {error}")));
    }
    let job = app.deferred.keep((outline, place), progress, task.detach())?;
    let mut response = (StatusCode::ACCEPTED, Json(&job)).into_response();
    let headers = response.headers_mut();
    headers.insert(APPLIED, HeaderValue::from_static("respond-async"));
    headers.insert(header::CACHE_CONTROL, HeaderValue::from_static("no-store"));
    let location = HeaderValue::from_str(&format!("/v1/jobs/{}", job.id));
    headers.insert(header::LOCATION, location.expect("an id is plain text"));
    Ok(response)
}

/// Returns the time after which the answer is deferred; `None` without `respond-async`. Preferences
/// that cannot be read are ignored, as the RFC says.
fn wait(headers: &HeaderMap) -> Option<Duration> {
    let lines = headers.get_all(PREFER).iter().filter_map(|line| line.to_str().ok());
    let preferences = lines.flat_map(|line| line.split(','));
    let (mut is_deferred, mut wait) = (false, WAIT);
    for preference in preferences {
        let token = preference.split(';').next().unwrap_or_default();
        let (name, value) = token.split_once('=').unwrap_or((token, ""));
        match name.trim().to_ascii_lowercase().as_str() {
            "respond-async" => is_deferred = true,
            "wait" => {
                let seconds = value.trim().trim_matches('"').parse().ok();
                wait = seconds.map_or(wait, Duration::from_secs);
            }
            _ => {}
        }
    }
    is_deferred.then_some(wait.min(limit::WAIT))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn preferences_are_read_from_all_lines() {
        let of = |lines: &[&str]| {
            let mut headers = HeaderMap::new();
            for line in lines {
                headers.append(PREFER, line.parse().unwrap());
            }
            wait(&headers).map(|wait| wait.as_millis())
        };
        assert_eq!(of(&[]), None);
        assert_eq!(of(&["return=minimal", "wait=5"]), None);
        assert_eq!(of(&["respond-async"]), Some(100));
        assert_eq!(of(&["Respond-Async; foo=1, wait = \"3\""]), Some(3000));
        assert_eq!(of(&["wait=0", "respond-async"]), Some(0));
        assert_eq!(of(&["respond-async, wait=x, wait"]), Some(100));
        assert_eq!(of(&["respond-async, wait=99999999999"]), Some(20_000));
    }
}
