//! Targets of searches: uploaded, listed, read, deleted. Nothing is kept that a search could not begin with.

mod picture;

use axum::Json;
use axum::body::Body;
use axum::extract::State;
use axum::response::{IntoResponse, Response};
use brood_protocol::{LargestAlbedo, Page, Target, TargetId, TargetSpec, TargetUpload};
use brood_search::{TargetFile, TargetFileError, TargetKind};
use brood_storage::NewTarget;
use bytes::Bytes;
use http::{Request, StatusCode};

use super::{check_length, created};
use crate::extract::{
    NoQuery, PageQuery, Parts, Path, Query, multipart_boundary, page, parse_json, read_body,
};
use crate::idempotency::{Begun, IdempotencyKey};
use crate::limit;
use crate::problem::ApiError;
use crate::shelf::at_desk;
use crate::state::{App, now_ms};

const COLLECTION: &str = "/v1/targets";
/// Longest reason that an unreadable file is refused with: names of its fields may stand in it.
const REASON_CHARS: usize = 160;

/// Takes a target in: `multipart/form-data` with the part `spec` (JSON) and the part `file`; of pictures also `mask`, or the parts that the
/// views of the spec name.
///
/// What is measured at directions: CSV, EXR slices, MERL, RGL, Cornell. What is a picture of a known scene: `{"kind": "image"}` with the
/// scene; the scene may name meshes and profiles of this server, which are kept with the target.
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
    let parts = Parts::of(&boundary, &body)?;
    let spec = parts.need("spec")?.clone();
    if spec.len() > limit::JSON_BYTES {
        let words = format!("the part spec has at most {} bytes", limit::JSON_BYTES);
        return Err(ApiError::too_large(words));
    }
    let rest = parts.iter().filter(|(name, _)| *name != "spec");
    if rest.map(|(_, bytes)| bytes.len()).sum::<usize>() > limit::TARGET_BYTES {
        let words = format!("a target's files have at most {} bytes", limit::TARGET_BYTES);
        return Err(ApiError::too_large(words));
    }
    let attempt = match app.ledger.begin(&app.store, key, &same(&parts)).await? {
        Begun::Replay(answer) => return Ok(created(COLLECTION, &answer)),
        Begun::Fresh(attempt) => attempt,
    };
    let spec: TargetSpec = parse_json(&spec)?;
    let kind = check(&spec)?;
    let taken = match kind {
        TargetKind::Image => picture::read(&app, &spec, &parts).await?,
        _ => {
            parts.only(&["spec", "file"])?;
            measured(kind, parts.need("file")?.clone()).await?
        }
    };
    let target = describe(&spec, &taken);
    let idempotency = attempt.record(StatusCode::CREATED, &target);
    let Taken { hash, bytes, .. } = taken;
    let new = NewTarget { target: target.clone(), hash: *hash.as_bytes(), bytes, idempotency };
    app.store.create_target(new).await?;
    Ok(created(COLLECTION, &target))
}

/// Boundaries are drawn anew by each client: what counts is what stands between them.
fn same(parts: &Parts) -> Vec<u8> {
    let mut all = Vec::new();
    for (name, bytes) in parts.iter() {
        all.extend(blake3::hash(name.as_bytes()).as_bytes());
        all.extend(blake3::hash(bytes).as_bytes());
    }
    all
}

/// A target that can be searched for, and what is stored of it.
struct Taken {
    read: TargetFile,
    bytes: Vec<u8>,
    hash: blake3::Hash,
}

impl Taken {
    fn read(kind: TargetKind, bytes: Vec<u8>) -> Result<Self, TargetFileError> {
        let read = TargetFile::read(kind, &bytes)?;
        let hash = blake3::hash(&bytes);
        Ok(Self { read, bytes, hash })
    }
}

/// Reads what was measured at directions.
async fn measured(kind: TargetKind, file: Bytes) -> Result<Taken, ApiError> {
    at_desk(1, move || Taken::read(kind, file.to_vec())).await?.map_err(refusal)
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
    let (words, said) = match (kind, &spec.views) {
        (TargetKind::Image, None) => return Ok(kind),
        (TargetKind::Image, Some(_)) => ("each of several pictures says that for itself", false),
        _ => {
            let words = "only a picture shows a scene; what was measured at directions has none";
            (words, spec.views.is_some())
        }
    };
    let fields = [
        (spec.scene.is_some(), "/scene"),
        (spec.samples.is_some(), "/samples"),
        (spec.gain.is_some(), "/gain"),
        (said, "/views"),
    ];
    match fields.into_iter().find(|(is_there, _)| *is_there) {
        Some((_, pointer)) => Err(ApiError::refused(words).at(pointer)),
        None => Ok(kind),
    }
}

fn refusal(error: TargetFileError) -> ApiError {
    let may_quote = matches!(error, TargetFileError::Rgl(_) | TargetFileError::Picture(_));
    ApiError::refused(clean(&error.to_string(), if may_quote { REASON_CHARS } else { 500 }))
}

fn clean(reason: &str, most_chars: usize) -> String {
    let clean = reason.chars().map(|c| if c.is_control() { ' ' } else { c });
    clean.take(most_chars).collect()
}

fn describe(spec: &TargetSpec, taken: &Taken) -> Target {
    let TargetFile { target, skipped, pictures, .. } = &taken.read;
    let (fitted, held) = (target.fitted.len() as u64, target.held.len() as u64);
    let views = pictures.as_ref().map_or(&[][..], |pictures| &pictures.views);
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
        largest_albedo: target
            .reflected
            .map(|most| LargestAlbedo { albedo: most.albedo, theta_deg: most.theta_deg }),
        hash: taken.hash.to_hex().to_string(),
        bytes: taken.bytes.len() as u64,
        created_ms: now_ms(),
        views: views.iter().map(picture::describe).collect(),
    }
}
