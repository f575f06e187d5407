//! The light's whole circle: animated pictures, animated sheets, and strips of sprites.
//!
//! Under automatic exposure all pictures of a circle have one exposure, measured over all of it, so that nothing flickers.

use std::sync::Arc;

use axum::extract::State;
use axum::response::Response;
use brood_eval::{SheetCell, centre_px, decode_png, encode_apng, encode_png};
use brood_protocol::{GenerationId, IndividualId, LineageId, PictureFormat, SceneId};
use brood_scene::{EV_MAX, Exposure, Film, Sampling, Scene};
use brood_storage::{PictureRow, StoredIndividual};
use futures::stream::{self, StreamExt, TryStreamExt};
use http::HeaderMap;
use serde::Deserialize;

use super::file::FileHead;
use super::sheet as contact;
use crate::extract::{Path, Query};
use crate::library::View;
use crate::limit;
use crate::problem::ApiError;
use crate::state::App;

const CACHE: &str = "private, no-cache";
const SIZE: u32 = 128;
const FRAMES: u32 = 24;
const SECONDS: f32 = 4.0;
/// Pictures that are asked for at a time.
const AT_ONCE: usize = 32;
/// Cells of the side of a sheet with a centre, and how many children it has.
const RING: u32 = 6;
const AROUND: usize = 20;

/// How the circle is shown.
#[derive(Debug, Clone, Copy, Deserialize, utoipa::IntoParams)]
#[into_params(parameter_in = Query)]
#[serde(deny_unknown_fields)]
pub struct CircleQuery {
    /// Side of a picture in pixels, 16 to 1024; 128 unless asked otherwise.
    #[param(minimum = 16, maximum = 1024)]
    size: Option<u32>,
    /// Pictures of the circle, 2 to 120; 24 unless asked otherwise.
    #[param(minimum = 2, maximum = 120)]
    frames: Option<u32>,
    /// How long the circle takes, 0.1 to 60; 4 unless asked otherwise. Not in strips.
    #[param(minimum = 0.1, maximum = 60)]
    seconds: Option<f32>,
    /// The scene; the lineage's unless asked otherwise.
    scene: Option<SceneId>,
}

/// The same, checked.
#[derive(Debug, Clone, Copy)]
struct Circle {
    size_px: u32,
    frames: u32,
    delay_ms: u16,
    scene: Option<SceneId>,
}

impl CircleQuery {
    /// Refuses more pixels than one answer may have, of `cells` pictures a frame.
    fn check(&self, cells: u64) -> Result<Circle, ApiError> {
        let size_px = limit::side(self.size.unwrap_or(SIZE), limit::THUMBNAIL_PX)?;
        let frames = self.frames.unwrap_or(FRAMES);
        let seconds = self.seconds.unwrap_or(SECONDS);
        if !(2..=limit::CIRCLE_FRAMES).contains(&frames) {
            let words = format!("2 to {} pictures, not {frames}", limit::CIRCLE_FRAMES);
            return Err(ApiError::bad_parameter("frames", words));
        }
        if !(0.1..=60.0).contains(&seconds) {
            return Err(ApiError::bad_parameter("seconds", "0.1 to 60"));
        }
        let pixels = cells * u64::from(frames) * u64::from(size_px) * u64::from(size_px);
        if pixels > limit::CIRCLE_PIXELS {
            let most = limit::CIRCLE_PIXELS;
            let words = format!("size and frames make {pixels} pixels; {most} is the most");
            return Err(ApiError::refused(words));
        }
        let delay_ms = (1000.0 * seconds / frames as f32).round() as u16;
        Ok(Circle { size_px, frames, delay_ms, scene: self.scene })
    }
}

/// A whole circle of the light as an animated PNG.
#[utoipa::path(get, path = "/v1/individuals/{id}/render.apng", tag = "pictures",
    params(("id" = IndividualId, Path), CircleQuery),
    responses((status = 200, content_type = "image/apng"), (status = 304, description = "unchanged")))]
pub async fn animation(
    State(app): State<App>,
    Path(id): Path<IndividualId>,
    Query(query): Query<CircleQuery>,
    headers: HeaderMap,
) -> Result<Response, ApiError> {
    let circle = query.check(1)?;
    let frames = rows_of(&app, id, circle).await?;
    let etag = etag("apng", circle.delay_ms, frames.iter());
    let head = FileHead { etag, content_type: "image/apng", cache: CACHE };
    let make = async {
        let pictures = pictures(&app, frames, circle.size_px).await?;
        let (size_px, delay_ms) = (circle.size_px, circle.delay_ms);
        app.on_processor(move || encode_apng(size_px, size_px, &pictures, delay_ms)).await
    };
    head.made(&headers, make).await
}

/// A whole circle of the light as one PNG: its pictures side by side.
#[utoipa::path(get, path = "/v1/individuals/{id}/strip.png", tag = "pictures",
    params(("id" = IndividualId, Path), CircleQuery),
    responses((status = 200, content_type = "image/png"), (status = 304, description = "unchanged")))]
pub async fn strip(
    State(app): State<App>,
    Path(id): Path<IndividualId>,
    Query(query): Query<CircleQuery>,
    headers: HeaderMap,
) -> Result<Response, ApiError> {
    let circle = query.check(1)?;
    let frames = rows_of(&app, id, circle).await?;
    let etag = etag("strip", 0, frames.iter());
    let head = FileHead { etag, content_type: "image/png", cache: CACHE };
    let make = async {
        let side = circle.size_px;
        let pictures = pictures(&app, frames, side).await?;
        app.on_processor(move || side_by_side(&pictures, side)).await
    };
    head.made(&headers, make).await
}

/// A generation as an animated PNG over a whole circle of the light: the sheet, each individual at its own exposure.
#[utoipa::path(get, path = "/v1/generations/{id}/sheet.apng", tag = "pictures",
    params(("id" = GenerationId, Path), CircleQuery),
    responses((status = 200, content_type = "image/apng"), (status = 304, description = "unchanged")))]
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
    let large = Circle { size_px: side.clamp(limit::PICTURE_MIN_PX, limit::PICTURE_PX), ..circle };
    // By individual, in each by place of the light.
    let mut rows = Vec::with_capacity(generation.individuals.len() + 1);
    for one in generation.individuals {
        rows.push(self::rows(&app, one, generation.lineage, circle).await?);
    }
    if let Some(centre) = &centre {
        rows.push(self::rows(&app, centre.clone(), generation.lineage, large).await?);
    }
    let etag = etag("sheet", circle.delay_ms, rows.iter().flatten());
    let head = FileHead { etag, content_type: "image/apng", cache: CACHE };
    let has_centre = centre.is_some();
    let compose = async {
        let mut frames = Vec::with_capacity(circle.frames as usize);
        let mut size = (0, 0);
        for frame in 0..circle.frames as usize {
            let rows = rows.iter().map(|places| places[frame].clone()).collect();
            let centre_px = has_centre.then_some(side);
            let cells = contact::collect(&app, rows, centre_px, circle.size_px).await?;
            let draw = move || composed(&cells, has_centre, circle.size_px, gap_px);
            let (width, height, rgba) = app.on_processor(draw).await?;
            size = (width, height);
            frames.push(rgba);
        }
        let encode = move || encode_apng(size.0, size.1, &frames, circle.delay_ms);
        app.on_processor(encode).await
    };
    head.made(&headers, limit::in_time(compose)).await
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

/// The pictures of an individual around the circle, by what they are made of.
async fn rows_of(
    app: &App,
    id: IndividualId,
    circle: Circle,
) -> Result<Vec<Arc<PictureRow>>, ApiError> {
    let individual = app.store.individual(id).await?;
    let lineage = individual.lineage;
    rows(app, individual, lineage, circle).await
}

async fn rows(
    app: &App,
    individual: StoredIndividual,
    lineage: LineageId,
    circle: Circle,
) -> Result<Vec<Arc<PictureRow>>, ApiError> {
    let scene = match circle.scene {
        Some(scene) => scene,
        None => app.store.lineage(lineage).await?.scene,
    };
    let scene = exposed(app, scene, &individual).await?;
    let mut rows = Vec::with_capacity(circle.frames as usize);
    for frame in 0..circle.frames {
        let view = View {
            scene,
            light_deg: Some(360.0 * f64::from(frame) / f64::from(circle.frames)),
            size_px: circle.size_px,
            sampling: Sampling::default(),
            area: None,
            format: PictureFormat::Png,
            backend: app.backend,
        };
        rows.push(contact::row(app, &individual, view).await?);
    }
    Ok(rows)
}

/// The scene with the exposure that the individual has over the whole circle, where exposure is automatic.
async fn exposed(
    app: &App,
    id: SceneId,
    individual: &StoredIndividual,
) -> Result<SceneId, ApiError> {
    let known = app.library.scene(id).await?;
    if known.scene.film.exposure != Exposure::Auto {
        return Ok(id);
    }
    // What lies beyond what a scene may have is black or burnt out either way.
    let ev = circle_ev(app, id, individual).await?.clamp(-EV_MAX, EV_MAX);
    let film = Film { exposure: Exposure::Ev(ev), ..known.scene.film };
    super::scene::store(app, &Scene { film, ..known.scene.clone() }).await
}

/// The exposure that an individual has over the whole light circle of a scene.
pub async fn circle_ev(
    app: &App,
    scene: SceneId,
    individual: &StoredIndividual,
) -> Result<f64, ApiError> {
    let circle = app.library.circle(scene).await?;
    let material = app.library.material(individual.hash).await?;
    app.on_processor(move || circle.common_ev(&material.program)).await
}

/// The pixels of pictures of one size.
async fn pictures(
    app: &App,
    rows: Vec<Arc<PictureRow>>,
    size_px: u32,
) -> Result<Vec<Vec<u8>>, ApiError> {
    let pictures = rows.into_iter().map(|row| async move { app.picture(&row).await });
    let pictures = stream::iter(pictures).buffered(AT_ONCE).try_collect::<Vec<_>>();
    let pictures = limit::in_time(pictures).await?;
    let decode = move || pictures.iter().map(|png| pixels(png, size_px)).collect();
    app.on_processor(decode).await?
}

fn pixels(png: &[u8], size_px: u32) -> Result<Vec<u8>, ApiError> {
    match decode_png(png) {
        Ok((width, height, rgba)) if (width, height) == (size_px, size_px) => Ok(rgba),
        Ok(_) => Err(ApiError::internal("a picture is of another size than was asked for")),
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

fn etag<'a>(kind: &str, delay_ms: u16, rows: impl Iterator<Item = &'a Arc<PictureRow>>) -> String {
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
    fn strip_has_its_pictures_side_by_side() {
        let picture = |value: u8| vec![value; 4 * 2 * 2];
        let png = side_by_side(&[picture(1), picture(2), picture(3)], 2);
        let (width, height, rgba) = decode_png(&png).unwrap();
        assert_eq!((width, height), (6, 2));
        let row: Vec<u8> = rgba[..24].iter().copied().step_by(4).collect();
        assert_eq!(row, [1, 1, 2, 2, 3, 3]);
        assert_eq!(rgba[..24], rgba[24..]);
    }

    #[test]
    fn circle_is_refused_where_it_is_too_large() {
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
