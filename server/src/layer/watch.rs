//! Request bodies that record whether they were read to the end.

use std::pin::Pin;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::task::{Context, Poll, ready};

use axum::body::{Body, HttpBody};
use axum::extract::Request;
use bytes::Bytes;
use hyper::body::{Frame, SizeHint};

struct TrackedBody {
    body: Body,
    ended: Arc<AtomicBool>,
}

/// Wraps the request's body; the flag is set once the body was read to the end.
pub fn watch(request: Request) -> (Request, Arc<AtomicBool>) {
    let ended = Arc::new(AtomicBool::new(request.body().is_end_stream()));
    let flag = ended.clone();
    (request.map(|body| Body::new(TrackedBody { body, ended: flag })), ended)
}

impl HttpBody for TrackedBody {
    type Data = Bytes;
    type Error = axum::Error;

    fn poll_frame(
        mut self: Pin<&mut Self>,
        cx: &mut Context<'_>,
    ) -> Poll<Option<Result<Frame<Bytes>, axum::Error>>> {
        let frame = ready!(Pin::new(&mut self.body).poll_frame(cx));
        if frame.is_none() || self.body.is_end_stream() {
            self.ended.store(true, Ordering::Relaxed);
        }
        Poll::Ready(frame)
    }

    fn is_end_stream(&self) -> bool {
        self.body.is_end_stream()
    }

    fn size_hint(&self) -> SizeHint {
        self.body.size_hint()
    }
}

#[cfg(test)]
mod tests {
    use http_body_util::BodyExt;

    use super::*;

    #[tokio::test]
    async fn flag_is_set_when_the_body_was_read_to_the_end() {
        let (_, ended) = watch(Request::new(Body::empty()));
        assert!(ended.load(Ordering::Relaxed), "there is nothing to read");
        let (request, ended) = watch(Request::new(Body::from("body")));
        assert!(!ended.load(Ordering::Relaxed));
        request.into_body().collect().await.unwrap();
        assert!(ended.load(Ordering::Relaxed));
    }
}
