//! Targets of searches: uploaded, listed, read, deleted. Nothing is kept that a search could not begin with.

use axum::Json;
use axum::body::Body;
use axum::extract::State;
use axum::response::{IntoResponse, Response};
use brood_protocol::{Page, Target, TargetId, TargetSpec, TargetUpload};
use brood_search::{TargetFile, TargetFileError, TargetKind};
use brood_storage::NewTarget;
use http::{Request, StatusCode};
use tokio::sync::Semaphore;

use super::{check_length, created};
use crate::extract::{
    NoQuery, PageQuery, Path, Query, multipart_boundary, multipart_parts, page, parse_json,
    read_body,
};
use crate::idempotency::{Begun, IdempotencyKey};
use crate::limit;
use crate::problem::ApiError;
use crate::state::{App, now_ms};

const COLLECTION: &str = "/v1/targets";
/// Files that are read at once: reading takes several times a file's memory.
static READERS: Semaphore = Semaphore::const_new(2);
/// Longest reason that an unreadable file is refused with: names of its fields may stand in it.
const REASON_CHARS: usize = 160;

/// Takes a target in: `multipart/form-data` with the parts `spec` (JSON) and `file`.
#[utoipa::path(post, path = "/v1/targets", tag = "jobs",
    request_body(content = TargetUpload, content_type = "multipart/form-data"),
    responses((status = 201, body = Target)))]
pub async fn create(
    State(app): State<App>,
    NoQuery: NoQuery,
    key: IdempotencyKey,
    request: Request<Body>,
) -> Result<Response, ApiError> {
    let (head, body) = request.into_parts();
    let boundary = multipart_boundary(&head.headers)?;
    let body = read_body(&head.headers, body, limit::TARGET_BYTES + limit::JSON_BYTES).await?;
    let [spec, file] = multipart_parts(&boundary, &body, ["spec", "file"])?;
    if file.len() > limit::TARGET_BYTES {
        let words = format!("a target's file has at most {} bytes", limit::TARGET_BYTES);
        return Err(ApiError::too_large(words));
    }
    let hash = *blake3::hash(&file).as_bytes();
    // Boundaries are drawn anew by each client: what counts is what stands between them.
    let same = [*blake3::hash(&spec).as_bytes(), hash].concat();
    let attempt = match app.ledger.begin(&app.store, key, &same).await? {
        Begun::Replay(answer) => return Ok(created(COLLECTION, &answer)),
        Begun::Fresh(attempt) => attempt,
    };
    let spec: TargetSpec = parse_json(&spec)?;
    let kind = check(&spec)?;
    let reader = READERS.acquire().await.map_err(|error| ApiError::internal(error.to_string()))?;
    let bytes = file.clone();
    let read = tokio::task::spawn_blocking(move || {
        let read = TargetFile::read(kind, &bytes);
        drop(reader);
        read
    });
    let read = read.await.map_err(|error| ApiError::internal(error.to_string()))?;
    let target = describe(&spec, &read.map_err(refusal)?, hash, file.len());
    let idempotency = attempt.record(StatusCode::CREATED, &target);
    let new = NewTarget { target: target.clone(), hash, bytes: file.to_vec(), idempotency };
    app.store.create_target(new).await?;
    Ok(created(COLLECTION, &target))
}

/// The targets, newest first.
#[utoipa::path(get, path = "/v1/targets", tag = "jobs", params(PageQuery),
    responses((status = 200, body = Page<Target>)))]
pub async fn list(
    State(app): State<App>,
    Query(query): Query<PageQuery>,
) -> Result<Json<Page<Target>>, ApiError> {
    let limit = query.limit()?;
    let items = app.store.list_targets(query.cursor::<TargetId>()?, limit + 1).await?;
    Ok(Json(page(items, limit, |last| last.id.to_string(), |one| one)))
}

/// One target.
#[utoipa::path(get, path = "/v1/targets/{id}", tag = "jobs",
    params(("id" = TargetId, Path)), responses((status = 200, body = Target)))]
pub async fn get(
    State(app): State<App>,
    NoQuery: NoQuery,
    Path(id): Path<TargetId>,
) -> Result<Json<Target>, ApiError> {
    Ok(Json(app.store.target(id).await?))
}

/// Removes a target that no search is still to match.
#[utoipa::path(delete, path = "/v1/targets/{id}", tag = "jobs",
    params(("id" = TargetId, Path)), responses((status = 204)))]
pub async fn delete(
    State(app): State<App>,
    NoQuery: NoQuery,
    Path(id): Path<TargetId>,
) -> Result<Response, ApiError> {
    app.store.delete_target(id).await?;
    Ok(StatusCode::NO_CONTENT.into_response())
}

fn check(spec: &TargetSpec) -> Result<TargetKind, ApiError> {
    let kind: TargetKind = spec.kind.parse().map_err(|error: brood_search::UnknownKind| {
        ApiError::refused(error.to_string()).at("/kind")
    })?;
    check_length(&spec.name, limit::NAME_CHARS, "/name")?;
    if spec.name.chars().any(char::is_control) {
        return Err(ApiError::refused("a name has no control characters").at("/name"));
    }
    if spec.scene.is_some() {
        let words = "only a picture shows a scene; what was measured at directions has none";
        return Err(ApiError::refused(words).at("/scene"));
    }
    Ok(kind)
}

fn refusal(error: TargetFileError) -> ApiError {
    let reason = error.to_string();
    let may_quote = matches!(error, TargetFileError::Rgl(_) | TargetFileError::Picture(_));
    let clean = reason.chars().map(|c| if c.is_control() { ' ' } else { c });
    ApiError::refused(clean.take(if may_quote { REASON_CHARS } else { 500 }).collect::<String>())
}

fn describe(spec: &TargetSpec, read: &TargetFile, hash: [u8; 32], bytes: usize) -> Target {
    let TargetFile { target, skipped, .. } = read;
    let (fitted, held) = (target.fitted.len() as u64, target.held.len() as u64);
    Target {
        id: TargetId::fresh(),
        kind: spec.kind.clone(),
        name: spec.name.clone(),
        samples: fitted + held,
        fitted_samples: fitted,
        held_out_samples: held,
        skipped_samples: *skipped as u64,
        largest_f: target.fitted.largest(),
        reciprocal_floor: target.floor,
        hash: blake3::Hash::from_bytes(hash).to_hex().to_string(),
        bytes: bytes as u64,
        created_ms: now_ms(),
    }
}
