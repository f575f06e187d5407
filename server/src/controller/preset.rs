//! Presets.

use axum::Json;
use brood_genome::Dialect;
use brood_genome::preset::PRESETS;

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
#[utoipa::path(get, path = "/v1/presets", operation_id = "list_presets", tag = "genomes",
    responses((status = 200, description = "presets", body = Vec<PresetAnswer>)))]
pub async fn list() -> Json<Vec<PresetAnswer>> {
    let answer = PRESETS.iter().map(|preset| PresetAnswer {
        name: preset.name,
        title: preset.title,
        words: preset.words,
        dialect: preset.dialect(),
        text: preset.text,
    });
    Json(answer.collect())
}
