//! Exports: an individual as source code for other renderers.

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
use crate::extract::{NoQuery, Path, Query};
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

/// What is exported.
#[derive(Debug, Clone, Copy, Deserialize, utoipa::IntoParams)]
#[into_params(parameter_in = Query)]
#[serde(deny_unknown_fields)]
pub struct ExportQuery {
    /// Whether it reflects no more than it receives; as the genome has it unless asked otherwise.
    energy_limit: Option<bool>,
    /// Texture positions from minus this to this are enough, from 0 to 65504: fewer clamps are needed then.
    uv_within: Option<f32>,
}

/// An individual in one of the formats.
#[utoipa::path(get, path = "/v1/individuals/{id}/exports/{format}", tag = "exports",
    params(("id" = IndividualId, Path),
        ("format" = String, Path, description = "a name that GET /v1/exports lists"), ExportQuery),
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
        return Err(ApiError::bad_parameter("uv_within", "0 to 65504"));
    }
    let is_as_bred = limited == material.genome.is_limited();
    let text = if is_as_bred && material.program.layers().is_empty() {
        export_within(&material.program, format, within)
    } else {
        // A limit is searched for, and models with tables take milliseconds to prepare.
        let print = move || {
            if is_as_bred {
                return export_within(&material.program, format, within);
            }
            let program = express(&material.genome.clone().with_limit(limited));
            export_within(&program, format, within)
        };
        app.on_processor(print).await?
    };
    let etag = format!("\"{}\"", blake3::hash(text.as_bytes()).to_hex());
    let head = FileHead { etag, content_type: format.media_type(), cache: CACHE };
    let mut response = head.answer(&headers, text);
    let name = format!("attachment; filename=\"brood-{id}.{}\"", format.extension());
    let name = HeaderValue::from_str(&name).expect("ids and endings are letters and digits");
    response.headers_mut().insert(header::CONTENT_DISPOSITION, name);
    Ok(response)
}
