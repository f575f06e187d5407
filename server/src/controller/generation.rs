//! Generations: breeding, adopting and reading.

use axum::Json;
use axum::extract::State;
use axum::response::Response;
use brood_protocol::{
    Adopt, Breed, Generation, GenerationId, GenerationOutline, JobId, LineageId, Page,
};
use http::{HeaderName, HeaderValue, header};
use serde_json::Value;

use super::created;
use crate::breeding::Origin;
use crate::dispatch::admit_birth;
use crate::extract::{Json as JsonBody, PageQuery, Path, Query, page};
use crate::idempotency::{Attempt, BodyHash, IdempotencyKey};
use crate::limit;
use crate::presenter::Presenter;
use crate::problem::ApiError;
use crate::server_timing::ServerTiming;
use crate::state::App;

const COLLECTION: &str = "/v1/generations";
const SERVER_TIMING: HeaderName = HeaderName::from_static("server-timing");

/// Breeds a generation.
#[utoipa::path(post, path = "/v1/lineages/{id}/generations", tag = "generations",
    params(("id" = LineageId, Path), IdempotencyKey), request_body = Breed,
    responses((status = 201, description = "generation with its individuals", body = Generation, headers(
        ("Link" = String, description = "job that renders the pictures, with rel=status; absent if no picture must be rendered"),
        ("Server-Timing" = String, description = "duration of each stage")))))]
pub async fn breed(
    State(app): State<App>,
    Path(id): Path<LineageId>,
    key: IdempotencyKey,
    body: JsonBody<Breed>,
) -> Result<Response, ApiError> {
    bred(&app, id, key, &body.bytes, Origin::Breed(Box::new(body.value))).await
}

/// Adds genomes and presets to a lineage, as a generation of individuals without parents, or as
/// children of `parent`.
#[utoipa::path(post, path = "/v1/lineages/{id}/adoptions", tag = "generations",
    params(("id" = LineageId, Path), IdempotencyKey), request_body = Adopt,
    responses((status = 201, description = "generation with its individuals", body = Generation, headers(
        ("Link" = String, description = "job that renders the pictures, with rel=status; absent if no picture must be rendered"),
        ("Server-Timing" = String, description = "duration of each stage")))))]
pub async fn adopt(
    State(app): State<App>,
    Path(id): Path<LineageId>,
    key: IdempotencyKey,
    body: JsonBody<Adopt>,
) -> Result<Response, ApiError> {
    bred(&app, id, key, &body.bytes, Origin::Adopt(body.value)).await
}

async fn bred(
    app: &App,
    id: LineageId,
    key: IdempotencyKey,
    body: &[u8],
    origin: Origin,
) -> Result<Response, ApiError> {
    let make = async |attempt: Attempt| {
        admit_birth(&app.pictures.queue, &app.workers)?;
        let mut timing = ServerTiming::begin();
        let lineage = app.store.lineage(id).await?;
        let brood = app.breeding.make(&lineage, origin, &mut timing).await?;
        let (generation, job) =
            brood.deliver(&app.pictures, &lineage, &attempt, &mut timing).await?;
        Ok(answer(&generation, job, timing))
    };
    let replay = async |answer| Ok(created(COLLECTION, &replay(app, answer).await?));
    app.ledger.once(&app.store, (key, BodyHash::of(body)), make, replay).await
}

/// Returns 201 with the stage durations and a link to the render job.
fn answer(generation: &Generation, job: Option<JobId>, mut timing: ServerTiming) -> Response {
    let mut response = created(COLLECTION, generation);
    timing.end("answer");
    response.headers_mut().insert(SERVER_TIMING, timing.header());
    if let Some(job) = job {
        let link = HeaderValue::from_str(&format!("</v1/jobs/{job}>; rel=\"status\""));
        response.headers_mut().insert(header::LINK, link.expect("an id is plain text"));
    }
    response
}

/// Completes a stored answer. The index is only known after the commit, so it is read from the
/// generation itself.
async fn replay(app: &App, mut answer: Value) -> Result<Value, ApiError> {
    let id = answer.get("id").and_then(Value::as_str).and_then(|id| id.parse().ok());
    let id: GenerationId = id.ok_or_else(|| ApiError::internal("a stored answer has no id"))?;
    answer["index"] = app.store.generation(id).await?.index.into();
    Ok(answer)
}

/// Lists a lineage's generations, oldest first. A page with 2048 individuals ends before `limit`.
#[utoipa::path(get, path = "/v1/lineages/{id}/generations", operation_id = "list_generations", tag = "generations",
    params(("id" = LineageId, Path), PageQuery),
    responses((status = 200, description = "page of generations", body = Page<Generation>)))]
pub async fn list(
    State(app): State<App>,
    Path(id): Path<LineageId>,
    Query(query): Query<PageQuery>,
) -> Result<Json<Page<Generation>>, ApiError> {
    let cursor = query.cursor::<u64>()?;
    let most = limit::PAGE_INDIVIDUALS;
    let limit = app.store.generations_within(id, cursor, query.limit()?, most).await?;
    let stored = app.store.list_generations(id, cursor, limit + 1).await?;
    let Page { items, next } = page(stored, limit, |last| last.index.to_string(), |one| one);
    let mut presenter = Presenter::new(&app);
    let mut generations = Vec::with_capacity(items.len());
    for stored in items {
        generations.push(presenter.generation(stored).await?);
    }
    presenter.finish().await?;
    Ok(Json(Page { items: generations, next }))
}

/// Lists the outlines of a lineage's generations, oldest first: its history, without most
/// individuals.
#[utoipa::path(get, path = "/v1/lineages/{id}/outlines", operation_id = "list_outlines", tag = "generations",
    params(("id" = LineageId, Path), PageQuery),
    responses((status = 200, description = "page of outlines", body = Page<GenerationOutline>)))]
pub async fn outlines(
    State(app): State<App>,
    Path(id): Path<LineageId>,
    Query(query): Query<PageQuery>,
) -> Result<Json<Page<GenerationOutline>>, ApiError> {
    let limit = query.limit()?;
    let stored = app.store.list_outlines(id, query.cursor::<u64>()?, limit + 1).await?;
    let Page { items, next } = page(stored, limit, |last| last.index.to_string(), |one| one);
    let mut presenter = Presenter::new(&app);
    let mut outlines = Vec::with_capacity(items.len());
    for stored in items {
        outlines.push(presenter.outline(id, stored).await?);
    }
    presenter.finish().await?;
    Ok(Json(Page { items: outlines, next }))
}

/// Returns a generation.
#[utoipa::path(get, path = "/v1/generations/{id}", operation_id = "get_generation", tag = "generations",
    params(("id" = GenerationId, Path)),
    responses((status = 200, description = "generation with its individuals", body = Generation)))]
pub async fn get(
    State(app): State<App>,
    Path(id): Path<GenerationId>,
) -> Result<Json<Generation>, ApiError> {
    let stored = app.store.generation(id).await?;
    let mut presenter = Presenter::new(&app);
    let generation = presenter.generation(stored).await?;
    presenter.finish().await?;
    Ok(Json(generation))
}
