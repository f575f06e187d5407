//! Bodies read with a bound on their size, declared or not, on the time they take, and on the memory of all of them.

use std::time::Duration;

use axum::body::Body;
use bytes::{Bytes, BytesMut};
use http::{HeaderMap, header};
use http_body_util::BodyExt;
use tokio::sync::{Semaphore, SemaphorePermit};
use tokio::time::Instant;

use crate::limit;
use crate::problem::{ApiError, quote};

/// The media type of a body, lower case and without parameters.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ContentType(String);

impl ContentType {
    /// Of a request; empty where it has none.
    pub fn of(headers: &HeaderMap) -> Self {
        let value = headers.get(header::CONTENT_TYPE).and_then(|value| value.to_str().ok());
        let essence = value.unwrap_or_default().split(';').next().unwrap_or_default();
        Self(essence.trim().to_ascii_lowercase())
    }

    /// Whether it is that one.
    pub fn is(&self, media_type: &str) -> bool {
        self.0 == media_type
    }

    /// Refuses any but those.
    pub fn require(&self, media_types: &[&str]) -> Result<(), ApiError> {
        if media_types.iter().any(|media_type| self.is(media_type)) {
            return Ok(());
        }
        let given = if self.0.is_empty() { "none".to_owned() } else { quote(&self.0) };
        Err(ApiError::media_type(format!("send {}, not {given}", media_types.join(" or "))))
    }
}

/// Memory taken for a body before it has come.
const RESERVE_BYTES: usize = 4 << 20;
/// Bytes that the bodies of this process may still take.
static BODIES: Semaphore = Semaphore::const_new(limit::BODIES_BYTES);
/// The same for workers' messages.
static MESSAGES: Semaphore = Semaphore::const_new(limit::MESSAGES_BYTES);

/// Bytes with the room that they take, which is free again when the last part of them is dropped.
struct Held {
    bytes: Bytes,
    _room: SemaphorePermit<'static>,
}

impl AsRef<[u8]> for Held {
    fn as_ref(&self) -> &[u8] {
        &self.bytes
    }
}

/// The whole body, refused as soon as it is known to be larger than `limit`, too slow, or more than there is room for.
pub async fn read_body(headers: &HeaderMap, body: Body, limit: usize) -> Result<Bytes, ApiError> {
    read_into(&BODIES, headers, body, limit).await
}

/// The same for a worker's message, which has room of its own.
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
    let too_large = || ApiError::too_large(format!("at most {limit} bytes are taken here"));
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
    let mut room: Option<SemaphorePermit<'static>> = None;
    loop {
        let allowance = Duration::from_secs(received as u64 / limit::BODY_RATE);
        let frame = tokio::time::timeout_at(start + limit::BODY + allowance, body.frame())
            .await
            .map_err(|_| ApiError::slow_body("send it faster, or in smaller parts"))?;
        let Some(frame) = frame else { break };
        let frame = frame.map_err(|error| {
            ApiError::bad_request("the body broke off").with_inner(error.to_string())
        })?;
        let Ok(data) = frame.into_data() else { continue };
        received += data.len();
        if received > limit {
            return Err(too_large());
        }
        let taken = room.as_ref().map_or(0, SemaphorePermit::num_permits);
        let more = received.saturating_sub(limit::BODY_FREE + taken);
        if more > 0 {
            let more = u32::try_from(more).map_err(|_| too_large())?;
            let more = budget.try_acquire_many(more).map_err(|_| {
                ApiError::busy("too many large bodies are being read; send it again later")
            })?;
            match &mut room {
                Some(room) => room.merge(more),
                None => room = Some(more),
            }
        }
        match &first {
            None => first = Some(data),
            Some(head) => {
                if rest.is_empty() {
                    // What was declared is believed up to a bound, so that a brood's pictures are not moved again and
                    // again while they come in.
                    rest.reserve(expected.min(RESERVE_BYTES));
                    rest.extend_from_slice(head);
                }
                rest.extend_from_slice(&data);
            }
        }
    }
    let bytes = if rest.is_empty() { first.unwrap_or_default() } else { rest.freeze() };
    Ok(match room {
        Some(room) => Bytes::from_owner(Held { bytes, _room: room }),
        None => bytes,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[tokio::test]
    async fn body_is_refused_when_longer_than_the_limit_declared_or_not() {
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
    async fn body_is_refused_when_there_is_no_room_left_for_large_ones() {
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
            "small ones pass"
        );
        drop(held);
        assert_eq!(budget.available_permits(), 100);
        read(limit::BODY_FREE + 100).await.unwrap();
    }

    #[tokio::test(start_paused = true)]
    async fn body_is_refused_when_it_never_comes() {
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
