//! Pictures of a comparison: one framing and one exposure for all, rendered by workers and read
//! back to be compared.

use std::sync::Arc;

use brood_inspect::{COMPARED, LinearImage};
use brood_protocol::{PictureFormat, SceneId};
use brood_scene::{Exposure, Film, Scene};
use brood_storage::StoredPicture;
use futures::stream::{self, StreamExt, TryStreamExt};

use super::request::{ComparisonRequest, RequestedMaterial, specimen};
use crate::controller::scene;
use crate::library::Framing;
use crate::problem::ApiError;
use crate::state::App;

/// Returns the scene with one fixed exposure for all materials, and that exposure in EV.
///
/// # Errors
/// [`ApiError`] if the scene cannot be read or the server is busy.
pub async fn exposed(app: &App, request: &ComparisonRequest) -> Result<(SceneId, f64), ApiError> {
    let known = app.library.scene(request.scene).await?;
    let film = known.scene.film;
    if let Exposure::Ev(ev) = film.exposure {
        return Ok((request.scene, ev));
    }
    let (circle, first) = (app.library.light_circle(request.scene).await?, request.first());
    let ev = app.processors.run(move || circle.ev(&specimen(&first), film)).await?;
    let film = Film { exposure: Exposure::Ev(ev), ..film };
    let id = scene::store(app, &Scene { film, ..known.scene.clone() }).await?;
    Ok((id, ev))
}

/// Stores and returns the picture row of a material in a view.
///
/// # Errors
/// [`ApiError`] if the scene cannot be read or the store fails.
pub async fn row(
    app: &App,
    one: &RequestedMaterial,
    view: Framing,
) -> Result<Arc<StoredPicture>, ApiError> {
    app.pictures.row_in(view, one.hash, one.material.program.hash()).await
}

/// Returns the linear pictures at the given exposure, in the order of the materials.
///
/// # Errors
/// [`ApiError`] if a picture cannot be rendered or decoded.
pub async fn linear(
    app: &App,
    request: &ComparisonRequest,
    (scene, exposure_ev): (SceneId, f64),
) -> Result<Vec<LinearImage>, ApiError> {
    let view = request.view(app, scene, PictureFormat::Exr);
    let mut rows = Vec::with_capacity(request.materials.len());
    for one in &request.materials {
        rows.push(row(app, one, view).await?);
    }
    let files = rows.into_iter().map(|row| async move { app.pictures.get(&row).await });
    let files = stream::iter(files).buffered(*COMPARED.end()).try_collect::<Vec<_>>().await?;
    let read = move || -> Result<Vec<LinearImage>, ApiError> {
        let read = |exr: &bytes::Bytes| LinearImage::from_exr(exr, exposure_ev);
        let read: Result<_, _> = files.iter().map(read).collect();
        read.map_err(|error| ApiError::internal(error.to_string()))
    };
    app.processors.run(read).await?
}
