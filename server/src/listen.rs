//! The accept loop: a bounded number of connections, each driven under watch until it ends or the server stops.

use std::convert::Infallible;
use std::sync::Arc;

use axum::Router;
use axum::body::Body;
use hyper::body::Incoming;
use hyper::server::conn::http1;
use hyper_util::rt::{TokioIo, TokioTimer};
use tokio::net::{TcpListener, TcpStream};
use tokio::sync::Semaphore;
use tokio_util::sync::CancellationToken;
use tokio_util::task::TaskTracker;
use tower::ServiceExt;

use crate::connection::{GRACE, Requests, Watched};
use crate::limit;

/// Accepts until `stopping`; then waits for the connections, a bounded time.
pub async fn serve(listener: TcpListener, router: Router, stopping: CancellationToken) {
    let connections = TaskTracker::new();
    let free = Arc::new(Semaphore::new(limit::CONNECTIONS));
    let abandoned = CancellationToken::new();
    loop {
        // Beyond the cap, clients wait in the system's own queue.
        let place = tokio::select! {
            () = stopping.cancelled() => break,
            place = free.clone().acquire_owned() => place.expect("the semaphore is never closed"),
        };
        let accepted = tokio::select! {
            () = stopping.cancelled() => break,
            accepted = listener.accept() => accepted,
        };
        let stream = match accepted {
            Ok((stream, _)) => stream,
            Err(error) => {
                // Out of file descriptors, or a client that was gone already: neither ends the server.
                tracing::warn!(%error, "a connection could not be accepted");
                tokio::time::sleep(std::time::Duration::from_millis(20)).await;
                continue;
            }
        };
        let (router, stopping, abandoned) = (router.clone(), stopping.clone(), abandoned.clone());
        connections.spawn(async move {
            tokio::select! {
                () = drive(stream, router, stopping) => {}
                () = abandoned.cancelled() => {}
            }
            drop(place);
        });
    }
    drop(listener);
    connections.close();
    if tokio::time::timeout(GRACE, connections.wait()).await.is_err() {
        tracing::warn!(connections = connections.len(), "connections are cut off");
        abandoned.cancel();
        connections.wait().await;
    }
}

async fn drive(stream: TcpStream, router: Router, stopping: CancellationToken) {
    if let Err(error) = stream.set_nodelay(true) {
        tracing::debug!(%error, "the connection was gone already");
        return;
    }
    let requests = Arc::new(Requests::default());
    let io = TokioIo::new(Watched::new(stream, requests.clone()));
    let service = hyper::service::service_fn(move |request: hyper::Request<Incoming>| {
        let (router, running) = (router.clone(), requests.begin());
        async move {
            let response = router.oneshot(request.map(Body::new)).await;
            drop(running);
            response.map_err(|never: Infallible| match never {})
        }
    });
    let connection = http1::Builder::new()
        .timer(TokioTimer::new())
        .header_read_timeout(limit::IDLE)
        .serve_connection(io, service);
    tokio::pin!(connection);
    let result = tokio::select! {
        result = connection.as_mut() => result,
        () = stopping.cancelled() => {
            connection.as_mut().graceful_shutdown();
            connection.await
        }
    };
    if let Err(error) = result {
        tracing::debug!(%error, "a connection ended early");
    }
}
