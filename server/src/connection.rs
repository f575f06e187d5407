//! Connection stream with deadlines: cuts off slow heads, idle connections, and clients that never
//! read.
//!
//! hyper's own timer cannot tell a slow head from a keep-alive connection that waits for its next
//! request. This stream can, because the service reports when requests begin and end.

use std::io;
use std::pin::Pin;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::task::{Context, Poll, ready};
use std::time::Duration;

use axum::body::Body;
use http::Response;
use http_body_util::BodyExt;
use tokio::io::{AsyncRead, AsyncWrite, ReadBuf};
use tokio::time::{Instant, Sleep};

use crate::limit;

/// Request counter of one connection.
#[derive(Debug)]
pub struct Requests {
    begun: AtomicU64,
    ended: AtomicU64,
    opened: Instant,
    /// Milliseconds from `opened` to the end of the last request.
    quiet_ms: AtomicU64,
}

impl Default for Requests {
    fn default() -> Self {
        let zero = AtomicU64::default;
        Self { begun: zero(), ended: zero(), opened: Instant::now(), quiet_ms: zero() }
    }
}

impl Requests {
    /// Returns the time since which no request has run; `None` if one is running.
    pub fn idle_since(&self) -> Option<Instant> {
        let quiet = Duration::from_millis(self.quiet_ms.load(Ordering::Relaxed));
        (!self.counts().1).then_some(self.opened + quiet)
    }

    /// Counts a request as running until the guard is dropped.
    pub fn begin(self: &Arc<Self>) -> Running {
        self.begun.fetch_add(1, Ordering::Relaxed);
        Running(self.clone())
    }

    fn counts(&self) -> (u64, bool) {
        let begun = self.begun.load(Ordering::Relaxed);
        (begun, begun > self.ended.load(Ordering::Relaxed))
    }
}

/// Guard of a running request.
#[derive(Debug)]
pub struct Running(Arc<Requests>);

impl Drop for Running {
    fn drop(&mut self) {
        let quiet = u64::try_from(self.0.opened.elapsed().as_millis()).unwrap_or(u64::MAX);
        self.0.quiet_ms.store(quiet, Ordering::Relaxed);
        self.0.ended.fetch_add(1, Ordering::Relaxed);
    }
}

impl Running {
    /// Counts the request as running until the body of its answer has been sent.
    pub fn until_sent(self, response: Response<Body>) -> Response<Body> {
        // The closure owns the guard and is dropped with the body.
        response.map(|body| {
            Body::new(body.map_err(move |error| {
                let _guard = &self;
                error
            }))
        })
    }
}

/// Stream with read and write deadlines.
pub struct DeadlineStream<S> {
    stream: S,
    requests: Arc<Requests>,
    /// Number of requests begun before the first byte of the current head.
    seen: u64,
    head_since: Option<Instant>,
    moved: Instant,
    blocked_since: Option<Instant>,
    closed: Option<Instant>,
    read_timer: Pin<Box<Sleep>>,
    write_timer: Pin<Box<Sleep>>,
}

impl<S> DeadlineStream<S> {
    /// Wraps a stream; `requests` counts the requests on it.
    pub fn new(stream: S, requests: Arc<Requests>) -> Self {
        Self {
            stream,
            requests,
            seen: 0,
            head_since: None,
            moved: Instant::now(),
            blocked_since: None,
            closed: None,
            read_timer: Box::pin(tokio::time::sleep(limit::IDLE)),
            write_timer: Box::pin(tokio::time::sleep(limit::IDLE)),
        }
    }

    /// Returns the deadline for the next byte; `None` while a request is running or its answer is
    /// being sent, whose bodies have limits of their own.
    fn read_deadline(&mut self) -> Option<Instant> {
        let (begun, running) = self.requests.counts();
        if begun != self.seen {
            self.seen = begun;
            self.head_since = None;
        }
        if running {
            return None;
        }
        let idle = self.moved + limit::IDLE;
        Some(self.head_since.map_or(idle, |since| idle.min(since + limit::HEAD)))
    }
}

fn expired(timer: &mut Pin<Box<Sleep>>, deadline: Instant, cx: &mut Context<'_>) -> bool {
    if timer.deadline() != deadline {
        timer.as_mut().reset(deadline);
    }
    timer.as_mut().poll(cx).is_ready()
}

impl<S: AsyncRead + Unpin> AsyncRead for DeadlineStream<S> {
    fn poll_read(
        mut self: Pin<&mut Self>,
        cx: &mut Context<'_>,
        buf: &mut ReadBuf<'_>,
    ) -> Poll<io::Result<()>> {
        let this = &mut *self;
        let before = buf.filled().len();
        if let Poll::Ready(result) = Pin::new(&mut this.stream).poll_read(cx, buf) {
            if buf.filled().len() > before {
                this.moved = Instant::now();
                if this.read_deadline().is_some() && this.head_since.is_none() {
                    this.head_since = Some(this.moved);
                }
            }
            return Poll::Ready(result);
        }
        match this.read_deadline() {
            Some(deadline) if expired(&mut this.read_timer, deadline, cx) => {
                Poll::Ready(Err(io::ErrorKind::TimedOut.into()))
            }
            _ => Poll::Pending,
        }
    }
}

impl<S: AsyncWrite + Unpin> DeadlineStream<S> {
    fn wrote<T>(
        &mut self,
        cx: &mut Context<'_>,
        result: Poll<io::Result<T>>,
    ) -> Poll<io::Result<T>> {
        if result.is_ready() {
            self.moved = Instant::now();
            self.blocked_since = None;
            return result;
        }
        let since = *self.blocked_since.get_or_insert_with(Instant::now);
        if expired(&mut self.write_timer, since + limit::IDLE, cx) {
            return Poll::Ready(Err(io::ErrorKind::TimedOut.into()));
        }
        Poll::Pending
    }
}

impl<S: AsyncRead + AsyncWrite + Unpin> AsyncWrite for DeadlineStream<S> {
    fn poll_write(
        mut self: Pin<&mut Self>,
        cx: &mut Context<'_>,
        buf: &[u8],
    ) -> Poll<io::Result<usize>> {
        let result = Pin::new(&mut self.stream).poll_write(cx, buf);
        self.wrote(cx, result)
    }

    fn poll_write_vectored(
        mut self: Pin<&mut Self>,
        cx: &mut Context<'_>,
        bufs: &[io::IoSlice<'_>],
    ) -> Poll<io::Result<usize>> {
        let result = Pin::new(&mut self.stream).poll_write_vectored(cx, bufs);
        self.wrote(cx, result)
    }

    fn is_write_vectored(&self) -> bool {
        self.stream.is_write_vectored()
    }

    fn poll_flush(mut self: Pin<&mut Self>, cx: &mut Context<'_>) -> Poll<io::Result<()>> {
        Pin::new(&mut self.stream).poll_flush(cx)
    }

    fn poll_shutdown(mut self: Pin<&mut Self>, cx: &mut Context<'_>) -> Poll<io::Result<()>> {
        let this = &mut *self;
        let closed = match this.closed {
            Some(closed) => closed,
            None => {
                ready!(Pin::new(&mut this.stream).poll_shutdown(cx))?;
                *this.closed.insert(Instant::now())
            }
        };
        // Closing a socket with unread bytes resets the connection, and the client may lose the
        // answer: after a 413 it may still be sending the body. Incoming bytes are discarded for a
        // short time.
        let mut waste = [0; 8 * 1024];
        loop {
            if expired(&mut this.read_timer, closed + limit::LINGER, cx) {
                return Poll::Ready(Ok(()));
            }
            let mut buf = ReadBuf::new(&mut waste);
            match Pin::new(&mut this.stream).poll_read(cx, &mut buf) {
                Poll::Ready(Ok(())) if !buf.filled().is_empty() => {}
                Poll::Ready(_) => return Poll::Ready(Ok(())),
                Poll::Pending => return Poll::Pending,
            }
        }
    }
}

/// Time that open connections have after shutdown is requested.
pub const GRACE: Duration = limit::DRAIN;

#[cfg(test)]
mod tests {
    use tokio::io::{AsyncReadExt, AsyncWriteExt, duplex};

    use super::*;

    fn watched(
        size: usize,
    ) -> (DeadlineStream<tokio::io::DuplexStream>, tokio::io::DuplexStream, Arc<Requests>) {
        let (near, far) = duplex(size);
        let requests = Arc::new(Requests::default());
        (DeadlineStream::new(near, requests.clone()), far, requests)
    }

    async fn seconds_until_cut(stream: &mut DeadlineStream<tokio::io::DuplexStream>) -> u64 {
        let start = Instant::now();
        let mut byte = [0; 1];
        while stream.read(&mut byte).await.is_ok() {}
        start.elapsed().as_secs()
    }

    #[tokio::test(start_paused = true)]
    async fn connection_is_cut_when_idle_for_30_s() {
        let (mut stream, _far, _) = watched(64);
        assert_eq!(seconds_until_cut(&mut stream).await, 30);
    }

    #[tokio::test(start_paused = true)]
    async fn connection_is_cut_5_s_after_the_first_byte_of_a_head() {
        let (mut stream, mut far, _) = watched(64);
        let trickle = tokio::spawn(async move {
            while far.write_all(b"G").await.is_ok() {
                tokio::time::sleep(Duration::from_secs(1)).await;
            }
        });
        assert_eq!(seconds_until_cut(&mut stream).await, 5);
        trickle.abort();
    }

    #[tokio::test(start_paused = true)]
    async fn connection_stays_while_a_request_runs() {
        let (mut stream, mut far, requests) = watched(64);
        far.write_all(b"G").await.unwrap();
        let mut byte = [0; 1];
        stream.read_exact(&mut byte).await.unwrap();
        let running = requests.begin();
        let wait = tokio::time::timeout(Duration::from_secs(300), stream.read(&mut byte)).await;
        assert!(wait.is_err(), "no deadline while a request runs");
        stream.write_all(b"answer").await.unwrap();
        drop(running);
        assert_eq!(seconds_until_cut(&mut stream).await, 30);
    }

    #[tokio::test(start_paused = true)]
    async fn connection_is_cut_when_the_client_never_reads() {
        let (mut stream, _far, requests) = watched(4);
        let _running = requests.begin();
        let start = Instant::now();
        assert!(stream.write_all(&[0; 64]).await.is_err());
        assert_eq!(start.elapsed().as_secs(), 30);
    }

    #[tokio::test(start_paused = true)]
    async fn unread_bytes_are_discarded_when_the_answer_was_sent() {
        let (mut stream, mut far, _) = watched(64);
        let sender = tokio::spawn(async move {
            far.write_all(&[0; 4096]).await.unwrap();
            far
        });
        let start = Instant::now();
        stream.shutdown().await.unwrap();
        assert_eq!(start.elapsed().as_secs(), 2, "the client has not closed its side");
        let far = sender.await.unwrap();
        drop(far);
        stream.shutdown().await.unwrap();
    }

    #[tokio::test(start_paused = true)]
    async fn shutdown_returns_at_once_when_the_client_has_closed() {
        let (mut stream, far, _) = watched(64);
        drop(far);
        let start = Instant::now();
        stream.shutdown().await.unwrap();
        assert_eq!(start.elapsed().as_millis(), 0);
    }
}
