//! Event streams of lineages, searches, exports and deferred answers.

use std::convert::Infallible;
use std::time::Duration;

use async_stream::stream;
use axum::extract::State;
use axum::response::sse::{Event as SseEvent, KeepAlive, Sse};
use axum::response::{IntoResponse, Response};
use brood_protocol::{JobId, LineageId};
use brood_storage::StorageError;
use http::{HeaderMap, HeaderValue, header};
use tokio::sync::broadcast::error::RecvError;

use crate::access::Need;
use crate::event::{Event, RESYNC, Subscription, Topic};
use crate::extract::Path;
use crate::layer;
use crate::problem::ApiError;
use crate::state::{App, AppState};

const KEEP_ALIVE: Duration = Duration::from_secs(15);
/// Interval at which an open stream checks its token.
const ACCESS_TICK: Duration = Duration::from_secs(2);

/// Streams a lineage's changes as server-sent events.
///
/// Events: `generation`, `thumbnail`, `lineage`, `individual`, `job`, `resync`.
#[utoipa::path(get, path = "/v1/lineages/{id}/events", tag = "lineages",
    params(("id" = LineageId, Path), ("Last-Event-ID" = Option<String>, Header, description = "id of the last event received")),
    responses((status = 200, description = "stream of events", content_type = "text/event-stream"),
        (status = 503, description = "too many open streams")))]
pub async fn stream_events(
    State(app): State<App>,
    Path(id): Path<LineageId>,
    headers: HeaderMap,
) -> Result<Response, ApiError> {
    app.store.lineage(id).await?;
    stream_of(app, id.into(), &headers)
}

/// Streams the changes of a search, an export or a deferred answer as server-sent events.
///
/// Events: `state`, `progress`, `best` (of searches), `resync`.
#[utoipa::path(get, path = "/v1/jobs/{id}/events", tag = "jobs",
    params(("id" = JobId, Path), ("Last-Event-ID" = Option<String>, Header, description = "id of the last event received")),
    responses((status = 200, description = "stream of events", content_type = "text/event-stream"),
        (status = 503, description = "too many open streams")))]
pub async fn stream_job_events(
    State(app): State<App>,
    Path(id): Path<JobId>,
    headers: HeaderMap,
) -> Result<Response, ApiError> {
    if app.deferred.job(id).is_none()
        && matches!(app.store.islands(id).await, Err(StorageError::NotFound))
    {
        app.store.export(id).await?;
    }
    stream_of(app, id.into(), &headers)
}

fn stream_of(app: App, topic: Topic, headers: &HeaderMap) -> Result<Response, ApiError> {
    let permit = app.events.stream_permit();
    let permit = permit.ok_or_else(|| ApiError::busy("too many event streams are open"))?;
    let last_id = headers.get("last-event-id").map(|value| value.to_str().unwrap_or_default());
    let Subscription { resync, missed, mut receiver } = app.events.subscribe(topic, last_id);
    let token = layer::token(headers).map(str::to_owned);
    let events = stream! {
        let _permit = permit;
        // Sends bytes at once, so that proxies and clients see that the stream is open.
        yield Ok::<_, Infallible>(SseEvent::default().comment("open"));
        if resync {
            yield Ok(resynchronise());
        }
        for event in missed {
            yield Ok(present(&app, &event));
        }
        let mut look = tokio::time::interval(ACCESS_TICK);
        loop {
            let event = tokio::select! {
                event = receiver.recv() => event,
                () = app.stopping.cancelled() => break,
                // The token may be revoked while the stream is open.
                _ = look.tick() => {
                    let allowed = app.access.check(&app.store, Need::Read, token.as_deref()).await;
                    if allowed.is_err() { break } else { continue }
                }
            };
            match event {
                Ok(event) => yield Ok(present(&app, &event)),
                Err(RecvError::Lagged(_)) => yield Ok(resynchronise()),
                Err(RecvError::Closed) => break,
            }
        }
    };
    let keep_alive = KeepAlive::new().interval(KEEP_ALIVE);
    let mut response = Sse::new(events).keep_alive(keep_alive).into_response();
    response.headers_mut().insert(header::CACHE_CONTROL, HeaderValue::from_static("no-store"));
    Ok(response)
}

fn present(app: &AppState, event: &Event) -> SseEvent {
    SseEvent::default().id(app.events.id(event)).event(&event.name).data(&event.data)
}

fn resynchronise() -> SseEvent {
    SseEvent::default().event(RESYNC).data("{}")
}
