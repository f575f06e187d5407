//! Searches: starting, listing, pausing, resuming, cancelling, results and logs. A single search is
//! read through `job`.

mod request;

use async_stream::stream;
use axum::Json;
use axum::body::Body;
use axum::extract::State;
use axum::response::{IntoResponse, Response};
use brood_protocol::{
    AnyJob, CreateSearch, FoundMaterial, Front, JobId, LineageId, Page, SearchAnswer, SearchLine,
    SearchState,
};
use brood_storage::{Extreme, SearchChange, StorageError, StoredSearch};
use http::{HeaderMap, HeaderName, StatusCode, header};
use serde::{Deserialize, Serialize};

use super::accepted;
use super::file::{FileHead, IMMUTABLE};
use crate::access::Need;
use crate::client::Client;
use crate::clock::now_ms;
use crate::dispatch::{export_json, search_json, whole_search};
use crate::extract::{Json as JsonBody, PageQuery, Path, Query, page};
use crate::idempotency::{Attempt, BodyHash, IdempotencyKey};
use crate::layer::token;
use crate::limit;
use crate::presenter::Presenter;
use crate::problem::ApiError;
use crate::state::App;

/// Log lines per read.
const LOG_LINES: u32 = 1000;

/// Starts a search.
#[utoipa::path(post, path = "/v1/jobs", operation_id = "create_search", tag = "jobs",
    request_body = CreateSearch,
    params(IdempotencyKey),
    responses((status = 202, description = "queued search", body = SearchAnswer,
        headers(("Location" = String, description = "URL of the job")))))]
pub async fn create(
    State(app): State<App>,
    key: IdempotencyKey,
    body: JsonBody<CreateSearch>,
) -> Result<Response, ApiError> {
    let hash = BodyHash::of(&body.bytes);
    let make = async |attempt: Attempt| {
        let mut new = request::read(&app, body.value).await?;
        let answer = search_json(request::as_stored(&new));
        new.idempotency = attempt.record(StatusCode::ACCEPTED, &answer);
        let (id, target) = (new.id, new.target);
        let created = app.store.create_search(new, limit::QUEUED_SEARCHES).await;
        created.map_err(|error| match error {
            StorageError::QueueFull => ApiError::busy("too many searches are queued"),
            // The target existed when the request was checked.
            StorageError::NotFound => {
                ApiError::not_found(format!("there is no target {target}: it was deleted"))
            }
            other => other.into(),
        })?;
        app.searches.publish_state(&app.store.search(id).await?).await;
        app.searches.wake();
        Ok(accepted(&answer))
    };
    app.ledger.once(&app.store, (key, hash), make, async |answer| Ok(accepted(&answer))).await
}

/// Filter of the searches.
#[derive(Debug, Clone, Deserialize, utoipa::IntoParams)]
#[into_params(parameter_in = Query)]
#[serde(deny_unknown_fields)]
pub struct SearchesQuery {
    /// Only searches whose results go to this lineage.
    lineage: Option<LineageId>,
    /// `next` of the previous page.
    cursor: Option<String>,
    /// Items per page, 1 to 200; default 50.
    #[param(minimum = 1, maximum = 200)]
    limit: Option<u32>,
}

/// Lists the searches, newest first.
#[utoipa::path(get, path = "/v1/jobs", operation_id = "list_searches", tag = "jobs", params(SearchesQuery),
    responses((status = 200, description = "page of searches", body = Page<SearchAnswer>)))]
pub async fn list(
    State(app): State<App>,
    Query(query): Query<SearchesQuery>,
) -> Result<Json<Page<SearchAnswer>>, ApiError> {
    let paging = PageQuery { cursor: query.cursor, limit: query.limit };
    let (limit, before) = (paging.limit()?, paging.cursor::<JobId>()?);
    let stored = app.store.list_searches(before, query.lineage, limit + 1).await?;
    let Page { items, next } = page(stored, limit, |last| last.id.to_string(), |one| one);
    let mut answers = Vec::with_capacity(items.len());
    for search in items {
        answers.push(present(&app, app.searches.islands(search).await?).await?);
    }
    Ok(Json(Page { items: answers, next }))
}

/// Pauses a search.
#[utoipa::path(post, path = "/v1/jobs/{id}/pause", operation_id = "pause_search", tag = "jobs",
    params(("id" = JobId, Path), IdempotencyKey),
    responses((status = 200, description = "search after the change", body = SearchAnswer)))]
pub async fn pause(
    State(app): State<App>,
    Path(id): Path<JobId>,
    key: IdempotencyKey,
) -> Result<Response, ApiError> {
    change(&app, id, key, SearchChange::Pause).await
}

/// Resumes a paused search.
#[utoipa::path(post, path = "/v1/jobs/{id}/resume", operation_id = "resume_search", tag = "jobs",
    params(("id" = JobId, Path), IdempotencyKey),
    responses((status = 200, description = "search after the change", body = SearchAnswer)))]
pub async fn resume(
    State(app): State<App>,
    Path(id): Path<JobId>,
    key: IdempotencyKey,
) -> Result<Response, ApiError> {
    change(&app, id, key, SearchChange::Resume).await
}

/// Cancels a search, an export or a deferred answer.
///
/// A search keeps its best result. The server deletes the files of an export.
#[utoipa::path(post, path = "/v1/jobs/{id}/cancel", operation_id = "cancel_job", tag = "jobs",
    params(("id" = JobId, Path), IdempotencyKey),
    responses((status = 200, description = "job after the change", body = AnyJob)))]
pub async fn cancel(
    State(app): State<App>,
    Path(id): Path<JobId>,
    headers: HeaderMap,
    key: IdempotencyKey,
) -> Result<Response, ApiError> {
    if app.deferred.client(id) != Some(Client::current()) {
        app.access.check(&app.store, Need::Breed, token(&headers)).await?;
        if app.stopping.is_cancelled() {
            return Err(ApiError::stopping("retry after the restart"));
        }
    }
    if let Some(cancelled) = app.deferred.cancel(id) {
        return Ok(Json(cancelled?).into_response());
    }
    if app.store.export(id).await.is_ok() {
        let make = async |attempt: Attempt| {
            let record = attempt.record(StatusCode::OK, &ChangedJob { id });
            Ok(Json(export_json(app.exports.cancel(id, record).await?)).into_response())
        };
        let replay = async |_| {
            let export = app.store.export(id).await?;
            Ok(Json(export_json(export)).into_response())
        };
        return app.ledger.once(&app.store, (key, BodyHash::of(b"")), make, replay).await;
    }
    change(&app, id, key, SearchChange::Cancel).await
}

async fn change(
    app: &App,
    id: JobId,
    key: IdempotencyKey,
    change: SearchChange,
) -> Result<Response, ApiError> {
    let make = async |attempt: Attempt| {
        let record = attempt.record(StatusCode::OK, &ChangedJob { id });
        let search = app.store.change_search(id, change, record, now_ms()).await?;
        let search = search.map_err(|state| wrong_state(change, state))?;
        app.searches.wake();
        app.searches.publish_state(&search).await;
        Ok(Json(present(app, app.searches.islands(search).await?).await?).into_response())
    };
    let replay = async |_| {
        let islands = app.store.islands(id).await?;
        Ok(Json(present(app, islands).await?).into_response())
    };
    app.ledger.once(&app.store, (key, BodyHash::of(b"")), make, replay).await
}

/// Record of a change under its idempotency key. A repeated request is answered with the job as it
/// is then.
#[derive(Serialize)]
struct ChangedJob {
    id: JobId,
}

fn wrong_state(change: SearchChange, state: SearchState) -> ApiError {
    let word = state.name();
    ApiError::conflict(match change {
        SearchChange::Pause => {
            format!("only a queued or running job can be paused, but this one is {word}")
        }
        SearchChange::Resume => format!("only a paused job can be resumed, but this one is {word}"),
        SearchChange::Cancel => format!("the job has already ended: it is {word}"),
    })
}

/// Returns the results of a search, best first.
///
/// While the search runs, or after it was cancelled, only the best result so far.
#[utoipa::path(get, path = "/v1/jobs/{id}/front", operation_id = "get_search_front", tag = "jobs",
    params(("id" = JobId, Path)),
    responses((status = 200, description = "results, best first", body = Front)))]
pub async fn front(State(app): State<App>, Path(id): Path<JobId>) -> Result<Json<Front>, ApiError> {
    let search = whole_search(app.store.islands(id).await?);
    let mut items = app.store.search_front(id).await?;
    if items.is_empty() {
        items.extend(search.best);
    }
    let mut presenter = Presenter::new(&app);
    for item in &mut items {
        show(&app, &mut presenter, item).await?;
    }
    presenter.finish().await?;
    let spread = app.store.search_spread(id).await?;
    Ok(Json(Front { items, spread }))
}

/// Returns the darkest that the material of a search could be under other lights.
///
/// 5 % quantile of each pixel over the materials that match the pictures of the target about as
/// well as the best: up to three pictures side by side, in the scene of the most useful next
/// picture first, at the automatic exposure of the brightest. The scene of the first picture alone
/// if its light cannot be moved.
#[utoipa::path(get, path = "/v1/jobs/{id}/darkest.png", operation_id = "get_search_darkest", tag = "jobs",
    params(("id" = JobId, Path)),
    responses((status = 200, description = "pictures of up to 160 x 160 pixels, side by side", content_type = "image/png"),
        (status = 304)))]
pub async fn darkest(
    State(app): State<App>,
    Path(id): Path<JobId>,
    headers: HeaderMap,
) -> Result<Response, ApiError> {
    extreme(&app, id, Extreme::Darkest, &headers).await
}

/// Returns the brightest that the material of a search could be under other lights.
///
/// 95 % quantile of each pixel, in the scenes and at the exposures of `darkest.png`.
#[utoipa::path(get, path = "/v1/jobs/{id}/brightest.png", operation_id = "get_search_brightest", tag = "jobs",
    params(("id" = JobId, Path)),
    responses((status = 200, description = "pictures of up to 160 x 160 pixels, side by side", content_type = "image/png"),
        (status = 304)))]
pub async fn brightest(
    State(app): State<App>,
    Path(id): Path<JobId>,
    headers: HeaderMap,
) -> Result<Response, ApiError> {
    extreme(&app, id, Extreme::Brightest, &headers).await
}

async fn extreme(
    app: &App,
    id: JobId,
    extreme: Extreme,
    headers: &HeaderMap,
) -> Result<Response, ApiError> {
    let picture = app.store.search_extreme(id, extreme).await?;
    let picture = picture.ok_or_else(|| {
        ApiError::not_found("the search has no such picture: only an ended search that fitted models to pictures has one")
    })?;
    let etag = format!("\"{id}-{extreme:?}\"");
    let head = FileHead { etag, content_type: "image/png", cache: IMMUTABLE };
    Ok(head.answer(headers, picture))
}

/// Start of a log.
#[derive(Debug, Clone, Deserialize, utoipa::IntoParams)]
#[into_params(parameter_in = Query)]
#[serde(deny_unknown_fields)]
pub struct LogQuery {
    /// Skip generations up to and including this one.
    #[serde(default)]
    #[param(value_type = u64, maximum = 4_294_967_295_u32)]
    after: u32,
    /// Number of the island, from 0; default 0.
    #[serde(default)]
    #[param(value_type = u64, maximum = 63)]
    island: u32,
}

/// Streams the log of a search, or of one of its islands: one line of JSON per generation.
#[utoipa::path(get, path = "/v1/jobs/{id}/log", operation_id = "get_search_log", tag = "jobs",
    params(("id" = JobId, Path), LogQuery),
    responses((status = 200, description = "lines of JSON, each a `SearchLine`", body = String,
        content_type = "application/x-ndjson")))]
pub async fn log(
    State(app): State<App>,
    Path(id): Path<JobId>,
    Query(query): Query<LogQuery>,
) -> Result<Response, ApiError> {
    let islands = app.store.islands(id).await?;
    let island = islands.iter().find(|own| own.island == query.island).ok_or_else(|| {
        let last = islands.len() - 1;
        let got = query.island;
        ApiError::not_found(format!("islands of this search are 0 to {last}, got {got}"))
    })?;
    let id = island.id;
    let lines = stream! {
        let mut after = query.after;
        loop {
            match app.store.search_log(id, after, LOG_LINES).await {
                Ok(lines) => {
                    let Some(last) = lines.last() else { return };
                    after = last.generation;
                    yield Ok(text(&lines));
                }
                Err(error) => {
                    // The headers are already sent: aborting the body signals the error.
                    yield Err(std::io::Error::other(error));
                    return;
                }
            }
        }
    };
    let kind = (header::CONTENT_TYPE, "application/x-ndjson");
    let fresh: (HeaderName, &str) = (header::CACHE_CONTROL, "no-store");
    Ok(([kind, fresh], Body::from_stream(lines)).into_response())
}

fn text(lines: &[SearchLine]) -> String {
    let line = |line| serde_json::to_string(line).expect("lines are plain data") + "\n";
    lines.iter().map(line).collect()
}

/// Returns the answer of a search, given by its islands, with the thumbnail of its best result.
///
/// # Errors
/// [`ApiError`] if the store fails.
pub(super) async fn present(
    app: &App,
    islands: Vec<StoredSearch>,
) -> Result<SearchAnswer, ApiError> {
    let mut answer = search_json(islands);
    if let Some(best) = &mut answer.best {
        let mut presenter = Presenter::new(app);
        show(app, &mut presenter, best).await?;
        presenter.finish().await?;
    }
    Ok(answer)
}

async fn show(
    app: &App,
    presenter: &mut Presenter<'_>,
    found: &mut FoundMaterial,
) -> Result<(), ApiError> {
    let individual = app.store.individual(found.individual).await?;
    found.thumbnail = Some(presenter.individual(individual).await?.thumbnail);
    Ok(())
}
