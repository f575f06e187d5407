//! Archives that are made as jobs: request and download.

use axum::body::Body;
use axum::extract::State;
use axum::response::{IntoResponse, Response};
use brood_protocol::{CreateExport, ExportAnswer, JobId, JobStatus};
use brood_storage::{NewExport, NewExportFile, StorageError, StoredExport};
use http::StatusCode;

use super::kind::Kind;
use super::plan::{Content, Members, Plan};
use super::zip_file::{HEADERS, zip_file};
use crate::clock::now_ms;
use crate::controller::accepted;
use crate::controller::picture_query::SIZE;
use crate::dispatch::export_json;
use crate::extract::{Json as JsonBody, Path};
use crate::idempotency::{Attempt, BodyHash, IdempotencyKey};
use crate::limit;
use crate::problem::ApiError;
use crate::state::App;

/// Starts an export: an archive as of `GET /v1/exports.zip` that takes long.
///
/// Follow it by `GET /v1/jobs/{id}` or its events, cancel it by `POST /v1/jobs/{id}/cancel`, and
/// get the file from `archive` of the job. Jobs are deleted with their files a day after they end.
#[utoipa::path(post, path = "/v1/exports", operation_id = "create_export", tag = "exports",
    request_body = CreateExport,
    params(IdempotencyKey),
    responses((status = 202, description = "queued export", body = ExportAnswer,
        headers(("Location" = String, description = "URL of the job")))))]
pub async fn create(
    State(app): State<App>,
    key: IdempotencyKey,
    body: JsonBody<CreateExport>,
) -> Result<Response, ApiError> {
    let hash = BodyHash::of(&body.bytes);
    let make = async |attempt: Attempt| {
        let mut new = read(&app, body.value).await?;
        let stored = as_stored(&new);
        let answer = export_json(stored.clone());
        new.idempotency = attempt.record(StatusCode::ACCEPTED, &answer);
        app.store.create_export(new, limit::QUEUED_EXPORTS).await.map_err(|error| match error {
            StorageError::QueueFull => ApiError::busy("too many exports are queued"),
            other => other.into(),
        })?;
        app.exports.publish_state(&stored);
        app.exports.wake();
        Ok(accepted(&answer))
    };
    app.ledger.once(&app.store, (key, hash), make, async |answer| Ok(accepted(&answer))).await
}

/// Returns the archive of an export that has succeeded, as a ZIP file.
#[utoipa::path(get, path = "/v1/jobs/{id}/archive.zip", operation_id = "get_export_archive", tag = "exports",
    params(("id" = JobId, Path)),
    responses((status = 200, description = "ZIP file of the export", content_type = "application/zip")))]
pub async fn archive(State(app): State<App>, Path(id): Path<JobId>) -> Result<Response, ApiError> {
    let (plan, stored) = app.store.export_plan(id).await?;
    app.exports.check_files(id, &stored).await?;
    let plan: Plan = serde_json::from_str(&plan).map_err(|error| {
        ApiError::internal(format!("the plan of export {id} cannot be read: {error}"))
    })?;
    // What is made while the file is sent must not fail then.
    for (of, _) in plan.files().filter(|(_, file)| file.format.is_picture()) {
        app.library.material(of.hash).await?;
    }
    let stored = stored.into_iter().map(|file| (file.number, (id, file)));
    let body = Body::from_stream(zip_file(app.clone(), plan, stored.collect()));
    Ok((HEADERS, body).into_response())
}

async fn read(app: &App, asked: CreateExport) -> Result<NewExport, ApiError> {
    let members = match (asked.individuals, asked.generation, asked.job) {
        (Some(mut ids), None, None) => {
            let mut seen = std::collections::HashSet::new();
            ids.retain(|id| seen.insert(*id));
            Members::Individuals(ids)
        }
        (None, Some(id), None) => Members::Generation(id),
        (None, None, Some(id)) => Members::Job(id),
        _ => {
            let words = "give exactly one of `individuals`, `generation` and `job`";
            return Err(ApiError::refused(words).at(""));
        }
    };
    let kinds = Kind::list(asked.formats.iter().map(String::as_str))
        .map_err(|words| ApiError::refused(format!("`formats` {words}")).at("/formats"))?;
    let size_px = asked.size.unwrap_or(SIZE.into());
    if !limit::is_size(size_px, limit::PICTURE_PX) {
        let (least, most) = (limit::PICTURE_MIN_PX, limit::PICTURE_PX);
        let words = format!("each side must be {least} to {most} pixels, got {size_px}");
        return Err(ApiError::refused(words).at("/size"));
    }
    let energy_limit = asked.energy_limit;
    let content = Content { kinds, size_px, energy_limit };
    let plan = Plan::of(app, members, &content).await?;
    let (tables, most) = (plan.tables(), limit::EXPORT_TABLES);
    if tables > most {
        return Err(ApiError::refused(format!("{tables} tables; an export has at most {most}")));
    }
    let files = (0..).zip(plan.files()).filter(|(_, (_, file))| !file.format.is_picture());
    let files = files.map(|(number, (of, file))| {
        let format = file.format.to_string();
        NewExportFile { number, genome: of.hash, format }
    });
    let files: Vec<_> = files.collect();
    if files.is_empty() {
        let words = "there is no file for a worker; GET /v1/exports.zip makes pictures";
        return Err(ApiError::refused(words).at("/formats"));
    }
    let plan = serde_json::to_string(&plan).expect("plans are plain data");
    let (id, created_ms) = (JobId::fresh(), now_ms());
    Ok(NewExport { id, energy_limit, files, plan, created_ms, idempotency: None })
}

/// Returns a new export as it is before a worker claims it.
fn as_stored(new: &NewExport) -> StoredExport {
    StoredExport {
        id: new.id,
        state: JobStatus::Queued,
        epoch: 0,
        reason: None,
        files: u32::try_from(new.files.len()).unwrap_or(u32::MAX),
        made: 0,
        bytes: 0,
        created_ms: new.created_ms,
        started_ms: None,
        ended_ms: None,
    }
}
