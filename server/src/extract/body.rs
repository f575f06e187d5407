//! Request bodies with limits on size, time, and the memory of all bodies together.

use std::time::Duration;

use axum::body::Body;
use bytes::{Bytes, BytesMut};
use http::{HeaderMap, Request, header};
use http_body_util::BodyExt;
use tokio::sync::{Semaphore, SemaphorePermit};
use tokio::time::Instant;

use crate::limit;
use crate::problem::{ApiError, quote};

/// Media type of a body, lower case and without parameters.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ContentType(String);

impl ContentType {
    /// Returns the type of a request; empty if it has none.
    pub fn of(headers: &HeaderMap) -> Self {
        let value = headers.get(header::CONTENT_TYPE).and_then(|value| value.to_str().ok());
        let essence = value.unwrap_or_default().split(';').next().unwrap_or_default();
        Self(essence.trim().to_ascii_lowercase())
    }

    /// Returns true for this media type.
    pub fn is(&self, media_type: &str) -> bool {
        self.0 == media_type
    }

    /// Checks that the type is one of `media_types`.
    ///
    /// # Errors
    /// 415 if it is not.
    pub fn require(&self, media_types: &[&str]) -> Result<(), ApiError> {
        if media_types.iter().any(|media_type| self.is(media_type)) {
            return Ok(());
        }
        let given = if self.0.is_empty() { "none".to_owned() } else { quote(&self.0) };
        Err(ApiError::media_type(format!("must be {}, got {given}", media_types.join(" or "))))
    }
}

/// Memory reserved for a body before its bytes arrive.
const RESERVE_BYTES: usize = 4 << 20;
/// Memory budget of clients' bodies, in bytes.
static BODIES: Semaphore = Semaphore::const_new(limit::BODIES_BYTES);
/// Memory budget of workers' messages, in bytes.
static MESSAGES: Semaphore = Semaphore::const_new(limit::MESSAGES_BYTES);

/// Bytes with the permits for their memory, released when the last reference is dropped.
struct BudgetedBytes {
    bytes: Bytes,
    _permits: SemaphorePermit<'static>,
}

impl AsRef<[u8]> for BudgetedBytes {
    fn as_ref(&self) -> &[u8] {
        &self.bytes
    }
}

/// Reads a whole body.
///
/// # Errors
/// 413 if it is larger than `limit`, 408 if it is too slow, 503 if the memory budget is used up.
pub async fn read_body(headers: &HeaderMap, body: Body, limit: usize) -> Result<Bytes, ApiError> {
    read_into(&BODIES, headers, body, limit).await
}

/// Reads a whole body of one of these media types.
///
/// # Errors
/// 415 for another media type; else as for [`read_body`].
pub async fn read_upload(
    request: Request<Body>,
    media_types: &[&str],
    limit: usize,
) -> Result<(ContentType, Bytes), ApiError> {
    let (head, body) = request.into_parts();
    let content_type = ContentType::of(&head.headers);
    content_type.require(media_types)?;
    Ok((content_type, read_body(&head.headers, body, limit).await?))
}

/// Reads a worker's message, which has a memory budget of its own.
///
/// # Errors
/// As for [`read_body`].
pub async fn read_message(
    headers: &HeaderMap,
    body: Body,
    limit: usize,
) -> Result<Bytes, ApiError> {
    read_into(&MESSAGES, headers, body, limit).await
}

async fn read_into(
    budget: &'static Semaphore,
    headers: &HeaderMap,
    body: Body,
    limit: usize,
) -> Result<Bytes, ApiError> {
    let too_large = || ApiError::too_large(format!("the body must have at most {limit} bytes"));
    let declared = headers.get(header::CONTENT_LENGTH).and_then(|value| value.to_str().ok());
    let declared = declared.and_then(|text| text.parse::<u64>().ok());
    if declared.is_some_and(|n| n > limit as u64) {
        return Err(too_large());
    }
    let expected = declared.and_then(|n| usize::try_from(n).ok()).unwrap_or(0);
    let start = Instant::now();
    let mut body = body;
    let mut first: Option<Bytes> = None;
    let mut rest = BytesMut::new();
    let mut received = 0usize;
    let mut permits: Option<SemaphorePermit<'static>> = None;
    loop {
        let allowance = Duration::from_secs(received as u64 / limit::BODY_RATE);
        let frame = tokio::time::timeout_at(start + limit::BODY + allowance, body.frame())
            .await
            .map_err(|_| ApiError::slow_body("send the body faster, or in smaller parts"))?;
        let Some(frame) = frame else { break };
        let frame = frame.map_err(|error| {
            ApiError::bad_request("the body is incomplete").with_inner(error.to_string())
        })?;
        let Ok(data) = frame.into_data() else { continue };
        received += data.len();
        if received > limit {
            return Err(too_large());
        }
        let taken = permits.as_ref().map_or(0, SemaphorePermit::num_permits);
        let more = received.saturating_sub(limit::BODY_FREE + taken);
        if more > 0 {
            let more = u32::try_from(more).map_err(|_| too_large())?;
            let more = budget
                .try_acquire_many(more)
                .map_err(|_| ApiError::busy("too many large bodies are being read; retry later"))?;
            match &mut permits {
                Some(permits) => permits.merge(more),
                None => permits = Some(more),
            }
        }
        match &first {
            None => first = Some(data),
            Some(head) => {
                if rest.is_empty() {
                    // Reserves the declared size up to a bound, so that a brood's pictures are not
                    // copied repeatedly while they arrive.
                    rest.reserve(expected.min(RESERVE_BYTES));
                    rest.extend_from_slice(head);
                }
                rest.extend_from_slice(&data);
            }
        }
    }
    let bytes = if rest.is_empty() { first.unwrap_or_default() } else { rest.freeze() };
    Ok(match permits {
        Some(permits) => Bytes::from_owner(BudgetedBytes { bytes, _permits: permits }),
        None => bytes,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[tokio::test]
    async fn body_is_refused_when_longer_than_the_limit_with_or_without_content_length() {
        let chunks = |n: usize| {
            let part = |_| Ok::<_, std::io::Error>(Bytes::from_static(b"0123456789"));
            Body::from_stream(futures::stream::iter((0..n).map(part)))
        };
        let none = HeaderMap::new();
        assert_eq!(read_body(&none, chunks(3), 30).await.unwrap().len(), 30);
        assert_eq!(read_body(&none, chunks(4), 30).await.unwrap_err().status(), 413);
        let mut declared = HeaderMap::new();
        declared.insert(header::CONTENT_LENGTH, "31".parse().unwrap());
        assert_eq!(read_body(&declared, chunks(0), 30).await.unwrap_err().status(), 413);
    }

    #[tokio::test]
    async fn large_body_is_refused_when_the_memory_budget_is_used_up() {
        let budget: &'static Semaphore = Box::leak(Box::new(Semaphore::new(100)));
        let none = HeaderMap::new();
        let read = |n: usize| {
            let part = |_| Ok::<_, std::io::Error>(Bytes::from_static(&[7; 1024]));
            let parts = (0..n / 1024).map(part);
            let last = Ok(Bytes::from(vec![8; n % 1024]));
            let body = Body::from_stream(futures::stream::iter(parts.chain([last])));
            read_into(budget, &none, body, 1 << 20)
        };
        let held = read(limit::BODY_FREE + 60).await.unwrap();
        assert_eq!((held.len(), held[held.len() - 1]), (limit::BODY_FREE + 60, 8));
        assert_eq!(read(limit::BODY_FREE + 60).await.unwrap_err().status(), 503);
        assert_eq!(
            read(limit::BODY_FREE).await.unwrap().len(),
            limit::BODY_FREE,
            "small bodies need no permit"
        );
        drop(held);
        assert_eq!(budget.available_permits(), 100);
        read(limit::BODY_FREE + 100).await.unwrap();
    }

    #[tokio::test(start_paused = true)]
    async fn body_is_refused_when_it_never_arrives() {
        let body = Body::from_stream(futures::stream::pending::<Result<Bytes, std::io::Error>>());
        let error = read_body(&HeaderMap::new(), body, 30).await.unwrap_err();
        assert_eq!(error.status(), 408);
    }

    #[test]
    fn content_type_ignores_case_and_parameters() {
        let mut headers = HeaderMap::new();
        headers.insert(header::CONTENT_TYPE, "Application/JSON; charset=utf-8".parse().unwrap());
        assert!(ContentType::of(&headers).require(&["application/json"]).is_ok());
        assert!(ContentType::of(&headers).require(&["model/obj"]).is_err());
        assert!(ContentType::of(&HeaderMap::new()).require(&["model/obj"]).is_err());
    }
}
