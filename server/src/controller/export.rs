//! Exports of individuals and of genomes that are not stored, in the formats of other programs.

mod exported;

use std::sync::Arc;

use axum::Json;
use axum::body::Body;
use axum::extract::State;
use axum::response::{IntoResponse, Response};
use brood_export::{
    Exported, Format, PrintError, Within, export_genome, export_material, is_limited,
};
use brood_genome::RANGE;
use brood_protocol::IndividualId;
use http::{HeaderMap, HeaderName, HeaderValue, Request, header};
use serde::Deserialize;

use self::exported::ExportedMaterial;
use super::file::FileHead;
use super::genome;
use crate::extract::{Path, Query, read_upload};
use crate::library::Material;
use crate::limit;
use crate::problem::ApiError;
use crate::processors::run_blocking;
use crate::state::App;

/// Must be revalidated: the exported text depends on the program version.
const CACHE: &str = "private, no-cache";
/// Header with the note of a table.
const NOTE: HeaderName = HeaderName::from_static("brood-note");

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
    #[param(minimum = 0, maximum = 65_504)]
    uv_within: Option<f32>,
    /// Number of lights of the function of a painted material, 1 to 8; default 1.
    #[param(minimum = 1, maximum = 8)]
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
    /// True to apply the energy limit; default: true for formats that path tracers read, as in the
    /// genome for others.
    energy_limit: Option<bool>,
    /// Largest absolute texture coordinate that the code must handle, 0 to 65504.
    #[param(minimum = 0, maximum = 65_504)]
    uv_within: Option<f32>,
    /// Number of lights of the function of a painted material, 1 to 8; default 1.
    #[param(minimum = 1, maximum = 8)]
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
    let made = move || -> Result<Exported, ApiError> {
        let genome = genome::parse(&bytes, is_text)?;
        export_genome(&genome, format, query.energy_limit, within).map_err(refused)
    };
    let made = app.processors.run(made).await??;
    let content_type = (header::CONTENT_TYPE, format.media_type());
    let headers = [content_type, (header::CACHE_CONTROL, "no-store")];
    Ok(noted((headers, made.bytes).into_response(), made.note.as_deref()))
}

/// Returns the material of a scene's object in a format of other programs.
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
    let material = app.library.material_of(query.material.as_deref()).await?;
    let made = exported(&app, material, format, query.energy_limit, within).await?;
    answer(&headers, format, made).await
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
    let material = app.library.material(individual.hash).await?;
    let made = exported(&app, material, format, query.energy_limit, within).await?;
    let mut response = answer(&headers, format, made).await?;
    let hash = individual.hash.to_string();
    let name = format.file_name(&format!("brood-{}", &hash[..8]));
    let name = format!("attachment; filename=\"{name}\"");
    let name = HeaderValue::from_str(&name)
        .expect("hashes and endings are letters, digits, dots and dashes");
    response.headers_mut().insert(header::CONTENT_DISPOSITION, name);
    Ok(response)
}

/// Returns a material in a format.
///
/// # Errors
/// [`ApiError`] if the format cannot carry the material.
pub(super) async fn exported(
    app: &App,
    material: Arc<Material>,
    format: Format,
    energy_limit: Option<bool>,
    within: Within,
) -> Result<Exported, ApiError> {
    let limited = is_limited(format, energy_limit, &material.genome);
    let is_as_bred = limited == material.genome.is_limited();
    let is_fast = !format.is_for_path_tracers() && !format.is_table() && !format.is_fit();
    if is_as_bred && material.program.layers().is_empty() && is_fast {
        return export_material(&material.program, format, within).map_err(refused);
    }
    // The limit needs a numeric search, models with tables take milliseconds to prepare, and
    // formats for path tracers, tables and fits sample the material.
    let made = move || match is_as_bred {
        true => export_material(&material.program, format, within),
        false => export_genome(&material.genome, format, Some(limited), within),
    };
    app.processors.run(made).await?.map_err(refused)
}

/// Returns the file, or 304 if the client has it.
async fn answer(headers: &HeaderMap, format: Format, made: Exported) -> Result<Response, ApiError> {
    let Exported { bytes, note } = made;
    // Tables have up to 52 MB.
    let (bytes, etag) = run_blocking(move || {
        let etag = format!("\"{}\"", blake3::hash(&bytes).to_hex());
        (bytes, etag)
    })
    .await?;
    let head = FileHead { etag, content_type: format.media_type(), cache: CACHE };
    Ok(noted(head.answer(headers, bytes), note.as_deref()))
}

/// Adds what is to be said of a made table. Notes are ASCII.
fn noted(mut response: Response, note: Option<&str>) -> Response {
    if let Some(note) = note.and_then(|note| HeaderValue::from_str(note).ok()) {
        response.headers_mut().insert(NOTE, note);
    }
    response
}
