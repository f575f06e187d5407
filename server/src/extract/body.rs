//! Request bodies with limits on size, time, and the memory of all bodies together.

use axum::body::Body;
use bytes::{Bytes, BytesMut};
use http::{HeaderMap, Request, header};
use http_body_util::BodyExt;
use tokio::sync::SemaphorePermit;

use super::body_budget::BodyBudget;
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
/// Memory of clients' bodies.
static BODIES: BodyBudget = BodyBudget::new(limit::BODIES_BYTES, limit::CLIENT_BODIES);
/// Memory of workers' messages.
static MESSAGES: BodyBudget = BodyBudget::new(limit::MESSAGES_BYTES, usize::MAX);

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
    budget: &'static BodyBudget,
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
    let mut body = body;
    let mut first: Option<Bytes> = None;
    let mut rest = BytesMut::new();
    let mut memory = budget.body();
    loop {
        let frame = tokio::select! {
            frame = tokio::time::timeout_at(memory.deadline(), body.frame()) => frame,
            () = memory.taken() => return Err(ApiError::slow_body(
                "the memory of this slow body was needed for others; send it faster, or later",
            )),
        };
        let frame =
            frame.map_err(|_| ApiError::slow_body("send the body faster, or in smaller parts"))?;
        let Some(frame) = frame else { break };
        let frame = frame.map_err(|error| {
            ApiError::bad_request("the body is incomplete").with_inner(error.to_string())
        })?;
        let Ok(data) = frame.into_data() else { continue };
        if memory.add(data.len()) > limit {
            return Err(too_large());
        }
        memory.reserve().await?;
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
    Ok(match memory.into_permits() {
        Some(permits) => Bytes::from_owner(BudgetedBytes { bytes, _permits: permits }),
        None => bytes,
    })
}

#[cfg(test)]
mod tests {
    use futures::StreamExt;

    use super::*;
    use crate::client::Client;

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
        let budget: &'static BodyBudget = Box::leak(Box::new(BodyBudget::new(100, usize::MAX)));
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
        read(limit::BODY_FREE + 100).await.unwrap();
    }

    /// Body that sends parts of this size after these pauses, and then nothing.
    fn arriving(parts: Vec<(usize, u64)>) -> Body {
        let parts = futures::stream::iter(parts).then(|(bytes, pause_s)| async move {
            tokio::time::sleep(std::time::Duration::from_secs(pause_s)).await;
            Ok::<_, std::io::Error>(Bytes::from(vec![7; bytes]))
        });
        Body::from_stream(parts.chain(futures::stream::pending()))
    }

    #[tokio::test(start_paused = true)]
    async fn large_body_is_refused_ten_seconds_after_it_stops() {
        let start = tokio::time::Instant::now();
        let body = arriving(vec![(20 << 20, 1)]);
        let error = read_body(&HeaderMap::new(), body, 30 << 20).await.unwrap_err();
        assert_eq!((error.status(), start.elapsed().as_secs()), (408, 11));
        // At 9 KiB/s.
        let start = tokio::time::Instant::now();
        let body = arriving((0..100).map(|_| (9 << 10, 1)).collect());
        read_body(&HeaderMap::new(), body, 30 << 20).await.unwrap_err();
        assert!((100..=110).contains(&start.elapsed().as_secs()));
    }

    #[tokio::test(start_paused = true)]
    async fn slow_body_gives_its_memory_up_for_another() {
        let budget: &'static BodyBudget = Box::leak(Box::new(BodyBudget::new(100, usize::MAX)));
        let none = HeaderMap::new();
        let large = limit::BODY_FREE + 60;
        let slow = arriving([(large, 0)].into_iter().chain((0..20).map(|_| (0, 1))).collect());
        let slow = tokio::spawn(async move {
            let none = HeaderMap::new();
            read_into(budget, &none, slow, 1 << 20).await
        });
        tokio::time::sleep(std::time::Duration::from_secs(5)).await;
        let read = read_into(budget, &none, Body::from(vec![8; large]), 1 << 20).await.unwrap();
        assert_eq!(read.len(), large);
        let error = slow.await.unwrap().unwrap_err();
        assert_eq!(error.status(), 408);
        // Memory of a body that has arrived stays with it.
        let refused = read_into(budget, &none, Body::from(vec![8; large]), 1 << 20).await;
        assert_eq!(refused.unwrap_err().status(), 503);
    }

    #[tokio::test(start_paused = true)]
    async fn client_sends_only_so_many_large_bodies_at_once() {
        let budget: &'static BodyBudget = Box::leak(Box::new(BodyBudget::new(1 << 30, 2)));
        let large = limit::BODY_FREE + 60;
        let read = |client: Client, body: Body| {
            client.run(async move { read_into(budget, &HeaderMap::new(), body, 1 << 20).await })
        };
        let one = Client::Token([1; 32]);
        for _ in 0..2 {
            tokio::spawn(read(one, arriving(vec![(large, 0)])));
        }
        tokio::time::sleep(std::time::Duration::from_secs(1)).await;
        let refused = read(one, Body::from(vec![8; large])).await.unwrap_err();
        assert_eq!(refused.status(), 503);
        read(one, Body::from(vec![8; 60])).await.unwrap();
        read(Client::Token([2; 32]), Body::from(vec![8; large])).await.unwrap();
        // Both are given up after 10 s.
        tokio::time::sleep(std::time::Duration::from_secs(12)).await;
        read(one, Body::from(vec![8; large])).await.unwrap();
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
