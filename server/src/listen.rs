//! Accept loop: a bounded number of connections, each with deadlines, until the server stops. At
//! the limit, a new connection closes an idle one.

use std::convert::Infallible;
use std::sync::Arc;
use std::time::Duration;

use axum::Router;
use axum::body::Body;
use hyper::body::Incoming;
use hyper::server::conn::http1;
use hyper_util::rt::{TokioIo, TokioTimer};
use hyper_util::server::graceful::{GracefulShutdown, Watcher};
use tokio::net::{TcpListener, TcpStream};
use tokio_util::sync::CancellationToken;
use tokio_util::task::TaskTracker;
use tower::ServiceExt;

use crate::client::Peer;
use crate::connection::{DeadlineStream, GRACE, Requests};
use crate::limit;
use crate::open_connections::OpenConnection;
use crate::state::App;

/// Extension of requests on connections that were opened while the server stops.
#[derive(Debug, Clone, Copy)]
pub struct Stopping;

/// Longest time of a connection that was opened while the server stops.
const REFUSAL: Duration = Duration::from_secs(2);

/// Accepts connections until the server stops, then waits a bounded time for the open ones and
/// answers new ones with 503.
pub async fn serve(listener: TcpListener, router: Router, app: &App) {
    let (connections, graceful) = (TaskTracker::new(), GracefulShutdown::new());
    let (open, stopping) = (&app.connections, &app.stopping);
    let abandoned = CancellationToken::new();
    loop {
        let accepted = tokio::select! {
            () = stopping.cancelled() => break,
            accepted = accept(&listener) => accepted,
        };
        let Some((stream, peer)) = accepted else { continue };
        // While every connection has a request, clients wait here and in the system's queue.
        let requests = Arc::new(Requests::default());
        let place = tokio::select! {
            () = stopping.cancelled() => break,
            place = open.place(requests.clone()) => place,
        };
        let from = (peer, place.connection());
        let connection = drive(stream, from, requests, router.clone(), graceful.watcher());
        let abandoned = abandoned.clone();
        connections.spawn(async move {
            let cut = place.cut();
            abandoned.run_until_cancelled(cut.run_until_cancelled(connection)).await;
            drop(place);
        });
    }
    connections.close();
    let drained = tokio::time::timeout(GRACE, graceful.shutdown());
    let refused = async {
        let refusals = TaskTracker::new();
        loop {
            if let Some((stream, _)) = accept(&listener).await {
                refusals.spawn(tokio::time::timeout(REFUSAL, refuse(stream, router.clone())));
            }
        }
    };
    tokio::select! {
        drained = drained => if drained.is_err() {
            tracing::warn!(connections = connections.len(), "open connections were cut off");
            abandoned.cancel();
        },
        () = refused => {}
    }
    connections.wait().await;
}

/// Accepts a connection. `None` if it was lost.
async fn accept(listener: &TcpListener) -> Option<(TcpStream, Peer)> {
    match listener.accept().await {
        Ok((stream, peer)) => Some((stream, Peer(peer.ip()))),
        Err(error) => {
            // Out of file descriptors, or the client has disconnected: neither ends the server.
            tracing::warn!(%error, "cannot accept a connection");
            tokio::time::sleep(Duration::from_millis(20)).await;
            None
        }
    }
}

/// Answers one request of a connection that was opened while the server stops.
async fn refuse(stream: TcpStream, router: Router) {
    let service = hyper::service::service_fn(move |mut request: hyper::Request<Incoming>| {
        request.extensions_mut().insert(Stopping);
        let router = router.clone();
        async move { router.oneshot(request.map(Body::new)).await }
    });
    let mut builder = http1::Builder::new();
    let connection = builder.keep_alive(false).serve_connection(TokioIo::new(stream), service);
    if let Err(error) = connection.await {
        tracing::debug!(%error, "a connection ended early");
    }
}

async fn drive(
    stream: TcpStream,
    (peer, open): (Peer, OpenConnection),
    requests: Arc<Requests>,
    router: Router,
    watcher: Watcher,
) {
    if let Err(error) = stream.set_nodelay(true) {
        tracing::debug!(%error, "the connection was already closed");
        return;
    }
    let io = TokioIo::new(DeadlineStream::new(stream, requests.clone()));
    let service = hyper::service::service_fn(move |mut request: hyper::Request<Incoming>| {
        request.extensions_mut().insert(peer);
        request.extensions_mut().insert(open.clone());
        let (router, running) = (router.clone(), requests.begin());
        async move {
            let response = router.oneshot(request.map(Body::new)).await;
            let response = response.map(|response| running.until_sent(response));
            response.map_err(|never: Infallible| match never {})
        }
    });
    let connection = http1::Builder::new()
        .timer(TokioTimer::new())
        .header_read_timeout(limit::IDLE)
        .serve_connection(io, service);
    if let Err(error) = watcher.watch(connection).await {
        tracing::debug!(%error, "a connection ended early");
    }
}
