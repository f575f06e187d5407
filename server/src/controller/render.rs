//! Pictures of an individual at any size, scene, light and backend.

pub mod posted;

mod matched;

use axum::extract::State;
use axum::response::Response;
use brood_protocol::{Backend, IndividualId, PictureFormat, SceneId, TargetId};
use brood_scene::{PictureSize, PixelArea};
use http::HeaderMap;
use serde::Deserialize;

use self::matched::MatchedRender;
use super::file::{FileHead, REVALIDATED};
use super::picture_query::{check_light, check_rays, content_type, sampling, size};
use crate::extract::{Path, Query};
use crate::library::Framing;
use crate::problem::{ApiError, quote};
use crate::state::App;

/// Options of a picture.
#[derive(Debug, Clone, Deserialize, utoipa::IntoParams)]
#[into_params(parameter_in = Query)]
#[serde(deny_unknown_fields)]
pub struct RenderQuery {
    /// Size in pixels: the side of a square picture, or width and height as in `640x360`; each side
    /// 16 to 2048, default 256.
    #[param(pattern = "^[0-9]+(x[0-9]+)?$")]
    size: Option<String>,
    /// Scene to render; default: the lineage's scene.
    scene: Option<SceneId>,
    /// Light angle on the scene's light circle, in degrees.
    light_deg: Option<f64>,
    /// Samples per pixel: `adaptive` (default), or a fixed number from 1 to 64.
    samples: Option<String>,
    /// Part of the picture to render, as `x,y,width,height` in pixels; default: all of it.
    area: Option<String>,
    /// Backend to render with; default: the server's.
    backend: Option<Backend>,
    /// Target to compare with; not allowed with `area` or `backend`.
    ///
    /// An image target sets the scene, the brightness and the default size, from its picture
    /// `view`. A measured target sets the exposure: that of the target in the same scene and light.
    target: Option<TargetId>,
    /// Index of the target's picture, from 0; default 0.
    view: Option<u32>,
}

/// Returns a picture of an individual as PNG.
#[utoipa::path(get, path = "/v1/individuals/{id}/render.png", operation_id = "render_individual_png", tag = "pictures",
    params(("id" = IndividualId, Path), RenderQuery),
    responses((status = 200, description = "picture as PNG", content_type = "image/png"), (status = 304)))]
pub async fn png(
    state: State<App>,
    path: Path<IndividualId>,
    query: Query<RenderQuery>,
    headers: HeaderMap,
) -> Result<Response, ApiError> {
    render(state, path, query, &headers, PictureFormat::Png).await
}

/// Returns the linear radiance of an individual as EXR.
#[utoipa::path(get, path = "/v1/individuals/{id}/render.exr", operation_id = "render_individual_exr", tag = "pictures",
    params(("id" = IndividualId, Path), RenderQuery),
    responses((status = 200, description = "linear radiance as EXR", content_type = "image/x-exr"),
        (status = 304)))]
pub async fn exr(
    state: State<App>,
    path: Path<IndividualId>,
    query: Query<RenderQuery>,
    headers: HeaderMap,
) -> Result<Response, ApiError> {
    render(state, path, query, &headers, PictureFormat::Exr).await
}

async fn render(
    State(app): State<App>,
    Path(id): Path<IndividualId>,
    Query(query): Query<RenderQuery>,
    headers: &HeaderMap,
    format: PictureFormat,
) -> Result<Response, ApiError> {
    let size_px = size(query.size.as_deref())?;
    let sampling = sampling(query.samples.as_deref())?;
    let area = area(query.area.as_deref(), size_px)?;
    check_light(query.light_deg)?;
    if let Some(target) = query.target {
        if area.is_some() || query.backend.is_some() {
            let words = "not allowed together with area or backend";
            return Err(ApiError::bad_parameter("target", words));
        }
        let matched = MatchedRender {
            target,
            view: query.view,
            size_px: query.size.is_some().then_some(size_px),
            scene: query.scene,
            light_deg: query.light_deg,
            sampling: query.samples.is_some().then_some(sampling),
            format,
        };
        let individual = app.store.individual(id).await?;
        return matched.answer(&app, &individual, headers).await;
    }
    if query.view.is_some() {
        return Err(ApiError::bad_parameter("view", "needs the parameter target"));
    }
    check_rays(area.unwrap_or(PixelArea::whole(size_px)).pixels(), sampling)?;
    let individual = app.store.individual(id).await?;
    let scene = match query.scene {
        Some(scene) => scene,
        None => app.store.lineage(individual.lineage).await?.scene,
    };
    let view = Framing {
        scene,
        light_deg: query.light_deg,
        size_px,
        sampling,
        area,
        format,
        backend: query.backend.unwrap_or(app.backend),
    };
    let framed = app.library.frame(view).await?;
    let material = app.library.material(individual.hash).await?;
    framed.check(&material.program)?;
    let key = framed.key(material.program.hash());
    let head = FileHead::of_picture(key, content_type(format), REVALIDATED);
    let make = async {
        let row = app.pictures.store_row(framed.row(key, individual.hash)).await?;
        app.pictures.get(&row).await
    };
    head.made(headers, make).await
}

fn area(text: Option<&str>, size_px: PictureSize) -> Result<Option<PixelArea>, ApiError> {
    let Some(text) = text else { return Ok(None) };
    let known = text.parse().ok().filter(|area: &PixelArea| area.is_within(size_px));
    let known = known.ok_or_else(|| {
        let words = format!(
            "must be x,y,width,height within the picture's {} x {} pixels, got {}",
            size_px.width,
            size_px.height,
            quote(text)
        );
        ApiError::bad_parameter("area", words)
    })?;
    // The whole area is dropped, so that the picture has the key of the whole picture.
    Ok(Some(known).filter(|area| *area != PixelArea::whole(size_px)))
}
