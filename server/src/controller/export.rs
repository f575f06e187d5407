//! Exports of individuals and of genomes that are not stored, as source code for other renderers.

use axum::Json;
use axum::body::Body;
use axum::extract::State;
use axum::response::{IntoResponse, Response};
use brood_eval::express;
use brood_export::{Format, PrintError, Within};
use brood_genome::{GenomeHash, RANGE};
use brood_protocol::IndividualId;
use http::{HeaderMap, HeaderValue, Request, header};
use serde::Deserialize;

use super::file::FileHead;
use super::genome;
use crate::extract::{Path, Query, read_upload};
use crate::limit;
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
    /// True if only painted materials can be exported in the format.
    painted: bool,
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
        painted: format.is_of_painted(),
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
    /// Number of lights of the function of a painted material, 1 to 8; default 1.
    lights: Option<usize>,
}

impl ExportQuery {
    fn within(&self) -> Result<Within, ApiError> {
        within(self.uv_within, self.lights)
    }
}

/// Options of the export of an object's material.
#[derive(Debug, Clone, Deserialize, utoipa::IntoParams)]
#[into_params(parameter_in = Query)]
#[serde(deny_unknown_fields)]
pub struct MaterialQuery {
    /// Material as in the objects of scenes: the hash of a stored genome, or the name of a preset;
    /// default: neutral grey.
    material: Option<String>,
    /// Largest absolute texture coordinate that the code must handle, 0 to 65504.
    uv_within: Option<f32>,
    /// Number of lights of the function of a painted material, 1 to 8; default 1.
    lights: Option<usize>,
}

/// Returns what the code must handle.
fn within(uv: Option<f32>, lights: Option<usize>) -> Result<Within, ApiError> {
    let uv = uv.unwrap_or(RANGE);
    if !(0.0..=RANGE).contains(&uv) {
        return Err(ApiError::bad_parameter("uv_within", "must be 0 to 65504"));
    }
    Ok(Within { uv, lights: lights.unwrap_or(1) })
}

fn parse_format(name: &str) -> Result<Format, ApiError> {
    name.parse().map_err(|error| ApiError::not_found(format!("{error}")))
}

fn refused(error: PrintError) -> ApiError {
    match error {
        PrintError::Lights(_) => ApiError::bad_parameter("lights", "must be 1 to 8"),
        _ => ApiError::refused(error.to_string()),
    }
}

/// Returns a genome as source code, without storing it.
#[utoipa::path(post, path = "/v1/exports/{format}", tag = "exports",
    params(("format" = String, Path, description = "name of a format from `GET /v1/exports`"), ExportQuery),
    request_body(content((serde_json::Value = "application/json"), (String = "text/x-brood"))),
    responses((status = 200, content_type = "text/plain")))]
pub async fn print(
    State(app): State<App>,
    Query(query): Query<ExportQuery>,
    Path(format): Path<String>,
    request: Request<Body>,
) -> Result<Response, ApiError> {
    let (format, within) = (parse_format(&format)?, query.within()?);
    let types = ["application/json", genome::TEXT];
    let (content_type, bytes) = read_upload(request, &types, limit::JSON_BYTES).await?;
    let is_text = content_type.is(genome::TEXT);
    let text = move || -> Result<String, ApiError> {
        let genome = genome::parse(&bytes, is_text)?;
        let limited = query.energy_limit.unwrap_or(genome.is_limited());
        let program = express(&genome.with_limit(limited));
        brood_export::print(&program, format, within).map_err(refused)
    };
    let text = app.processors.run(text).await??;
    let content_type = (header::CONTENT_TYPE, format.media_type());
    Ok(([content_type, (header::CACHE_CONTROL, "no-store")], text).into_response())
}

/// Returns the material of a scene's object as source code.
#[utoipa::path(get, path = "/v1/exports/{format}", tag = "exports",
    params(("format" = String, Path, description = "name of a format from `GET /v1/exports`"), MaterialQuery),
    responses((status = 200, content_type = "text/plain"), (status = 304, description = "unchanged")))]
pub async fn of_material(
    State(app): State<App>,
    Query(query): Query<MaterialQuery>,
    Path(format): Path<String>,
    headers: HeaderMap,
) -> Result<Response, ApiError> {
    let (format, within) = (parse_format(&format)?, within(query.uv_within, query.lights)?);
    let program = app.library.program_of(query.material.as_deref()).await?;
    let print = move || brood_export::print(&program, format, within);
    let text = app.processors.run(print).await?.map_err(refused)?;
    let etag = format!("\"{}\"", blake3::hash(text.as_bytes()).to_hex());
    let head = FileHead { etag, content_type: format.media_type(), cache: CACHE };
    Ok(head.answer(&headers, text))
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
    let (format, within) = (parse_format(&format)?, query.within()?);
    let individual = app.store.individual(id).await?;
    let text = text(&app, individual.hash, format, query.energy_limit, within).await?;
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

/// Returns a stored genome as source code.
///
/// # Errors
/// [`ApiError`] if the genome cannot be read, or the format cannot carry it.
pub(super) async fn text(
    app: &App,
    hash: GenomeHash,
    format: Format,
    energy_limit: Option<bool>,
    within: Within,
) -> Result<String, ApiError> {
    let material = app.library.material(hash).await?;
    let limited = energy_limit.unwrap_or(material.genome.is_limited());
    let is_as_bred = limited == material.genome.is_limited();
    if is_as_bred && material.program.layers().is_empty() {
        return brood_export::print(&material.program, format, within).map_err(refused);
    }
    // The limit needs a numeric search, and models with tables take milliseconds to prepare.
    let text = move || {
        if is_as_bred {
            return brood_export::print(&material.program, format, within);
        }
        let program = express(&material.genome.clone().with_limit(limited));
        brood_export::print(&program, format, within)
    };
    app.processors.run(text).await?.map_err(refused)
}
