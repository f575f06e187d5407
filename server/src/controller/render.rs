//! Pictures made to order: any size, scene, light and evaluator.

use axum::extract::State;
use axum::response::Response;
use brood_protocol::{Backend, IndividualId, PictureFormat, SceneId};
use brood_scene::{PixelArea, Sampling};
use http::HeaderMap;
use serde::Deserialize;

use super::file;
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
    let size_px = query.size.unwrap_or(SIZE);
    let sides = limit::PICTURE_MIN_PX..=limit::PICTURE_PX;
    if !sides.contains(&size_px) {
        let words = format!("{} to {} pixels, not {size_px}", sides.start(), sides.end());
        return Err(ApiError::bad_parameter("size", words));
    }
    let sampling = sampling(query.samples.as_deref())?;
    let area = area(query.area.as_deref(), size_px)?;
    let light = query.light_deg.filter(|light| !(light.is_finite() && light.abs() <= 1e6));
    if light.is_some() {
        return Err(ApiError::bad_parameter("light_deg", "a number of degrees up to a million"));
    }
    let pixels = area.unwrap_or(PixelArea::whole(size_px)).pixels();
    let rays = pixels * u64::from(sampling.least());
    if rays > limit::RAYS {
        let words = format!("size and samples make {rays} rays; {} is the most", limit::RAYS);
        return Err(ApiError::refused(words));
    }
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
    let content_type = match format {
        PictureFormat::Png => "image/png",
        PictureFormat::Exr => "image/x-exr",
    };
    if super::has_already(headers, &etag) {
        return Ok(file(headers, &etag, content_type, CACHE, ""));
    }
    let row = app.announce(framed.row(key, individual.hash)).await?;
    let bytes = app.picture(&row).await?;
    Ok(file(headers, &etag, content_type, CACHE, bytes))
}

fn sampling(text: Option<&str>) -> Result<Sampling, ApiError> {
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
