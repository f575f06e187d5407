//! Pictures made to order: any size, scene, light and evaluator.

mod beside;

use axum::extract::State;
use axum::response::Response;
use brood_protocol::{Backend, IndividualId, PictureFormat, SceneId, TargetId};
use brood_scene::{PixelArea, Sampling};
use http::HeaderMap;
use serde::Deserialize;

use self::beside::Beside;
use super::file::FileHead;
use crate::extract::{Path, Query};
use crate::library::View;
use crate::limit;
use crate::problem::{ApiError, quote};
use crate::state::App;

const SIZE: u32 = 256;
/// The lineage's scene may change, so the address is not the picture's for ever.
const CACHE: &str = "private, no-cache";

/// What the picture is of.
#[derive(Debug, Clone, Deserialize, utoipa::IntoParams)]
#[into_params(parameter_in = Query)]
#[serde(deny_unknown_fields)]
pub struct RenderQuery {
    /// Side in pixels, 16 to 2048; 256 unless asked otherwise.
    #[param(minimum = 16, maximum = 2048)]
    size: Option<u32>,
    /// The scene; the lineage's unless asked otherwise.
    scene: Option<SceneId>,
    /// Position on the scene's light circle, degrees.
    light_deg: Option<f64>,
    /// Samples per pixel: `adaptive`, or 1 to 64 in every pixel; adaptive unless asked otherwise.
    samples: Option<String>,
    /// Only this part of the picture, `x,y,width,height` in its pixels; all of it unless asked otherwise.
    area: Option<String>,
    /// The evaluator; the server's unless asked otherwise.
    backend: Option<Backend>,
    /// A target that the picture is to be held against. One of pictures: drawn in the scene of its `view`, at its size unless `size` is given,
    /// as bright as that picture. A measured one: exposed as the target is under the same scene and light. Not with `area` or `backend`.
    target: Option<TargetId>,
    /// Which of the target's pictures, counted from 0; the first unless asked otherwise.
    view: Option<u32>,
}

/// A developed picture.
#[utoipa::path(get, path = "/v1/individuals/{id}/render.png", tag = "pictures",
    params(("id" = IndividualId, Path), RenderQuery),
    responses((status = 200, content_type = "image/png"), (status = 304, description = "unchanged")))]
pub async fn png(
    state: State<App>,
    path: Path<IndividualId>,
    query: Query<RenderQuery>,
    headers: HeaderMap,
) -> Result<Response, ApiError> {
    render(state, path, query, &headers, PictureFormat::Png).await
}

/// Linear radiance.
#[utoipa::path(get, path = "/v1/individuals/{id}/render.exr", tag = "pictures",
    params(("id" = IndividualId, Path), RenderQuery),
    responses((status = 200, content_type = "image/x-exr"), (status = 304, description = "unchanged")))]
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
    let size_px = size(query.size)?;
    let sampling = sampling(query.samples.as_deref())?;
    let area = area(query.area.as_deref(), size_px)?;
    check_light(query.light_deg)?;
    if let Some(target) = query.target {
        if area.is_some() || query.backend.is_some() {
            let words = "beside a target pictures are whole, and the server's evaluator draws them";
            return Err(ApiError::bad_parameter("target", words));
        }
        let beside = Beside {
            target,
            view: query.view,
            size_px: query.size,
            scene: query.scene,
            light_deg: query.light_deg,
            sampling: query.samples.is_some().then_some(sampling),
            format,
        };
        let individual = app.store.individual(id).await?;
        return beside.answer(&app, &individual, headers).await;
    }
    if query.view.is_some() {
        return Err(ApiError::bad_parameter("view", "which target's?"));
    }
    check_rays(area.unwrap_or(PixelArea::whole(size_px)).pixels(), sampling)?;
    let individual = app.store.individual(id).await?;
    let scene = match query.scene {
        Some(scene) => scene,
        None => app.store.lineage(individual.lineage).await?.scene,
    };
    let view = View {
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
    let key = framed.key(material.program.hash());
    let etag = format!("\"{key}\"");
    let head = FileHead { etag, content_type: content_type(format), cache: CACHE };
    let make = async {
        let row = app.announce(framed.row(key, individual.hash)).await?;
        app.picture(&row).await
    };
    head.made(headers, make).await
}

/// The side of a picture, within what one may have.
pub(super) fn size(asked: Option<u32>) -> Result<u32, ApiError> {
    limit::side(asked.unwrap_or(SIZE), limit::PICTURE_PX)
}

/// Refuses what is no place on the light circle.
pub(super) fn check_light(light_deg: Option<f64>) -> Result<(), ApiError> {
    match light_deg.filter(|light| !(light.is_finite() && light.abs() <= 1e6)) {
        Some(_) => Err(ApiError::bad_parameter("light_deg", "a number of degrees up to a million")),
        None => Ok(()),
    }
}

/// Refuses pictures that take too long.
pub(super) fn check_rays(pixels: u64, sampling: Sampling) -> Result<(), ApiError> {
    let rays = pixels * u64::from(sampling.least());
    if rays > limit::RAYS {
        let words = format!("size and samples make {rays} rays; {} is the most", limit::RAYS);
        return Err(ApiError::refused(words));
    }
    Ok(())
}

fn content_type(format: PictureFormat) -> &'static str {
    match format {
        PictureFormat::Png => "image/png",
        PictureFormat::Exr => "image/x-exr",
    }
}

/// How a picture is sampled; adaptively unless asked otherwise.
pub(super) fn sampling(text: Option<&str>) -> Result<Sampling, ApiError> {
    let Some(text) = text else { return Ok(Sampling::default()) };
    let known = text.parse().ok().filter(|sampling: &Sampling| sampling.least() <= limit::SAMPLES);
    known.ok_or_else(|| {
        let words = format!("adaptive or 1 to {}, not {}", limit::SAMPLES, quote(text));
        ApiError::bad_parameter("samples", words)
    })
}

fn area(text: Option<&str>, size_px: u32) -> Result<Option<PixelArea>, ApiError> {
    let Some(text) = text else { return Ok(None) };
    let known = text.parse().ok().filter(|area: &PixelArea| area.is_within(size_px));
    let known = known.ok_or_else(|| {
        let words = format!(
            "x,y,width,height within the {size_px} pixels of the picture, not {}",
            quote(text)
        );
        ApiError::bad_parameter("area", words)
    })?;
    // All of it is the picture itself, under its own key.
    Ok(Some(known).filter(|area| *area != PixelArea::whole(size_px)))
}
