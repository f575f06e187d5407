//! Scenes: stored by content, read by id.

use axum::Json;
use axum::extract::State;
use axum::response::Response;
use brood_genome::GenomeHash;
use brood_genome::preset::Preset;
use brood_protocol::{SceneAnswer, SceneId};
use brood_scene::Scene;
use http::StatusCode;

use super::create_once;
use crate::clock::now_ms;
use crate::extract::{Json as JsonBody, Path};
use crate::idempotency::IdempotencyKey;
use crate::problem::ApiError;
use crate::scene_asset;
use crate::state::App;

const COLLECTION: &str = "/v1/scenes";

/// Stores a scene; equal scenes have the same id.
#[utoipa::path(post, path = "/v1/scenes", operation_id = "create_scene", tag = "scenes", request_body = Scene,
    params(IdempotencyKey),
    responses((status = 201, description = "scene with its id", body = SceneAnswer)))]
pub async fn create(
    State(app): State<App>,
    key: IdempotencyKey,
    body: JsonBody<Scene>,
) -> Result<Response, ApiError> {
    create_once(&app, key, COLLECTION, body.bytes, async |attempt| {
        let scene = body.value;
        scene.validate()?;
        app.library.meshes(&scene).await?;
        scene_asset::check(&app.store, &scene).await?;
        let id = store(&app, &scene).await?;
        let answer = SceneAnswer { id, scene };
        attempt.store(&app.store, StatusCode::CREATED, &answer).await?;
        Ok(answer)
    })
    .await
}

/// Returns the default scene of new lineages.
#[utoipa::path(get, path = "/v1/scenes/default", operation_id = "get_default_scene", tag = "scenes",
    responses((status = 200, description = "default scene", body = Scene)))]
pub async fn default() -> Json<Scene> {
    Json(Scene::default())
}

/// Returns a scene.
#[utoipa::path(get, path = "/v1/scenes/{id}", operation_id = "get_scene", tag = "scenes",
    params(("id" = SceneId, Path)),
    responses((status = 200, description = "scene with its id", body = SceneAnswer)))]
pub async fn get(
    State(app): State<App>,
    Path(id): Path<SceneId>,
) -> Result<Json<SceneAnswer>, ApiError> {
    let known = app.library.scene(id).await?;
    Ok(Json(SceneAnswer { id, scene: known.scene.clone() }))
}

/// Stores a valid scene and returns its id.
///
/// # Errors
/// [`ApiError`] if the store fails.
pub async fn store(app: &App, scene: &Scene) -> Result<SceneId, ApiError> {
    let json = serde_json::to_string(scene).expect("a scene is finite numbers and words");
    let hash = *blake3::hash(json.as_bytes()).as_bytes();
    Ok(app.store.put_scene(&json, hash, &materials(scene), now_ms()).await?)
}

/// Returns the hashes of the genomes that a scene names as materials.
pub fn materials(scene: &Scene) -> Vec<GenomeHash> {
    let presets = |name: &&str| Preset::find(name).is_none();
    let names = scene.materials().filter_map(|(name, _)| name).filter(presets);
    names.filter_map(|name| name.parse().ok()).collect()
}
