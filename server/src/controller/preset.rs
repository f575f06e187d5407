//! Presets: listed, and any genome brought into a lineage as it is.

use axum::Json;
use axum::extract::State;
use axum::response::Response;
use brood_genome::Dialect;
use brood_preset::PRESETS;
use brood_protocol::{Adopt, Generation, LineageId};

use super::created;
use super::generation::{COLLECTION, answer, replay};
use crate::extract::{Json as JsonBody, NoQuery, Path};
use crate::idempotency::{Begun, IdempotencyKey};
use crate::problem::ApiError;
use crate::stage::Stages;
use crate::state::App;

/// A hand-written material to start from.
#[derive(Debug, Clone, serde::Serialize, utoipa::ToSchema)]
pub struct PresetAnswer {
    /// As requests name it.
    name: &'static str,
    /// As people do.
    title: &'static str,
    /// What it looks like.
    words: &'static str,
    /// The dialect of a lineage that can breed it.
    #[schema(value_type = Object)]
    dialect: Dialect,
    /// The genome as it was written, with comments.
    text: &'static str,
}

/// The materials to start from.
#[utoipa::path(get, path = "/v1/presets", tag = "genomes",
    responses((status = 200, body = Vec<PresetAnswer>)))]
pub async fn list(NoQuery: NoQuery) -> Json<Vec<PresetAnswer>> {
    let answer = PRESETS.iter().map(|preset| PresetAnswer {
        name: preset.name,
        title: preset.title,
        words: preset.words,
        dialect: preset.dialect(),
        text: preset.text,
    });
    Json(answer.collect())
}

/// Brings genomes and presets into a lineage: a generation of individuals without parents, to breed from.
#[utoipa::path(post, path = "/v1/lineages/{id}/adoptions", tag = "generations",
    params(("id" = LineageId, Path)), request_body = Adopt,
    responses((status = 201, body = Generation, headers(
        ("Link" = String, description = "with rel=status: the job that renders the pictures, where there are any to be rendered"),
        ("Server-Timing" = String, description = "where the time went")))))]
pub async fn adopt(
    State(app): State<App>,
    NoQuery: NoQuery,
    Path(id): Path<LineageId>,
    key: IdempotencyKey,
    body: JsonBody<Adopt>,
) -> Result<Response, ApiError> {
    let attempt = match app.ledger.begin(&app.store, key, &body.bytes).await? {
        Begun::Replay(answer) => return Ok(created(COLLECTION, &replay(&app, answer).await?)),
        Begun::Fresh(attempt) => attempt,
    };
    let mut stages = Stages::begin();
    let lineage = app.store.lineage(id).await?;
    let (generation, job) = app.adopt(&lineage, body.value, &attempt, &mut stages).await?;
    Ok(answer(&generation, job, stages))
}
