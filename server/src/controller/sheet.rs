//! Contact sheets, composed from pictures that are there or are waited for.

use std::sync::Arc;

use axum::extract::State;
use axum::response::Response;
use brood_eval::{SheetCell, centre_px, decode_png, encode_png, sheet};
use brood_protocol::{GenerationId, IndividualId, LineageId};
use brood_storage::{PictureRow, StoredIndividual};
use futures::stream::{self, StreamExt};
use http::HeaderMap;
use serde::Deserialize;

use super::file::FileHead;
use crate::extract::{NoQuery, Path, Query};
use crate::library::View;
use crate::limit;
use crate::presenter::thumbnail_view;
use crate::problem::{ApiError, quote};
use crate::state::App;

const CACHE: &str = "private, no-cache";
/// Children that stand around a centre.
const AROUND: usize = 20;
/// Pictures of a sheet that are asked for at a time: enough for a job, few enough to be held.
const AT_ONCE: usize = 32;
/// Cells of the side of a sheet with a centre.
const RING: u32 = 6;

/// A generation: 6 x 6 around the centre where it has twenty children, else near-square.
#[utoipa::path(get, path = "/v1/generations/{id}/sheet.png", tag = "pictures",
    params(("id" = GenerationId, Path)),
    responses((status = 200, content_type = "image/png"), (status = 304, description = "unchanged")))]
pub async fn generation(
    State(app): State<App>,
    NoQuery: NoQuery,
    Path(id): Path<GenerationId>,
    headers: HeaderMap,
) -> Result<Response, ApiError> {
    let generation = app.store.generation(id).await?;
    let around = generation.individuals.len() == AROUND;
    let centre = generation.centre.or_else(|| generation.individuals.first().cloned());
    let centre = centre.filter(|_| around);
    // The centre is shown in this lineage's scene, wherever it was born.
    let centre = centre.map(|one| StoredIndividual { lineage: generation.lineage, ..one });
    compose(&app, &headers, generation.individuals, centre).await
}

/// Which individuals.
#[derive(Debug, Clone, Deserialize, utoipa::IntoParams)]
#[into_params(parameter_in = Query)]
#[serde(deny_unknown_fields)]
pub struct SheetQuery {
    /// Ids with commas between them, up to 256.
    individuals: String,
}

/// Any individuals, near-square, each in its lineage's scene.
#[utoipa::path(get, path = "/v1/sheet.png", tag = "pictures", params(SheetQuery),
    responses((status = 200, content_type = "image/png"), (status = 304, description = "unchanged")))]
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
        let words = format!("at most {}", limit::SHEET_CELLS);
        return Err(ApiError::bad_parameter("individuals", words));
    }
    let individuals = app.store.individuals(&ids).await?;
    compose(&app, &headers, individuals, None).await
}

async fn compose(
    app: &App,
    headers: &HeaderMap,
    individuals: Vec<StoredIndividual>,
    centre: Option<StoredIndividual>,
) -> Result<Response, ApiError> {
    let mut lineages: Vec<(LineageId, View)> = Vec::new();
    for one in individuals.iter().chain(&centre) {
        if !lineages.iter().any(|(id, _)| *id == one.lineage) {
            let lineage = app.store.lineage(one.lineage).await?;
            lineages.push((lineage.id, thumbnail_view(app, &lineage)));
        }
    }
    let count = u32::try_from(individuals.len()).expect("a sheet has few cells");
    let columns = if centre.is_some() { RING } else { count.isqrt() + 1 };
    let largest = lineages.iter().map(|(_, view)| view.size_px).max().unwrap_or(1);
    let cell_px = largest.min(limit::SHEET_PX / columns.max(1));
    let gap_px = (cell_px / 32).max(1);

    let mut rows = Vec::with_capacity(individuals.len() + 1);
    for one in individuals.iter().chain(&centre) {
        let (_, view) = lineages.iter().find(|(id, _)| *id == one.lineage).expect("read above");
        let is_centre = rows.len() == individuals.len();
        let size_px = match is_centre {
            true => centre_px(cell_px, gap_px).clamp(limit::PICTURE_MIN_PX, limit::PICTURE_PX),
            false => view.size_px,
        };
        rows.push(row(app, one, View { size_px, ..*view }).await?);
    }
    let mut hasher = blake3::Hasher::new();
    hasher.update(&[u8::from(centre.is_some())]);
    rows.iter().for_each(|row| {
        hasher.update(&row.key.0);
    });
    let etag = format!("\"{}\"", hasher.finalize().to_hex());
    let head = FileHead { etag, content_type: "image/png", cache: CACHE };
    let has_centre = centre.is_some();
    let make = async {
        let small = collect(app, rows, has_centre.then(|| centre_px(cell_px, gap_px)), cell_px);
        let small = limit::in_time(small).await?;
        app.on_processor(move || draw(small, has_centre, cell_px, gap_px)).await
    };
    head.made(headers, make).await
}

/// The pictures in the size of their places, a few of them under way at a time.
pub(super) async fn collect(
    app: &App,
    rows: Vec<Arc<PictureRow>>,
    centre_px: Option<u32>,
    cell_px: u32,
) -> Result<Vec<(u32, u32, Vec<u8>)>, ApiError> {
    let count = rows.len();
    let pictures = rows.into_iter().map(|row| {
        let app = app.clone();
        async move { app.picture(&row).await }
    });
    let mut pictures = stream::iter(pictures).buffered(AT_ONCE);
    let mut small = Vec::with_capacity(count);
    while let Some(png) = pictures.next().await {
        let png = png?;
        let side = centre_px.filter(|_| small.len() + 1 == count).unwrap_or(cell_px);
        small.push(app.on_processor(move || scale(&png, side)).await??);
    }
    Ok(small)
}

pub(super) async fn row(
    app: &App,
    one: &StoredIndividual,
    view: View,
) -> Result<Arc<PictureRow>, ApiError> {
    let framed = app.library.frame(view).await?;
    let key = framed.key(brood_program::ProgramHash::from_bytes(one.program_hash));
    app.announce(framed.row(key, one.hash)).await
}

/// A picture in the size of its place, so that no more than one is ever held in its own size.
fn scale(png: &[u8], side: u32) -> Result<(u32, u32, Vec<u8>), ApiError> {
    let (width, height, rgba) = decode_png(png)
        .map_err(|error| ApiError::internal(format!("a picture cannot be decoded: {error}")))?;
    Ok(sheet(&[SheetCell { width, height, rgba: &rgba }], None, side, 0))
}

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
    fn sheet_is_the_same_when_its_cells_were_scaled_before() {
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
