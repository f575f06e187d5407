//! Accept loop: a bounded number of connections, each with deadlines, until the server stops. At
//! the limit, a new connection closes an idle one.

use std::convert::Infallible;
use std::sync::Arc;

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
use crate::open_connections::OpenConnections;

/// Accepts connections until `stopping`, then waits a bounded time for the open ones.
pub async fn serve(listener: TcpListener, router: Router, stopping: CancellationToken) {
    let (connections, graceful) = (TaskTracker::new(), GracefulShutdown::new());
    let open = OpenConnections::new(limit::CONNECTIONS);
    let abandoned = CancellationToken::new();
    loop {
        let accepted = tokio::select! {
            () = stopping.cancelled() => break,
            accepted = listener.accept() => accepted,
        };
        let (stream, peer) = match accepted {
            Ok(accepted) => accepted,
            Err(error) => {
                // Out of file descriptors, or the client has disconnected: neither ends the server.
                tracing::warn!(%error, "cannot accept a connection");
                tokio::time::sleep(std::time::Duration::from_millis(20)).await;
                continue;
            }
        };
        // While every connection has a request, clients wait here and in the system's queue.
        let requests = Arc::new(Requests::default());
        let place = tokio::select! {
            () = stopping.cancelled() => break,
            place = open.place(requests.clone()) => place,
        };
        let peer = Peer(peer.ip());
        let connection = drive((stream, peer), requests, router.clone(), graceful.watcher());
        let abandoned = abandoned.clone();
        connections.spawn(async move {
            let cut = place.cut();
            abandoned.run_until_cancelled(cut.run_until_cancelled(connection)).await;
            drop(place);
        });
    }
    drop(listener);
    connections.close();
    if tokio::time::timeout(GRACE, graceful.shutdown()).await.is_err() {
        tracing::warn!(connections = connections.len(), "open connections were cut off");
        abandoned.cancel();
    }
    connections.wait().await;
}

async fn drive(
    (stream, peer): (TcpStream, Peer),
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
