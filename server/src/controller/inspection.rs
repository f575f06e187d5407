//! Inspections: properties of an individual's genome, and its image slice.

use axum::extract::State;
use axum::response::{IntoResponse, Response};
use brood_eval::encode_png;
use brood_inspect::{Inspection, image_slice};
use brood_protocol::IndividualId;
use http::{HeaderMap, header};
use serde::Deserialize;

use super::file::FileHead;
use crate::extract::{Path, Query};
use crate::limit;
use crate::problem::ApiError;
use crate::state::App;

/// Must be revalidated: the answer depends on the program version.
const CACHE: &str = "private, no-cache";
const SLICE_PX: u32 = 256;

/// Returns an individual's source, live code, counts, physical checks, albedo, and reflectance over
/// planes.
#[utoipa::path(get, path = "/v1/individuals/{id}/inspection", operation_id = "inspect_individual", tag = "individuals",
    params(("id" = IndividualId, Path)),
    responses((status = 200, description = "source, counts and checks of the individual", body = Inspection)))]
pub async fn get(
    State(app): State<App>,
    Path(id): Path<IndividualId>,
) -> Result<Response, ApiError> {
    let individual = app.store.individual(id).await?;
    let hash = individual.hash;
    let inspection = match app.library.known_inspection(hash) {
        Some(inspection) => inspection,
        None => {
            let material = app.library.brdf(hash).await?;
            let library = app.clone();
            app.processors.run(move || library.library.inspect(hash, &material.genome)).await?
        }
    };
    // Serialised directly: through a JSON value, f32 numbers would gain digits.
    let body = serde_json::to_vec(inspection.as_ref()).expect("an inspection is plain data");
    let headers = [(header::CONTENT_TYPE, "application/json"), (header::CACHE_CONTROL, CACHE)];
    Ok((headers, body).into_response())
}

/// Options of an image slice.
#[derive(Debug, Clone, Deserialize, utoipa::IntoParams)]
#[into_params(parameter_in = Query)]
#[serde(deny_unknown_fields)]
pub struct SliceQuery {
    /// Side in pixels, 16 to 2048; default 256.
    #[param(minimum = 16, maximum = 2048)]
    size: Option<u32>,
}

/// Returns the image slice of an individual.
///
/// Half angle from left to right and difference angle from bottom to top, both 0 to 90 degrees.
#[utoipa::path(get, path = "/v1/individuals/{id}/slice.png", operation_id = "get_slice", tag = "pictures",
    params(("id" = IndividualId, Path), SliceQuery),
    responses((status = 200, description = "image slice as PNG", content_type = "image/png"),
        (status = 304)))]
pub async fn slice(
    State(app): State<App>,
    Path(id): Path<IndividualId>,
    Query(query): Query<SliceQuery>,
    headers: HeaderMap,
) -> Result<Response, ApiError> {
    let size_px = limit::side(query.size.unwrap_or(SLICE_PX), limit::PICTURE_PX)?;
    let individual = app.store.individual(id).await?;
    let material = app.library.brdf(individual.hash).await?;
    let version = env!("CARGO_PKG_VERSION");
    let etag = format!("\"{}-{size_px}-{version}\"", material.program.hash());
    let head = FileHead { etag, content_type: "image/png", cache: CACHE };
    let draw = move || {
        let slice = image_slice(&material.program, size_px);
        encode_png(slice.size_px, slice.size_px, &slice.rgba)
    };
    head.made(&headers, app.processors.run(draw)).await
}
