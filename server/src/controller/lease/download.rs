//! Downloads for workers: meshes, light files and target files, by hash.

use axum::extract::State;
use axum::response::Response;
use brood_protocol::{LightAssetFile, TargetBytes, encode};

use super::message;
use crate::extract::Path;
use crate::problem::ApiError;
use crate::state::App;

/// Returns an uploaded mesh by its content hash.
#[utoipa::path(get, path = "/v1/leases/meshes/{hash}", operation_id = "download_mesh", tag = "workers",
    params(("hash" = String, Path)),
    responses((status = 200, description = "mesh as it is stored",
        content_type = "application/vnd.brood.lease")))]
pub async fn mesh(State(app): State<App>, Path(hash): Path<String>) -> Result<Response, ApiError> {
    let hash = parse(&hash, "a mesh hash must be 64 hexadecimal digits")?;
    // Sent as it is stored: the worker accepts the version in its prefix.
    Ok(message(app.store.mesh_data(hash).await?))
}

/// Returns a light's file by its hash.
#[utoipa::path(get, path = "/v1/leases/light-assets/{hash}", operation_id = "download_light_asset", tag = "workers",
    params(("hash" = String, Path)),
    responses((status = 200, description = "kind and bytes of the file",
        content_type = "application/vnd.brood.lease")))]
pub async fn light_asset(
    State(app): State<App>,
    Path(hash): Path<String>,
) -> Result<Response, ApiError> {
    let hash = parse(&hash, "a file hash must be 64 hexadecimal digits")?;
    let (kind, bytes) = app.store.light_asset(hash).await?;
    Ok(message(encode(&LightAssetFile { kind, bytes })))
}

/// Returns a target's file by its hash.
#[utoipa::path(get, path = "/v1/leases/targets/{hash}", operation_id = "download_target", tag = "workers",
    params(("hash" = String, Path)),
    responses((status = 200, description = "bytes of the file",
        content_type = "application/vnd.brood.lease")))]
pub async fn target(
    State(app): State<App>,
    Path(hash): Path<String>,
) -> Result<Response, ApiError> {
    let hash = parse(&hash, "a file hash must be 64 hexadecimal digits")?;
    let bytes = app.store.target_file(hash).await?;
    Ok(message(encode(&TargetBytes { bytes })))
}

/// Parses a content hash; 404 with this detail if it is not one.
fn parse(hash: &str, detail: &'static str) -> Result<[u8; 32], ApiError> {
    let hash = blake3::Hash::from_hex(hash).map_err(|_| ApiError::not_found(detail))?;
    Ok(*hash.as_bytes())
}
