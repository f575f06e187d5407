//! Error answers, and the only place with status codes.
//!
//! An [`ApiError`] becomes a response without a body that carries the problem as an extension. The
//! outermost layer adds the request id, logs internal details, and writes the body.

mod from;

pub use from::serde_words;

use std::sync::Arc;

use axum::response::{IntoResponse, Response};
use brood_protocol::Problem;
use http::{HeaderName, HeaderValue, StatusCode, header};

/// Error of a request.
#[derive(Debug, Clone)]
pub struct ApiError {
    answer: Box<Answer>,
}

#[derive(Debug, Clone)]
struct Answer {
    problem: Problem,
    headers: Vec<(HeaderName, String)>,
    inner: Option<String>,
    is_outage: bool,
}

/// Problem on its way to the outermost layer.
#[derive(Debug, Clone)]
pub struct Pending {
    /// Problem without the request's id.
    pub problem: Problem,
    /// Details for the log only.
    pub inner: Option<Arc<str>>,
    /// True if the reason is the loss of another server, which ends by itself, so that the time of
    /// the next attempt does not depend on waiting pictures.
    pub is_outage: bool,
}

macro_rules! kinds {
    ($($(#[$doc:meta])* $name:ident = $status:ident, $slug:literal, $title:literal;)*) => {
        impl ApiError {$(
            $(#[$doc])*
            pub fn $name(detail: impl Into<String>) -> Self {
                Self::new(StatusCode::$status, $slug, $title, detail.into())
            }
        )*}
    };
}

kinds! {
    /// 400: a malformed value, query parameter or header.
    bad_request = BAD_REQUEST, "bad-request", "The request is malformed";
    /// 400 with a pointer: malformed or unexpected JSON.
    bad_json = BAD_REQUEST, "bad-json", "The JSON is invalid";
    /// 401: no token, or an invalid one.
    unauthorized = UNAUTHORIZED, "token-needed", "A token is required";
    /// 403: the token's scope is too small.
    forbidden = FORBIDDEN, "scope", "The token's scope is too small";
    /// 403: the request comes from another site's page.
    cross_origin = FORBIDDEN, "cross-origin", "Writes from other sites are refused";
    /// 404: no such resource.
    not_found = NOT_FOUND, "unknown-id", "Not found";
    /// 404: no such route.
    no_route = NOT_FOUND, "unknown-route", "Unknown address";
    /// 405.
    method = METHOD_NOT_ALLOWED, "method", "Method not allowed";
    /// 408: the body arrived too slowly.
    slow_body = REQUEST_TIMEOUT, "slow-body", "The body took too long";
    /// 409: the lease is not valid any more.
    stale_lease = CONFLICT, "stale-lease", "The lease is no longer valid";
    /// 409: the resource's state does not allow the change.
    conflict = CONFLICT, "conflict", "Conflicts with the current state";
    /// 409: the first request of an idempotency key is still running.
    running = CONFLICT, "still-running", "The first request with this key is still running";
    /// 410: a picture of an older renderer.
    gone = GONE, "older-renderer", "The picture is from an older renderer";
    /// 412: the resource has changed since it was read.
    stale_version = PRECONDITION_FAILED, "stale-version", "Changed since it was last read";
    /// 412: a worker of another version than the server.
    other_worker = PRECONDITION_FAILED, "other-worker", "The worker is of another version";
    /// 413: the body is too large.
    too_large = PAYLOAD_TOO_LARGE, "too-large", "The body is too large";
    /// 415: unsupported content type.
    media_type = UNSUPPORTED_MEDIA_TYPE, "media-type", "Unsupported content type";
    /// 421: the request is for another host name.
    foreign_host = MISDIRECTED_REQUEST, "foreign-host", "Unknown host name";
    /// 422: well-formed input with invalid values.
    refused = UNPROCESSABLE_ENTITY, "refused", "Invalid input";
    /// 422: invalid genome text or JSON.
    bad_genome = UNPROCESSABLE_ENTITY, "bad-genome", "Invalid genome";
    /// 422: an invalid OBJ file.
    bad_mesh = UNPROCESSABLE_ENTITY, "bad-mesh", "Invalid mesh";
    /// 428: a change without `If-Match`.
    no_if_match = PRECONDITION_REQUIRED, "if-match-needed", "If-Match is required";
    /// 500: a worker cannot render a picture.
    render_failed = INTERNAL_SERVER_ERROR, "render-failed", "The picture could not be rendered";
    /// 503: too many requests are waiting.
    busy = SERVICE_UNAVAILABLE, "busy", "The server is busy";
    /// 503: the server is stopping.
    stopping = SERVICE_UNAVAILABLE, "stopping", "The server is stopping";
    /// 503: the picture takes longer than a request may wait.
    not_yet = SERVICE_UNAVAILABLE, "not-yet", "The picture is not ready yet";
    /// 507: the disk is full.
    disk_full = INSUFFICIENT_STORAGE, "disk-full", "The disk is full";
}

impl ApiError {
    fn new(status: StatusCode, slug: &str, title: &str, detail: String) -> Self {
        let problem = Problem {
            r#type: format!("/problems/{slug}"),
            title: title.to_owned(),
            status: status.as_u16(),
            detail,
            ..Problem::default()
        };
        let mut headers = Vec::new();
        if status == StatusCode::SERVICE_UNAVAILABLE {
            headers.push((header::RETRY_AFTER, "1".to_owned()));
        }
        if status == StatusCode::UNAUTHORIZED {
            headers.push((header::WWW_AUTHENTICATE, "Bearer realm=\"brood\"".to_owned()));
        }
        Self { answer: Box::new(Answer { problem, headers, inner: None, is_outage: false }) }
    }

    /// 500: `inner` goes to the log only.
    pub fn internal(inner: impl Into<String>) -> Self {
        let title = "Internal server error";
        let detail = "the server's log has the reason under this request id".to_owned();
        let mut error = Self::new(StatusCode::INTERNAL_SERVER_ERROR, "internal", title, detail);
        error.answer.inner = Some(inner.into());
        error
    }

    /// 400 for a query parameter.
    pub fn bad_parameter(name: &str, detail: impl std::fmt::Display) -> Self {
        Self::bad_request(format!("query parameter `{name}`: {detail}"))
    }

    /// Adds a JSON pointer into the body.
    pub fn at(mut self, pointer: impl Into<String>) -> Self {
        self.answer.problem.pointer = Some(pointer.into());
        self
    }

    /// Prefixes the pointer, for an error in a part of a larger JSON body. A 404 becomes a 422: the
    /// address of the request exists, its body is invalid.
    pub fn inside(self, prefix: &str) -> Self {
        let problem = &self.answer.problem;
        let pointer = format!("{prefix}{}", problem.pointer.as_deref().unwrap_or_default());
        let is_missing = problem.status == StatusCode::NOT_FOUND.as_u16();
        let own = if is_missing { Self::refused(problem.detail.clone()) } else { self };
        own.at(pointer)
    }

    /// Adds a position in a text body.
    pub fn at_line(mut self, line: u32, column: Option<u32>) -> Self {
        self.answer.problem.line = Some(line);
        self.answer.problem.column = column;
        self
    }

    /// Adds a header to the answer.
    pub fn with_header(mut self, name: HeaderName, value: impl Into<String>) -> Self {
        self.answer.headers.retain(|(present, _)| *present != name);
        self.answer.headers.push((name, value.into()));
        self
    }

    /// Adds details for the log only.
    pub fn with_inner(mut self, inner: impl Into<String>) -> Self {
        self.answer.inner = Some(inner.into());
        self
    }

    /// 503: the database or the object store cannot be used. `inner` goes to the log only.
    pub fn outage(detail: impl Into<String>, inner: impl Into<String>) -> Self {
        let mut error = Self::busy(detail).with_inner(inner);
        error.answer.is_outage = true;
        error
    }

    /// Status of the answer.
    pub fn status(&self) -> u16 {
        self.answer.problem.status
    }

    /// Problem of the answer.
    pub fn problem(&self) -> &Problem {
        &self.answer.problem
    }
}

impl IntoResponse for ApiError {
    fn into_response(self) -> Response {
        let Answer { problem, headers, inner, is_outage } = *self.answer;
        let status = StatusCode::from_u16(problem.status).expect("problems carry real statuses");
        let mut response = status.into_response();
        for (name, value) in headers {
            if let Ok(value) = HeaderValue::from_str(&value) {
                response.headers_mut().insert(name, value);
            }
        }
        let inner = inner.map(Arc::from);
        response.extensions_mut().insert(Pending { problem, inner, is_outage });
        response
    }
}

/// Returns the problem of an error answer that carries none, made from its status.
pub fn plain(status: StatusCode) -> Problem {
    let title = status.canonical_reason().unwrap_or("The request failed").to_owned();
    Problem {
        r#type: "about:blank".to_owned(),
        detail: title.clone(),
        title,
        status: status.as_u16(),
        ..Problem::default()
    }
}

/// Returns input for an error text: at most 64 bytes, without control characters.
pub fn quote(input: &str) -> String {
    shortened(input, 64)
}

/// Returns text of at most `bytes` bytes, which ends with an ellipsis if it was longer, without
/// control characters.
fn shortened(text: &str, bytes: usize) -> String {
    let clean = text.chars().map(|c| if c.is_control() { ' ' } else { c });
    let mut out = String::new();
    for c in clean {
        if out.len() + c.len_utf8() + '…'.len_utf8() > bytes {
            out.push('…');
            break;
        }
        out.push(c);
    }
    out
}

#[cfg(test)]
mod tests {
    use brood_storage::StorageError;

    use super::*;

    #[test]
    fn quote_keeps_to_64_bytes_when_input_is_long() {
        assert_eq!(quote("short"), "short");
        for input in ["x".repeat(1000), "ä".repeat(1000), "🐄".repeat(1000)] {
            assert!(quote(&input).len() <= 64);
            assert!(quote(&input).ends_with('…'));
        }
        assert_eq!(quote("a\nb"), "a b");
    }

    #[test]
    fn error_inside_a_body_points_from_the_root_and_is_not_a_404() {
        let inside = |error: ApiError| {
            let error = error.inside("/views/1/scene");
            (error.status(), error.problem().pointer.clone().unwrap())
        };
        let mesh = ApiError::not_found("there is no mesh").at("/mesh");
        assert_eq!(inside(mesh), (422, "/views/1/scene/mesh".to_owned()));
        assert_eq!(inside(ApiError::bad_json("x")), (400, "/views/1/scene".to_owned()));
    }

    #[test]
    fn error_carries_its_problem_and_headers() {
        let response = ApiError::busy("later").into_response();
        assert_eq!(response.status(), 503);
        assert_eq!(response.headers()[header::RETRY_AFTER], "1");
        let pending = response.extensions().get::<Pending>().unwrap();
        assert_eq!(pending.problem.r#type, "/problems/busy");
        assert_eq!(pending.problem.detail, "later");
        assert!(!pending.is_outage);
        let outage = ApiError::from(StorageError::Unreachable("gone".to_owned())).into_response();
        assert_eq!(outage.headers()[header::RETRY_AFTER], "1");
        assert!(outage.extensions().get::<Pending>().unwrap().is_outage);
    }
}
