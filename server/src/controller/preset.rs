//! Presets, and adoption of any genome into a lineage.

use axum::Json;
use axum::extract::State;
use axum::response::Response;
use brood_genome::Dialect;
use brood_genome::preset::PRESETS;
use brood_protocol::{Adopt, Generation, LineageId};

use super::created;
use super::generation::{COLLECTION, answer, replay};
use crate::extract::{Json as JsonBody, NoQuery, Path};
use crate::idempotency::{Begun, IdempotencyKey};
use crate::problem::ApiError;
use crate::server_timing::ServerTiming;
use crate::state::App;

/// Hand-written material to start from.
#[derive(Debug, Clone, serde::Serialize, utoipa::ToSchema)]
pub struct PresetAnswer {
    /// Name used in requests.
    name: &'static str,
    /// Name for people.
    title: &'static str,
    /// Description of its appearance.
    words: &'static str,
    /// Dialect of a lineage that can breed it.
    #[schema(value_type = Object)]
    dialect: Dialect,
    /// Source text of the genome, with comments.
    text: &'static str,
}

/// Lists the presets.
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

/// Adds genomes and presets to a lineage, as a generation of individuals without parents.
#[utoipa::path(post, path = "/v1/lineages/{id}/adoptions", tag = "generations",
    params(("id" = LineageId, Path)), request_body = Adopt,
    responses((status = 201, body = Generation, headers(
        ("Link" = String, description = "job that renders the pictures, with rel=status; absent if no picture must be rendered"),
        ("Server-Timing" = String, description = "duration of each stage")))))]
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
    let mut timing = ServerTiming::begin();
    let lineage = app.store.lineage(id).await?;
    let brood = app.breeding.adopt(&lineage, body.value, &mut timing).await?;
    let (generation, job) = brood.deliver(&app, &lineage, &attempt, &mut timing).await?;
    Ok(answer(&generation, job, timing))
}
