//! Archives: several individuals in several formats as one ZIP file.

pub mod job;
mod kind;
mod plan;
mod zip_file;

use axum::body::Body;
use axum::extract::State;
use axum::response::{IntoResponse, Response};
use brood_protocol::{GenerationId, IndividualId, JobId};
use serde::Deserialize;

use self::kind::Kind;
use self::plan::{Content, Members, Plan};
use self::zip_file::{HEADERS, Stored, zip_file};
use super::picture_query::size;
use crate::extract::Query;
use crate::limit;
use crate::problem::{ApiError, quote};
use crate::state::App;

/// Content of an archive: exactly one of `individuals`, `generation` and `job`.
#[derive(Debug, Clone, Deserialize, utoipa::IntoParams)]
#[into_params(parameter_in = Query)]
#[serde(deny_unknown_fields)]
pub struct ArchiveQuery {
    /// Ids separated by commas, at most 256.
    individuals: Option<String>,
    /// Generation whose children are exported, a whole brood; names of files have their places.
    generation: Option<GenerationId>,
    /// Search whose front is exported; names of files have their ranks, 1 for the best.
    job: Option<JobId>,
    /// Formats separated by commas: `brood`, `png`, `exr`, and names from `GET /v1/exports`;
    /// default `brood,png`.
    formats: Option<String>,
    /// Size of the pictures in pixels: the side of a square, or width and height as in `640x360`;
    /// each side 16 to 2048, default 256. All pictures together may have 2^25 pixels.
    #[param(pattern = "^[0-9]+(x[0-9]+)?$")]
    size: Option<String>,
    /// True to apply the energy limit to exports; default: true for formats that path tracers read,
    /// as in the genome for others.
    energy_limit: Option<bool>,
}

/// Returns individuals as a ZIP file, with pictures in the scenes of their lineages.
///
/// The last entry, `manifest.json`, lists the individuals with their files, the errors of tables
/// that were made, the errors and costs of a search's results, and the formats that a material
/// cannot be exported in, with the reasons. At most 16 of the files may be binary tables
/// (`rgl-bsdf`, `merl`); `POST /v1/exports` makes more.
#[utoipa::path(get, path = "/v1/exports.zip", operation_id = "get_archive", tag = "exports",
    params(ArchiveQuery),
    responses((status = 200, description = "ZIP file of the individuals", content_type = "application/zip")))]
pub async fn get(
    State(app): State<App>,
    Query(query): Query<ArchiveQuery>,
) -> Result<Response, ApiError> {
    let members = members(&query)?;
    let names = query.formats.as_deref().unwrap_or("brood,png").split(',').map(str::trim);
    let kinds = Kind::list(names).map_err(|words| ApiError::bad_parameter("formats", words))?;
    let size_px = size(query.size.as_deref())?;
    let content = Content { kinds, size_px, energy_limit: query.energy_limit };
    let plan = Plan::of(&app, members, &content).await?;
    check_tables(&plan)?;
    Ok((HEADERS, Body::from_stream(zip_file(app, plan, Stored::new()))).into_response())
}

fn members(query: &ArchiveQuery) -> Result<Members, ApiError> {
    match (&query.individuals, query.generation, query.job) {
        (Some(text), None, None) => Ok(Members::Individuals(ids(text)?)),
        (None, Some(id), None) => Ok(Members::Generation(id)),
        (None, None, Some(id)) => Ok(Members::Job(id)),
        _ => Err(ApiError::bad_request(
            "give exactly one of the query parameters `individuals`, `generation` and `job`",
        )),
    }
}

fn ids(text: &str) -> Result<Vec<IndividualId>, ApiError> {
    let mut ids = Vec::new();
    for id in text.split(',') {
        let wrong =
            |_| ApiError::bad_parameter("individuals", format!("{} is not an id", quote(id)));
        let id = id.trim().parse().map_err(wrong)?;
        if !ids.contains(&id) {
            ids.push(id);
        }
    }
    Ok(ids)
}

/// # Errors
/// 422 if there are more tables than are made while a client waits.
fn check_tables(plan: &Plan) -> Result<(), ApiError> {
    let (tables, most) = (plan.tables(), limit::ARCHIVE_TABLES);
    match tables > most {
        true => {
            let words = format!(
                "{tables} tables; an archive has at most {most}, and POST /v1/exports makes more, \
                 as a job"
            );
            Err(ApiError::refused(words))
        }
        false => Ok(()),
    }
}
