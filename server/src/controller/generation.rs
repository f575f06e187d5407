//! Generations: bred and read.

use axum::Json;
use axum::extract::State;
use axum::response::Response;
use brood_protocol::{Breed, Generation, GenerationId, JobId, LineageId, Page};
use http::{HeaderName, HeaderValue, header};
use serde_json::Value;

use super::created;
use crate::extract::{Json as JsonBody, NoQuery, PageQuery, Path, Query, page};
use crate::idempotency::{Begun, IdempotencyKey};
use crate::presenter::Presenter;
use crate::problem::ApiError;
use crate::stage::Stages;
use crate::state::App;

pub(super) const COLLECTION: &str = "/v1/generations";
const SERVER_TIMING: HeaderName = HeaderName::from_static("server-timing");

/// Breeds.
#[utoipa::path(post, path = "/v1/lineages/{id}/generations", tag = "generations",
    params(("id" = LineageId, Path)), request_body = Breed,
    responses((status = 201, body = Generation, headers(
        ("Link" = String, description = "with rel=status: the job that renders the pictures, where there are any to be rendered"),
        ("Server-Timing" = String, description = "where the time went")))))]
pub async fn breed(
    State(app): State<App>,
    NoQuery: NoQuery,
    Path(id): Path<LineageId>,
    key: IdempotencyKey,
    body: JsonBody<Breed>,
) -> Result<Response, ApiError> {
    let attempt = match app.ledger.begin(&app.store, key, &body.bytes).await? {
        Begun::Replay(answer) => return Ok(created(COLLECTION, &replay(&app, answer).await?)),
        Begun::Fresh(attempt) => attempt,
    };
    let mut stages = Stages::begin();
    let lineage = app.store.lineage(id).await?;
    let (generation, job) = app.breed(&lineage, body.value, &attempt, &mut stages).await?;
    Ok(answer(&generation, job, stages))
}

/// 201 with where the time went, and where the job is that renders the pictures.
pub(super) fn answer(generation: &Generation, job: Option<JobId>, mut stages: Stages) -> Response {
    let mut response = created(COLLECTION, generation);
    stages.end("answer");
    response.headers_mut().insert(SERVER_TIMING, stages.header());
    if let Some(job) = job {
        let link = HeaderValue::from_str(&format!("</v1/jobs/{job}>; rel=\"status\""));
        response.headers_mut().insert(header::LINK, link.expect("an id is plain text"));
    }
    response
}

/// The index is known only once the transaction is done: what is remembered gets it from the generation itself.
pub(super) async fn replay(app: &App, mut answer: Value) -> Result<Value, ApiError> {
    let id = answer.get("id").and_then(Value::as_str).and_then(|id| id.parse().ok());
    let id: GenerationId = id.ok_or_else(|| ApiError::internal("a remembered answer has no id"))?;
    answer["index"] = app.store.generation(id).await?.index.into();
    Ok(answer)
}

/// The generations of a lineage, oldest first.
#[utoipa::path(get, path = "/v1/lineages/{id}/generations", tag = "generations",
    params(("id" = LineageId, Path), PageQuery),
    responses((status = 200, body = Page<Generation>)))]
pub async fn list(
    State(app): State<App>,
    Path(id): Path<LineageId>,
    Query(query): Query<PageQuery>,
) -> Result<Json<Page<Generation>>, ApiError> {
    let limit = query.limit()?;
    let stored = app.store.list_generations(id, query.cursor::<u64>()?, limit + 1).await?;
    let Page { items, next } = page(stored, limit, |last| last.index.to_string(), |one| one);
    let mut presenter = Presenter::new(&app);
    let mut generations = Vec::with_capacity(items.len());
    for stored in items {
        generations.push(presenter.generation(stored).await?);
    }
    presenter.finish().await?;
    Ok(Json(Page { items: generations, next }))
}

/// One generation.
#[utoipa::path(get, path = "/v1/generations/{id}", tag = "generations",
    params(("id" = GenerationId, Path)), responses((status = 200, body = Generation)))]
pub async fn get(
    State(app): State<App>,
    NoQuery: NoQuery,
    Path(id): Path<GenerationId>,
) -> Result<Json<Generation>, ApiError> {
    let stored = app.store.generation(id).await?;
    let mut presenter = Presenter::new(&app);
    let generation = presenter.generation(stored).await?;
    presenter.finish().await?;
    Ok(Json(generation))
}
