//! Exports of individuals and of genomes that are not stored, in the formats of other programs.

mod exported;

use axum::Json;
use axum::body::Body;
use axum::extract::State;
use axum::response::{IntoResponse, Response};
use brood_eval::{express, limited};
use brood_export::{Format, PrintError, Within, export_material, is_limited};
use brood_genome::{GenomeHash, RANGE};
use brood_program::Program;
use brood_protocol::IndividualId;
use http::{HeaderMap, HeaderValue, Request, header};
use serde::Deserialize;

use self::exported::ExportedMaterial;
use super::file::FileHead;
use super::genome;
use crate::extract::{Path, Query, read_upload};
use crate::limit;
use crate::problem::ApiError;
use crate::processors::run_blocking;
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
    /// True if only BRDFs can be exported in the format.
    brdf: bool,
    /// `exact`: code, the same function up to rounding; `table`: numbers between which is
    /// interpolated; `fit`: the nearest of the format's own materials.
    exactness: &'static str,
    /// Error of the format, in words.
    error: &'static str,
    /// Programs that open the format.
    opened_by: &'static str,
    /// Shell commands from nothing to a picture, in which FILE is the name of the file and URL its
    /// address; empty if the format needs a program of the user.
    commands: Vec<&'static str>,
    /// True if path tracers read the format, so that the energy limit is applied by default.
    path_traced: bool,
}

/// Lists the export formats.
#[utoipa::path(get, path = "/v1/exports", operation_id = "list_export_formats", tag = "exports",
    responses((status = 200, description = "export formats", body = Vec<ExportFormat>)))]
pub async fn formats() -> Json<Vec<ExportFormat>> {
    let formats = Format::ALL.into_iter().map(|format| ExportFormat {
        name: format.name(),
        label: format.label(),
        extension: format.extension(),
        media_type: format.media_type(),
        painted: format.is_of_painted(),
        brdf: format.is_of_brdfs(),
        exactness: format.exactness().name(),
        error: format.error(),
        opened_by: format.opened_by(),
        commands: format.commands().to_vec(),
        path_traced: format.is_for_path_tracers(),
    });
    Json(formats.collect())
}

/// Options of an export.
#[derive(Debug, Clone, Copy, Deserialize, utoipa::IntoParams)]
#[into_params(parameter_in = Query)]
#[serde(deny_unknown_fields)]
pub struct ExportQuery {
    /// True to apply the energy limit; default: true for formats that path tracers read, as in the
    /// genome for others.
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

/// Returns a genome in a format of other programs, without storing it.
#[utoipa::path(post, path = "/v1/exports/{format}", operation_id = "export_genome", tag = "exports",
    params(("format" = String, Path, description = "name of a format from `GET /v1/exports`"), ExportQuery),
    request_body(content((serde_json::Value = "application/json"), (String = "text/x-brood"))),
    responses(ExportedMaterial))]
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
    let bytes = move || -> Result<Vec<u8>, ApiError> {
        let genome = genome::parse(&bytes, is_text)?;
        let limited = is_limited(format, query.energy_limit, &genome);
        let program = express(&genome.with_limit(limited));
        made(&program, format, within).map_err(refused)
    };
    let bytes = app.processors.run(bytes).await??;
    let content_type = (header::CONTENT_TYPE, format.media_type());
    Ok(([content_type, (header::CACHE_CONTROL, "no-store")], bytes).into_response())
}

/// Returns the material of a scene's object in a format of other programs.
///
/// Formats that path tracers read have the energy limit.
#[utoipa::path(get, path = "/v1/exports/{format}", operation_id = "export_scene_material", tag = "exports",
    params(("format" = String, Path, description = "name of a format from `GET /v1/exports`"), MaterialQuery),
    responses(ExportedMaterial, (status = 304)))]
pub async fn of_material(
    State(app): State<App>,
    Query(query): Query<MaterialQuery>,
    Path(format): Path<String>,
    headers: HeaderMap,
) -> Result<Response, ApiError> {
    let (format, within) = (parse_format(&format)?, within(query.uv_within, query.lights)?);
    let program = app.library.program_of(query.material.as_deref()).await?;
    let print = move || match format.is_for_path_tracers() {
        true => made(&limited(program), format, within),
        false => made(&program, format, within),
    };
    let (bytes, etag) = app.processors.run(move || print().map(tagged)).await?.map_err(refused)?;
    let head = FileHead { etag, content_type: format.media_type(), cache: CACHE };
    Ok(head.answer(&headers, bytes))
}

/// Returns an individual in a format of other programs.
#[utoipa::path(get, path = "/v1/individuals/{id}/exports/{format}", operation_id = "export_individual", tag = "exports",
    params(("id" = IndividualId, Path),
        ("format" = String, Path, description = "name of a format from `GET /v1/exports`"), ExportQuery),
    responses(ExportedMaterial, (status = 304)))]
pub async fn get(
    State(app): State<App>,
    Query(query): Query<ExportQuery>,
    Path((id, format)): Path<(IndividualId, String)>,
    headers: HeaderMap,
) -> Result<Response, ApiError> {
    let (format, within) = (parse_format(&format)?, query.within()?);
    let individual = app.store.individual(id).await?;
    let bytes = bytes(&app, individual.hash, format, query.energy_limit, within).await?;
    // Tables have up to 52 MB.
    let (bytes, etag) = run_blocking(move || tagged(bytes)).await?;
    let head = FileHead { etag, content_type: format.media_type(), cache: CACHE };
    let mut response = head.answer(&headers, bytes);
    let hash = individual.hash.to_string();
    let name = format.file_name(&format!("brood-{}", &hash[..8]));
    let name = format!("attachment; filename=\"{name}\"");
    let name = HeaderValue::from_str(&name)
        .expect("hashes and endings are letters, digits, dots and dashes");
    response.headers_mut().insert(header::CONTENT_DISPOSITION, name);
    Ok(response)
}

/// Returns a stored genome in a format.
///
/// # Errors
/// [`ApiError`] if the genome cannot be read, or the format cannot carry it.
pub(super) async fn bytes(
    app: &App,
    hash: GenomeHash,
    format: Format,
    energy_limit: Option<bool>,
    within: Within,
) -> Result<Vec<u8>, ApiError> {
    let material = app.library.material(hash).await?;
    let limited = is_limited(format, energy_limit, &material.genome);
    let is_as_bred = limited == material.genome.is_limited();
    let is_fast = !format.is_for_path_tracers() && !format.is_table();
    if is_as_bred && material.program.layers().is_empty() && is_fast {
        return made(&material.program, format, within).map_err(refused);
    }
    // The limit needs a numeric search, models with tables take milliseconds to prepare, and
    // formats for path tracers and tables sample the material.
    let bytes = move || {
        if is_as_bred {
            return made(&material.program, format, within);
        }
        let program = express(&material.genome.clone().with_limit(limited));
        made(&program, format, within)
    };
    app.processors.run(bytes).await?.map_err(refused)
}

/// The file and its ETag.
fn tagged(bytes: Vec<u8>) -> (Vec<u8>, String) {
    let etag = format!("\"{}\"", blake3::hash(&bytes).to_hex());
    (bytes, etag)
}

fn made(program: &Program, format: Format, within: Within) -> Result<Vec<u8>, PrintError> {
    export_material(program, format, within).map(|exported| exported.bytes)
}
