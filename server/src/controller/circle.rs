//! Pictures over the light's whole circle: animations, animated sheets, and sprite strips.
//!
//! Under automatic exposure all frames share one exposure, measured over the whole circle, so that
//! they do not flicker.

use std::sync::Arc;

use axum::extract::State;
use axum::response::Response;
use brood_eval::{SheetCell, centre_px, decode_png, encode_apng, encode_png};
use brood_protocol::{GenerationId, IndividualId, LineageId, Queue, SceneId};
use brood_scene::{EV_MAX, Exposure, Film, Scene};
use brood_storage::{StoredIndividual, StoredPicture};
use futures::stream::{self, StreamExt, TryStreamExt};
use http::HeaderMap;
use serde::Deserialize;

use super::file::{FileHead, REVALIDATED};
use super::sheet as contact;
use crate::deferred::{AnswerProgress, in_time};
use crate::dispatch::queue_for;
use crate::extract::{Path, Query};
use crate::library::Framing;
use crate::limit;
use crate::problem::ApiError;
use crate::state::App;

const SIZE: u32 = 128;
const FRAMES: u32 = 24;
const SECONDS: f32 = 4.0;
/// Number of pictures requested at a time.
const AT_ONCE: usize = 32;
/// Cells along one side of a sheet with a centre.
const RING: u32 = 6;
/// Number of children around a centre.
const AROUND: usize = 20;

/// Options of an animation or strip.
#[derive(Debug, Clone, Copy, Deserialize, utoipa::IntoParams)]
#[into_params(parameter_in = Query)]
#[serde(deny_unknown_fields)]
pub struct CircleQuery {
    /// Side of each picture in pixels, 16 to 1024; default 128.
    #[param(minimum = 16, maximum = 1024)]
    size: Option<u32>,
    /// Number of pictures along the circle, 2 to 120; default 24.
    #[param(minimum = 2, maximum = 120)]
    frames: Option<u32>,
    /// Duration of one turn in seconds, 0.1 to 60; default 4. Not used for strips.
    #[param(minimum = 0.1, maximum = 60)]
    seconds: Option<f32>,
    /// Scene to render; default: the lineage's scene.
    scene: Option<SceneId>,
}

/// Checked [`CircleQuery`].
#[derive(Debug, Clone, Copy)]
struct CircleOptions {
    size_px: u32,
    frames: u32,
    delay_ms: u16,
    scene: Option<SceneId>,
}

impl CircleQuery {
    /// Checks the query for frames of `cells` pictures each.
    fn check(&self, cells: u64) -> Result<CircleOptions, ApiError> {
        let size_px = limit::side(self.size.unwrap_or(SIZE), limit::THUMBNAIL_PX)?;
        let frames = self.frames.unwrap_or(FRAMES);
        let seconds = self.seconds.unwrap_or(SECONDS);
        if !(2..=limit::CIRCLE_FRAMES).contains(&frames) {
            let words = format!("must be 2 to {}, got {frames}", limit::CIRCLE_FRAMES);
            return Err(ApiError::bad_parameter("frames", words));
        }
        if !(0.1..=60.0).contains(&seconds) {
            return Err(ApiError::bad_parameter("seconds", "must be 0.1 to 60"));
        }
        let pixels = cells * u64::from(frames) * u64::from(size_px) * u64::from(size_px);
        if pixels > limit::CIRCLE_PIXELS {
            let most = limit::CIRCLE_PIXELS;
            let words =
                format!("size and frames add up to {pixels} pixels; at most {most} are allowed");
            return Err(ApiError::refused(words));
        }
        let delay_ms = (1000.0 * seconds / frames as f32).round() as u16;
        Ok(CircleOptions { size_px, frames, delay_ms, scene: self.scene })
    }
}

/// Returns the queue of the work on a circle.
fn queue_of(circle: CircleOptions) -> Queue {
    queue_for(u64::from(circle.frames) * u64::from(circle.size_px).pow(2))
}

/// Returns an animated PNG of an individual, with the light going once around its circle.
#[utoipa::path(get, path = "/v1/individuals/{id}/render.apng", operation_id = "get_animation", tag = "pictures",
    params(("id" = IndividualId, Path), CircleQuery),
    responses((status = 200, description = "animated PNG", content_type = "image/apng"), (status = 304)))]
pub async fn animation(
    State(app): State<App>,
    Path(id): Path<IndividualId>,
    Query(query): Query<CircleQuery>,
    headers: HeaderMap,
) -> Result<Response, ApiError> {
    let circle = query.check(1)?;
    let frames = rows_of(&app, id, circle).await?;
    let etag = etag("apng", circle.delay_ms, frames.iter());
    let head = FileHead { etag, content_type: "image/apng", cache: REVALIDATED };
    let make = async {
        let pictures = pictures(&app, frames, circle.size_px).await?;
        let (size_px, delay_ms) = (circle.size_px, circle.delay_ms);
        let encode = move || encode_apng(size_px, size_px, &pictures, delay_ms);
        app.processors.run_from(queue_of(circle), encode).await
    };
    head.made(&headers, make).await
}

/// Returns a strip of all pictures along the light's circle, side by side in one PNG.
#[utoipa::path(get, path = "/v1/individuals/{id}/strip.png", operation_id = "get_strip", tag = "pictures",
    params(("id" = IndividualId, Path), CircleQuery),
    responses((status = 200, description = "strip of pictures as PNG", content_type = "image/png"),
        (status = 304)))]
pub async fn strip(
    State(app): State<App>,
    Path(id): Path<IndividualId>,
    Query(query): Query<CircleQuery>,
    headers: HeaderMap,
) -> Result<Response, ApiError> {
    let circle = query.check(1)?;
    let frames = rows_of(&app, id, circle).await?;
    let etag = etag("strip", 0, frames.iter());
    let head = FileHead { etag, content_type: "image/png", cache: REVALIDATED };
    let make = async {
        let side = circle.size_px;
        let pictures = pictures(&app, frames, side).await?;
        app.processors.run(move || side_by_side(&pictures, side)).await
    };
    head.made(&headers, make).await
}

/// Returns a generation's contact sheet as an animated PNG, with the light going once around its
/// circle.
///
/// Each individual has its own exposure.
#[utoipa::path(get, path = "/v1/generations/{id}/sheet.apng", operation_id = "get_animated_sheet", tag = "pictures",
    params(("id" = GenerationId, Path), CircleQuery),
    responses((status = 200, description = "contact sheet as animated PNG", content_type = "image/apng"),
        (status = 304)))]
pub async fn sheet(
    State(app): State<App>,
    Path(id): Path<GenerationId>,
    Query(query): Query<CircleQuery>,
    headers: HeaderMap,
) -> Result<Response, ApiError> {
    let generation = app.store.generation(id).await?;
    let around = generation.individuals.len() == AROUND;
    let centre = generation.centre.or_else(|| generation.individuals.first().cloned());
    let centre = centre.filter(|_| around);
    let cells =
        if centre.is_some() { u64::from(RING * RING) } else { generation.individuals.len() as u64 };
    let circle = query.check(cells)?;
    let gap_px = (circle.size_px / 32).max(1);
    let side = centre_px(circle.size_px, gap_px);
    let large =
        CircleOptions { size_px: side.clamp(limit::PICTURE_MIN_PX, limit::PICTURE_PX), ..circle };
    // Indexed by individual, then by light position.
    let mut rows = Vec::with_capacity(generation.individuals.len() + 1);
    for one in generation.individuals {
        rows.push(self::rows(&app, one, generation.lineage, circle).await?);
    }
    if let Some(centre) = &centre {
        rows.push(self::rows(&app, centre.clone(), generation.lineage, large).await?);
    }
    let etag = etag("sheet", circle.delay_ms, rows.iter().flatten());
    let head = FileHead { etag, content_type: "image/apng", cache: REVALIDATED };
    let has_centre = centre.is_some();
    let compose = async {
        AnswerProgress::expect(rows.iter().map(Vec::len).sum());
        let mut frames = Vec::with_capacity(circle.frames as usize);
        let mut size = (0, 0);
        for frame in 0..circle.frames as usize {
            let rows = rows.iter().map(|places| places[frame].clone()).collect();
            let centre_px = has_centre.then_some(side);
            let cells = contact::collect(&app, rows, centre_px, circle.size_px).await?;
            let draw = move || composed(&cells, has_centre, circle.size_px, gap_px);
            let (width, height, rgba) = app.processors.run(draw).await?;
            size = (width, height);
            frames.push(rgba);
        }
        let encode = move || encode_apng(size.0, size.1, &frames, circle.delay_ms);
        app.processors.run(encode).await
    };
    head.made(&headers, in_time(compose)).await
}

fn composed(
    cells: &[(u32, u32, Vec<u8>)],
    has_centre: bool,
    cell_px: u32,
    gap_px: u32,
) -> (u32, u32, Vec<u8>) {
    let mut cells: Vec<_> = cells
        .iter()
        .map(|(width, height, rgba)| SheetCell { width: *width, height: *height, rgba })
        .collect();
    let centre = if has_centre { cells.pop() } else { None };
    brood_eval::sheet(&cells, centre, cell_px, gap_px)
}

/// Returns the picture rows of an individual around the circle.
async fn rows_of(
    app: &App,
    id: IndividualId,
    circle: CircleOptions,
) -> Result<Vec<Arc<StoredPicture>>, ApiError> {
    let individual = app.store.individual(id).await?;
    let lineage = individual.lineage;
    rows(app, individual, lineage, circle).await
}

async fn rows(
    app: &App,
    individual: StoredIndividual,
    lineage: LineageId,
    circle: CircleOptions,
) -> Result<Vec<Arc<StoredPicture>>, ApiError> {
    let scene = match circle.scene {
        Some(scene) => scene,
        None => app.store.lineage(lineage).await?.scene,
    };
    let scene = exposed(app, scene, &individual).await?;
    let mut rows = Vec::with_capacity(circle.frames as usize);
    for frame in 0..circle.frames {
        let view = Framing {
            light_deg: Some(360.0 * f64::from(frame) / f64::from(circle.frames)),
            ..Framing::png(scene, circle.size_px, app.backend)
        };
        rows.push(contact::row(app, &individual, view).await?);
    }
    Ok(rows)
}

/// Returns the scene with the individual's exposure over the whole circle, if its exposure is
/// automatic.
async fn exposed(
    app: &App,
    id: SceneId,
    individual: &StoredIndividual,
) -> Result<SceneId, ApiError> {
    let known = app.library.scene(id).await?;
    if known.scene.film.exposure != Exposure::Auto || known.has_lit_ground {
        // A lit ground decides the exposure, whatever the material.
        return Ok(id);
    }
    // Beyond the limit of a scene's exposure, the picture is all black or all white anyway.
    let ev = circle_ev(app, id, individual).await?.clamp(-EV_MAX, EV_MAX);
    let film = Film { exposure: Exposure::Ev(ev), ..known.scene.film };
    super::scene::store(app, &Scene { film, ..known.scene.clone() }).await
}

/// Returns an individual's exposure in EV over the whole light circle of a scene.
///
/// # Errors
/// [`ApiError`] if the scene or the genome cannot be read, or the server is busy.
pub async fn circle_ev(
    app: &App,
    scene: SceneId,
    individual: &StoredIndividual,
) -> Result<f64, ApiError> {
    let circle = app.library.light_circle(scene).await?;
    let material = app.library.material(individual.hash).await?;
    // Colours of a display have no exposure.
    let Some(brdf) = material.program.brdf() else { return Ok(0.0) };
    app.processors.run(move || circle.common_ev(&brdf)).await
}

/// Returns the decoded pixels of pictures of one size.
async fn pictures(
    app: &App,
    rows: Vec<Arc<StoredPicture>>,
    size_px: u32,
) -> Result<Vec<Vec<u8>>, ApiError> {
    AnswerProgress::expect(rows.len());
    let queue = queue_for(rows.len() as u64 * u64::from(size_px).pow(2));
    let pictures = rows.into_iter();
    let pictures = pictures.map(|row| async move { app.pictures.get_from(queue, &row).await });
    let pictures = stream::iter(pictures).buffered(AT_ONCE).try_collect::<Vec<_>>();
    let pictures = in_time(pictures).await?;
    let decode = move || pictures.iter().map(|png| pixels(png, size_px)).collect();
    app.processors.run_from(queue, decode).await?
}

fn pixels(png: &[u8], size_px: u32) -> Result<Vec<u8>, ApiError> {
    match decode_png(png) {
        Ok((width, height, rgba)) if (width, height) == (size_px, size_px) => Ok(rgba),
        Ok(_) => Err(ApiError::internal("a rendered picture has the wrong size")),
        Err(error) => Err(ApiError::internal(format!("a picture cannot be decoded: {error}"))),
    }
}

fn side_by_side(pictures: &[Vec<u8>], side: u32) -> Vec<u8> {
    let line = 4 * side as usize;
    let mut rgba = Vec::with_capacity(pictures.len() * line * side as usize);
    for row in 0..side as usize {
        for picture in pictures {
            rgba.extend_from_slice(&picture[row * line..(row + 1) * line]);
        }
    }
    let count = u32::try_from(pictures.len()).expect("a circle has few pictures");
    encode_png(count * side, side, &rgba)
}

fn etag<'a>(
    kind: &str,
    delay_ms: u16,
    rows: impl Iterator<Item = &'a Arc<StoredPicture>>,
) -> String {
    let mut hasher = blake3::Hasher::new();
    hasher.update(kind.as_bytes()).update(&delay_ms.to_le_bytes());
    rows.for_each(|row| {
        hasher.update(&row.key.0);
    });
    format!("\"{}\"", hasher.finalize().to_hex())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn strip_places_pictures_side_by_side() {
        let picture = |value: u8| vec![value; 4 * 2 * 2];
        let png = side_by_side(&[picture(1), picture(2), picture(3)], 2);
        let (width, height, rgba) = decode_png(&png).unwrap();
        assert_eq!((width, height), (6, 2));
        let row: Vec<u8> = rgba[..24].iter().copied().step_by(4).collect();
        assert_eq!(row, [1, 1, 2, 2, 3, 3]);
        assert_eq!(rgba[..24], rgba[24..]);
    }

    #[test]
    fn circle_is_refused_when_it_is_too_large() {
        let query = CircleQuery { size: None, frames: None, seconds: None, scene: None };
        assert_eq!(query.check(1).unwrap().delay_ms, 167);
        let status = |query: CircleQuery, cells| query.check(cells).unwrap_err().status();
        assert_eq!(status(CircleQuery { frames: Some(1), ..query }, 1), 400);
        assert_eq!(status(CircleQuery { size: Some(2000), ..query }, 1), 400);
        assert_eq!(status(CircleQuery { seconds: Some(f32::NAN), ..query }, 1), 400);
        assert_eq!(status(CircleQuery { size: Some(1024), frames: Some(120), ..query }, 1), 422);
        assert_eq!(status(CircleQuery { size: Some(256), ..query }, 36), 422);
    }
}
