//! Meshes: uploaded as OBJ, stored as parsed meshes. The file itself is not kept.

use axum::Json;
use axum::body::Body;
use axum::extract::State;
use axum::response::Response;
use brood_mesh::{Mesh, ObjFile, ObjLimits, ObjWarning, parse_obj};
use brood_protocol::{MeshAnswer, MeshId, MeshWarning, encode};
use brood_storage::StoredMesh;
use http::{Request, StatusCode};

use super::create_once;
use crate::extract::{Path, read_upload};
use crate::idempotency::IdempotencyKey;
use crate::limit;
use crate::problem::{ApiError, quote};
use crate::state::App;

const COLLECTION: &str = "/v1/meshes";

/// Uploads an OBJ file.
#[utoipa::path(post, path = "/v1/meshes", operation_id = "create_mesh", tag = "meshes",
    request_body(content = Vec<u8>, content_type = "model/obj"),
    params(IdempotencyKey),
    responses((status = 201, description = "id and summary of the mesh", body = MeshAnswer)))]
pub async fn create(
    State(app): State<App>,
    key: IdempotencyKey,
    request: Request<Body>,
) -> Result<Response, ApiError> {
    let (_, bytes) = read_upload(request, &["model/obj"], limit::OBJ_BYTES).await?;
    create_once(&app, key, COLLECTION, bytes.clone(), async |attempt| {
        let parsed = app.processors.run(move || -> Result<_, ApiError> {
            let ObjFile { mesh, warnings } = parse_obj(&bytes, &ObjLimits::default())?;
            Ok((row(&mesh, warnings), encode(&mesh)))
        });
        let (mut row, data) = parsed.await??;
        row.id = app.store.put_mesh(row.clone(), data).await?;
        let answer = answer(row)?;
        attempt.store(&app.store, StatusCode::CREATED, &answer).await?;
        Ok(answer)
    })
    .await
}

/// Returns a mesh's summary, without its geometry.
#[utoipa::path(get, path = "/v1/meshes/{id}", operation_id = "get_mesh", tag = "meshes",
    params(("id" = MeshId, Path)),
    responses((status = 200, description = "summary of the mesh", body = MeshAnswer)))]
pub async fn get(
    State(app): State<App>,
    Path(id): Path<MeshId>,
) -> Result<Json<MeshAnswer>, ApiError> {
    answer(app.store.mesh(id).await?).map(Json)
}

/// Returns the row of a new mesh.
pub fn row(mesh: &Mesh, warnings: Vec<ObjWarning>) -> StoredMesh {
    let warnings: Vec<_> = warnings
        .into_iter()
        .map(|warning| MeshWarning { line: warning.line, text: warning.text })
        .collect();
    StoredMesh {
        id: MeshId::fresh(),
        content_hash: mesh.content_hash(),
        vertices: mesh.vertex_count() as u64,
        triangles: mesh.triangle_count() as u64,
        has_uv: mesh.has_uv(),
        warnings_json: serde_json::to_string(&warnings).expect("warnings are numbers and text"),
    }
}

fn answer(row: StoredMesh) -> Result<MeshAnswer, ApiError> {
    let warnings = serde_json::from_str(&row.warnings_json).map_err(|error| {
        ApiError::internal(format!("cannot read stored warnings: {}", quote(&error.to_string())))
    })?;
    Ok(MeshAnswer {
        id: row.id,
        vertices: row.vertices,
        triangles: row.triangles,
        has_uv: row.has_uv,
        warnings,
    })
}
