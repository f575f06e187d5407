//! Exports: an individual as source code for other renderers.

use axum::Json;
use axum::extract::State;
use axum::response::Response;
use brood_export::{Format, export};
use brood_protocol::IndividualId;
use http::{HeaderMap, HeaderValue, header};

use super::file;
use crate::extract::{NoQuery, Path};
use crate::problem::ApiError;
use crate::state::App;

/// An individual never changes; what it is printed as does with the version of the program.
const CACHE: &str = "private, no-cache";

/// A format that there is.
#[derive(Debug, Clone, serde::Serialize, utoipa::ToSchema)]
pub struct ExportFormat {
    /// As addresses name it.
    name: &'static str,
    /// What it is.
    label: &'static str,
    /// Ending of a file's name.
    extension: &'static str,
    /// Its media type.
    media_type: &'static str,
}

/// The formats that materials can be exported as.
#[utoipa::path(get, path = "/v1/exports", tag = "exports",
    responses((status = 200, body = Vec<ExportFormat>)))]
pub async fn formats(NoQuery: NoQuery) -> Json<Vec<ExportFormat>> {
    let formats = Format::ALL.into_iter().map(|format| ExportFormat {
        name: format.name(),
        label: format.label(),
        extension: format.extension(),
        media_type: format.media_type(),
    });
    Json(formats.collect())
}

/// An individual in one of the formats.
#[utoipa::path(get, path = "/v1/individuals/{id}/exports/{format}", tag = "exports",
    params(("id" = IndividualId, Path),
        ("format" = String, Path, description = "a name that GET /v1/exports lists")),
    responses((status = 200, content_type = "text/plain"), (status = 304, description = "unchanged")))]
pub async fn get(
    State(app): State<App>,
    NoQuery: NoQuery,
    Path((id, format)): Path<(IndividualId, String)>,
    headers: HeaderMap,
) -> Result<Response, ApiError> {
    let format: Format = format.parse().map_err(|error| ApiError::not_found(format!("{error}")))?;
    let individual = app.store.individual(id).await?;
    let material = app.library.material(individual.hash).await?;
    let text = export(&material.program, format);
    let etag = format!("\"{}\"", blake3::hash(text.as_bytes()).to_hex());
    let mut response = file(&headers, &etag, format.media_type(), CACHE, text);
    let name = format!("attachment; filename=\"brood-{id}.{}\"", format.extension());
    let name = HeaderValue::from_str(&name).expect("ids and endings are letters and digits");
    response.headers_mut().insert(header::CONTENT_DISPOSITION, name);
    Ok(response)
}
