//! Lineage files: export and import of a whole history as one JSON document.

mod export;
mod form;
mod import;

use axum::body::Body;
use axum::extract::State;
use axum::response::{IntoResponse, Response};
use brood_protocol::{Lineage, LineageId};
use http::{Request, StatusCode, header};

use export::Export;
pub use form::LineageFile;

use super::create_once;
use crate::control_image;
use crate::extract::{Path, parse_json, read_upload};
use crate::idempotency::IdempotencyKey;
use crate::limit;
use crate::problem::ApiError;
use crate::scene_asset;
use crate::state::App;

const JSON: &str = "application/json";

/// Exports a lineage as one file.
#[utoipa::path(get, path = "/v1/lineages/{id}/file", operation_id = "export_lineage", tag = "lineages",
    params(("id" = LineageId, Path)),
    responses((status = 200, description = "lineage with its generations and genomes", body = LineageFile),
        (status = 422, description = "the file would be larger than the import limit of 256 MiB")))]
pub async fn export(
    State(app): State<App>,
    Path(id): Path<LineageId>,
) -> Result<Response, ApiError> {
    let export = Export::prepare(&app, id).await?;
    let disposition = format!("attachment; filename=\"lineage-{id}.json\"");
    let headers =
        [(header::CONTENT_DISPOSITION, disposition), (header::CONTENT_TYPE, JSON.to_owned())];
    Ok((headers, Body::from_stream(export.stream())).into_response())
}

/// Imports a lineage file of at most 256 MiB.
///
/// Individuals get new ids; the genome hashes stay the same.
#[utoipa::path(post, path = "/v1/lineages/import", operation_id = "import_lineage", tag = "lineages",
    request_body = LineageFile,
    params(IdempotencyKey),
    responses((status = 201, description = "imported lineage", body = Lineage)))]
pub async fn import(
    State(app): State<App>,
    key: IdempotencyKey,
    request: Request<Body>,
) -> Result<Response, ApiError> {
    let (_, bytes) = read_upload(request, &[JSON], limit::LINEAGE_FILE_BYTES).await?;
    create_once(&app, key, "/v1/lineages", bytes.clone(), async |attempt| {
        let check = move || {
            let file = parse_json(&bytes)?;
            drop(bytes);
            import::check(file)
        };
        let checked = app.processors.run(check).await??;
        let import::Checked { file, genomes, images, mesh, object_meshes, light_assets } = checked;
        for (kind, bytes) in light_assets {
            app.store.put_light_asset(*blake3::hash(&bytes).as_bytes(), kind, bytes).await?;
        }
        for (hash, image) in images {
            let pointer = format!("/genomes/{hash}");
            let checked = control_image::check_one(&app.store, image).await;
            checked.map_err(|error| error.at(pointer))?;
        }
        let mut scene = file.scene.clone();
        if let Some((mesh, data)) = mesh {
            let id = app.store.put_mesh(mesh, data).await?;
            scene.mesh = brood_scene::MeshRef::Uploaded(id.to_string());
        }
        for (name, (mesh, data)) in object_meshes {
            let id = app.store.put_mesh(mesh, data).await?;
            let objects = scene.objects.iter_mut().zip(&file.scene.objects);
            for (object, _) in objects.filter(|(_, given)| given.mesh.to_string() == name) {
                object.mesh = brood_scene::MeshRef::Uploaded(id.to_string());
            }
        }
        for hash in super::scene::materials(&scene) {
            if let Some(genome) = genomes.get(&hash) {
                app.store.put_genome((**genome).clone()).await?;
            }
        }
        app.library.meshes(&scene).await.map_err(|error| error.inside("/scene"))?;
        scene_asset::check(&app.store, &scene).await.map_err(|error| error.inside("/scene"))?;
        let scene = super::scene::store(&app, &scene).await?;
        let mut new = import::assemble(file, genomes, scene)?;
        new.idempotency = attempt.record(StatusCode::CREATED, &new.lineage);
        Ok(app.store.import_lineage(new).await?)
    })
    .await
}
