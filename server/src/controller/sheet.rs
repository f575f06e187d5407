//! Contact sheets, composed of cached pictures and pictures still being rendered.

use std::sync::Arc;

use axum::extract::State;
use axum::response::Response;
use brood_eval::{SheetCell, centre_px, decode_png, encode_png, sheet};
use brood_protocol::{GenerationId, IndividualId, LineageId, SceneId};
use brood_storage::{StoredIndividual, StoredPicture};
use futures::stream::{self, StreamExt};
use http::HeaderMap;
use serde::Deserialize;

use super::file::{FileHead, REVALIDATED};
use super::picture_query::check_light;
use crate::deferred::{AnswerProgress, in_time};
use crate::dispatch::queue_for;
use crate::extract::{Path, Query};
use crate::library::Framing;
use crate::limit;
use crate::problem::{ApiError, quote};
use crate::state::App;

/// Number of children around a centre.
const AROUND: usize = 20;
/// Number of pictures requested at a time: enough for one job, few enough to hold in memory.
const AT_ONCE: usize = 32;
/// Cells along one side of a sheet with a centre.
const RING: u32 = 6;

/// Scene and light of a generation's sheet.
#[derive(Debug, Clone, Copy, Default, Deserialize, utoipa::IntoParams)]
#[into_params(parameter_in = Query)]
#[serde(deny_unknown_fields)]
pub struct SheetView {
    /// Scene to render; default: the lineage's scene.
    scene: Option<SceneId>,
    /// Angle of the lights on their circle in degrees; default: the scene's.
    light_deg: Option<f64>,
}

/// Returns a generation's contact sheet: 6 x 6 around the centre for 20 children, near-square for
/// other numbers.
#[utoipa::path(get, path = "/v1/generations/{id}/sheet.png", operation_id = "get_sheet", tag = "pictures",
    params(("id" = GenerationId, Path), SheetView),
    responses((status = 200, description = "contact sheet as PNG", content_type = "image/png"),
        (status = 304)))]
pub async fn generation(
    State(app): State<App>,
    Path(id): Path<GenerationId>,
    Query(view): Query<SheetView>,
    headers: HeaderMap,
) -> Result<Response, ApiError> {
    check_light(view.light_deg)?;
    let generation = app.store.generation(id).await?;
    let around = generation.individuals.len() == AROUND;
    let centre = generation.centre.or_else(|| generation.individuals.first().cloned());
    let centre = centre.filter(|_| around);
    // The centre is shown in this lineage's scene, even if it belongs to another lineage.
    let centre = centre.map(|one| StoredIndividual { lineage: generation.lineage, ..one });
    compose(&app, &headers, generation.individuals, centre, view).await
}

/// Individuals of a sheet.
#[derive(Debug, Clone, Deserialize, utoipa::IntoParams)]
#[into_params(parameter_in = Query)]
#[serde(deny_unknown_fields)]
pub struct SheetQuery {
    /// Ids separated by commas, at most 256.
    individuals: String,
}

/// Returns a near-square contact sheet of any individuals, each in its lineage's scene.
#[utoipa::path(get, path = "/v1/sheet.png", operation_id = "get_sheet_of_individuals", tag = "pictures",
    params(SheetQuery),
    responses((status = 200, description = "contact sheet as PNG", content_type = "image/png"),
        (status = 304)))]
pub async fn individuals(
    State(app): State<App>,
    Query(query): Query<SheetQuery>,
    headers: HeaderMap,
) -> Result<Response, ApiError> {
    let ids: Vec<IndividualId> = query
        .individuals
        .split(',')
        .map(|id| {
            let words = || format!("{} is not an id", quote(id));
            id.trim().parse().map_err(|_| ApiError::bad_parameter("individuals", words()))
        })
        .collect::<Result<_, _>>()?;
    if ids.len() > limit::SHEET_CELLS {
        let words = format!("must have at most {} ids", limit::SHEET_CELLS);
        return Err(ApiError::bad_parameter("individuals", words));
    }
    let individuals = app.store.individuals(&ids).await?;
    compose(&app, &headers, individuals, None, SheetView::default()).await
}

async fn compose(
    app: &App,
    headers: &HeaderMap,
    individuals: Vec<StoredIndividual>,
    centre: Option<StoredIndividual>,
    SheetView { scene, light_deg }: SheetView,
) -> Result<Response, ApiError> {
    let mut lineages: Vec<(LineageId, Framing)> = Vec::new();
    for one in individuals.iter().chain(&centre) {
        if !lineages.iter().any(|(id, _)| *id == one.lineage) {
            let lineage = app.store.lineage(one.lineage).await?;
            let view = Framing::thumbnail(app.backend, &lineage);
            let scene = scene.unwrap_or(view.scene);
            lineages.push((lineage.id, Framing { scene, light_deg, ..view }));
        }
    }
    let count = u32::try_from(individuals.len()).expect("a sheet has few cells");
    let columns = if centre.is_some() { RING } else { count.isqrt() + 1 };
    let largest = lineages.iter().map(|(_, view)| view.size_px.longer()).max().unwrap_or(1);
    let cell_px = largest.min(limit::SHEET_PX / columns.max(1));
    let gap_px = (cell_px / 32).max(1);

    let mut rows = Vec::with_capacity(individuals.len() + 1);
    for one in individuals.iter().chain(&centre) {
        let (_, view) = lineages.iter().find(|(id, _)| *id == one.lineage).expect("read above");
        let is_centre = rows.len() == individuals.len();
        let size_px = match is_centre {
            true => {
                let side = centre_px(cell_px, gap_px);
                side.clamp(limit::PICTURE_MIN_PX, limit::PICTURE_PX).into()
            }
            false => view.size_px,
        };
        rows.push(row(app, one, Framing { size_px, ..*view }).await?);
    }
    let mut hasher = blake3::Hasher::new();
    hasher.update(&[u8::from(centre.is_some())]);
    rows.iter().for_each(|row| {
        hasher.update(&row.key.0);
    });
    let etag = format!("\"{}\"", hasher.finalize().to_hex());
    let head = FileHead { etag, content_type: "image/png", cache: REVALIDATED };
    let has_centre = centre.is_some();
    let make = async {
        AnswerProgress::expect(rows.len());
        let small = collect(app, rows, has_centre.then(|| centre_px(cell_px, gap_px)), cell_px);
        let small = in_time(small).await?;
        app.processors.run(move || draw(small, has_centre, cell_px, gap_px)).await
    };
    head.made(headers, make).await
}

/// Returns the pictures scaled to their cells, requesting [`AT_ONCE`] of them at a time.
///
/// # Errors
/// [`ApiError`] if a picture cannot be rendered or decoded.
pub(super) async fn collect(
    app: &App,
    rows: Vec<Arc<StoredPicture>>,
    centre_px: Option<u32>,
    cell_px: u32,
) -> Result<Vec<(u32, u32, Vec<u8>)>, ApiError> {
    let count = rows.len();
    let queue = queue_for(count as u64 * u64::from(cell_px).pow(2));
    let pictures = rows.into_iter().map(|row| {
        let app = app.clone();
        async move { app.pictures.get_from(queue, &row).await }
    });
    let mut pictures = stream::iter(pictures).buffered(AT_ONCE);
    let mut small = Vec::with_capacity(count);
    while let Some(png) = pictures.next().await {
        let png = png?;
        let side = centre_px.filter(|_| small.len() + 1 == count).unwrap_or(cell_px);
        small.push(app.processors.run(move || scale(&png, side)).await??);
    }
    Ok(small)
}

/// Stores and returns the picture row of an individual in a view.
///
/// # Errors
/// [`ApiError`] if the scene cannot be read or the store fails.
pub(super) async fn row(
    app: &App,
    one: &StoredIndividual,
    view: Framing,
) -> Result<Arc<StoredPicture>, ApiError> {
    let program = brood_program::ProgramHash::from_bytes(one.program_hash);
    app.pictures.row_in(view, one.hash, program).await
}

/// Scales a picture to its cell. At most one picture at a time is held in its full size.
fn scale(png: &[u8], side: u32) -> Result<(u32, u32, Vec<u8>), ApiError> {
    let (width, height, rgba) = decode_png(png)
        .map_err(|error| ApiError::internal(format!("a picture cannot be decoded: {error}")))?;
    Ok(sheet(&[SheetCell { width, height, rgba: &rgba }], None, side, 0))
}

/// Composes scaled pictures into a sheet; the last one is the centre if `has_centre`.
pub(super) fn draw(
    pictures: Vec<(u32, u32, Vec<u8>)>,
    has_centre: bool,
    cell_px: u32,
    gap_px: u32,
) -> Vec<u8> {
    let mut cells: Vec<_> = pictures
        .iter()
        .map(|(width, height, rgba)| SheetCell { width: *width, height: *height, rgba })
        .collect();
    let centre = if has_centre { cells.pop() } else { None };
    let (width, height, rgba) = sheet(&cells, centre, cell_px, gap_px);
    drop(pictures);
    encode_png(width, height, &rgba)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sheet_is_unchanged_when_its_cells_are_scaled_first() {
        let (cell_px, gap_px) = (11, 2);
        let pictures: Vec<(u32, u32, Vec<u8>)> = (0..21u32)
            .map(|k| {
                let side = if k == 20 { 64 } else { 20 + k };
                let bytes = (0..4 * side * side).map(|at| ((at * 7919 + k * 31) % 251) as u8);
                (side, side, bytes.collect())
            })
            .collect();
        for has_centre in [true, false] {
            let scaled = pictures.iter().enumerate().map(|(k, (width, height, rgba))| {
                let is_centre = has_centre && k == 20;
                let side = if is_centre { centre_px(cell_px, gap_px) } else { cell_px };
                scale(&encode_png(*width, *height, rgba), side).unwrap()
            });
            let scaled = scaled.collect();
            let whole = draw(pictures.clone(), has_centre, cell_px, gap_px);
            assert_eq!(draw(scaled, has_centre, cell_px, gap_px), whole);
        }
    }
}
