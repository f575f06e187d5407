//! Exports of individuals as source code for other renderers.

use axum::Json;
use axum::extract::State;
use axum::response::Response;
use brood_eval::express;
use brood_export::{Format, export_within};
use brood_genome::RANGE;
use brood_protocol::IndividualId;
use http::{HeaderMap, HeaderValue, header};
use serde::Deserialize;

use super::file::FileHead;
use crate::extract::{Path, Query};
use crate::problem::ApiError;
use crate::state::App;

/// Must be revalidated: the exported text depends on the program version.
const CACHE: &str = "private, no-cache";

/// Export format.
#[derive(Debug, Clone, serde::Serialize, utoipa::ToSchema)]
pub struct ExportFormat {
    /// Name used in URLs.
    name: &'static str,
    /// Name for people.
    label: &'static str,
    /// Ending of file names, without the first dot.
    extension: &'static str,
    /// Media type of the file.
    media_type: &'static str,
}

/// Lists the export formats.
#[utoipa::path(get, path = "/v1/exports", tag = "exports",
    responses((status = 200, body = Vec<ExportFormat>)))]
pub async fn formats() -> Json<Vec<ExportFormat>> {
    let formats = Format::ALL.into_iter().map(|format| ExportFormat {
        name: format.name(),
        label: format.label(),
        extension: format.extension(),
        media_type: format.media_type(),
    });
    Json(formats.collect())
}

/// Options of an export.
#[derive(Debug, Clone, Copy, Deserialize, utoipa::IntoParams)]
#[into_params(parameter_in = Query)]
#[serde(deny_unknown_fields)]
pub struct ExportQuery {
    /// True to apply the energy limit; default: as in the genome.
    energy_limit: Option<bool>,
    /// Largest absolute texture coordinate that the code must handle, 0 to 65504; smaller ranges
    /// need fewer clamps.
    uv_within: Option<f32>,
}

/// Returns an individual as source code.
#[utoipa::path(get, path = "/v1/individuals/{id}/exports/{format}", tag = "exports",
    params(("id" = IndividualId, Path),
        ("format" = String, Path, description = "name of a format from `GET /v1/exports`"), ExportQuery),
    responses((status = 200, content_type = "text/plain"), (status = 304, description = "unchanged")))]
pub async fn get(
    State(app): State<App>,
    Query(query): Query<ExportQuery>,
    Path((id, format)): Path<(IndividualId, String)>,
    headers: HeaderMap,
) -> Result<Response, ApiError> {
    let format: Format = format.parse().map_err(|error| ApiError::not_found(format!("{error}")))?;
    let individual = app.store.individual(id).await?;
    let material = app.library.material(individual.hash).await?;
    let limited = query.energy_limit.unwrap_or(material.genome.is_limited());
    let within = query.uv_within.unwrap_or(RANGE);
    if !(0.0..=RANGE).contains(&within) {
        return Err(ApiError::bad_parameter("uv_within", "must be 0 to 65504"));
    }
    let is_as_bred = limited == material.genome.is_limited();
    let text = if is_as_bred && material.program.layers().is_empty() {
        export_within(&material.program, format, within)
    } else {
        // The limit needs a numeric search, and models with tables take milliseconds to prepare.
        let print = move || {
            if is_as_bred {
                return export_within(&material.program, format, within);
            }
            let program = express(&material.genome.clone().with_limit(limited));
            export_within(&program, format, within)
        };
        app.processors.run(print).await?
    };
    let etag = format!("\"{}\"", blake3::hash(text.as_bytes()).to_hex());
    let head = FileHead { etag, content_type: format.media_type(), cache: CACHE };
    let mut response = head.answer(&headers, text);
    let hash = individual.hash.to_string();
    let name = format!("attachment; filename=\"brood-{}.{}\"", &hash[..8], format.extension());
    let name =
        HeaderValue::from_str(&name).expect("hashes and endings are letters, digits and dots");
    response.headers_mut().insert(header::CONTENT_DISPOSITION, name);
    Ok(response)
}
