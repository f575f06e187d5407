//! Jobs: state and cost of searches, exports, render jobs and deferred answers.

use axum::Json;
use axum::extract::State;
use axum::response::Response;
use brood_protocol::{AnyJob, ExportAnswer, JobAnswer, JobId, JobStatus};
use brood_storage::StorageError;

use crate::dispatch::{JobState, export_json};
use crate::extract::Path;
use crate::problem::ApiError;
use crate::state::App;

/// Returns a job: a search, an export, a deferred answer, or a render job of a brood's pictures.
///
/// Finished render jobs and deferred answers are kept for a limited time; a restart deletes them.
#[utoipa::path(get, path = "/v1/jobs/{id}", operation_id = "get_job", tag = "jobs",
    params(("id" = JobId, Path)),
    responses((status = 200, description = "search, export, deferred answer or render job", body = AnyJob)))]
pub async fn get(State(app): State<App>, Path(id): Path<JobId>) -> Result<Json<AnyJob>, ApiError> {
    if let Some(answer) = app.deferred.job(id) {
        return Ok(Json(AnyJob::Answer(Box::new(answer))));
    }
    match app.store.islands(id).await {
        Ok(islands) => {
            let answer = super::search::present(&app, islands).await?;
            Ok(Json(AnyJob::Search(Box::new(answer))))
        }
        Err(StorageError::NotFound) => {
            if let Some(answer) = export(&app, id).await? {
                return Ok(Json(AnyJob::Export(Box::new(answer))));
            }
            let answer = render_job(&app, id)?;
            Ok(Json(AnyJob::Render(Box::new(answer))))
        }
        Err(error) => Err(error.into()),
    }
}

/// Returns a deferred answer: the status, headers and body that the request returns without
/// `Prefer`, with `Cache-Control: no-store`.
#[utoipa::path(get, path = "/v1/jobs/{id}/answer", operation_id = "get_deferred_answer", tag = "jobs",
    params(("id" = JobId, Path)),
    responses((status = "2XX", description = "answer of the request", body = Vec<u8>,
        content_type = "*/*")))]
pub async fn answer(State(app): State<App>, Path(id): Path<JobId>) -> Result<Response, ApiError> {
    let words = "there is no deferred answer with this id, or it has expired";
    app.deferred.answer(id).unwrap_or_else(|| Err(ApiError::not_found(words)))
}

async fn export(app: &App, id: JobId) -> Result<Option<ExportAnswer>, ApiError> {
    match app.store.export(id).await {
        Ok(export) => Ok(Some(export_json(export))),
        Err(StorageError::NotFound) => Ok(None),
        Err(error) => Err(error.into()),
    }
}

fn render_job(app: &App, id: JobId) -> Result<JobAnswer, ApiError> {
    let answer = |state, reason| JobAnswer {
        id,
        kind: "render".to_owned(),
        state,
        reason,
        work: None,
        times: None,
    };
    // A job is noted as finished before the queue forgets it.
    if let Some(known) = app.pictures.queue.known(id) {
        let state = match known.state {
            JobState::Queued => JobStatus::Queued,
            JobState::Leased => JobStatus::Running,
            JobState::Failed | JobState::Dead => JobStatus::Failed,
        };
        return Ok(answer(state, known.reason));
    }
    let Some(done) = app.pictures.history.get(id) else {
        let words =
            "there is no job with this id; ended jobs are deleted after a while, and by a restart";
        return Err(ApiError::not_found(words));
    };
    let (work, times) = (Some(done.work), Some(done.times));
    Ok(JobAnswer { work, times, ..answer(JobStatus::Succeeded, None) })
}
