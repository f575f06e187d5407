//! Targets of searches: uploading, listing, reading and deleting. Only targets that a search can
//! use are stored.

mod picture;
pub mod read;

use axum::Json;
use axum::body::Body;
use axum::extract::State;
use axum::response::{IntoResponse, Response};
use brood_protocol::{LargestAlbedo, Page, Target, TargetId, TargetSpec, TargetUpload};
use brood_storage::NewTarget;
use brood_target::{TargetFile, TargetFileError, TargetKind};
use bytes::Bytes;
use http::{Request, StatusCode};

use self::read::{ParsedTarget, REASON_CHARS, clean, read_blocking};
use super::{check_length, created, is_plain};
use crate::clock::now_ms;
use crate::extract::{
    PageQuery, Parts, Path, Query, multipart_boundary, page, parse_json, read_body,
};
use crate::idempotency::{Attempt, BodyHash, IdempotencyKey};
use crate::limit;
use crate::problem::ApiError;
use crate::state::App;

const COLLECTION: &str = "/v1/targets";

/// Uploads a target as `multipart/form-data` with the parts `spec` (JSON) and `file`.
///
/// Measured at directions: CSV, EXR slices, MERL, RGL, Cornell. Pictures of a known scene:
/// `{"kind": "image"}` with the scene, and optionally the part `mask`, or the parts named by the
/// views of the spec. Meshes and profiles of this server that the scene refers to are stored with
/// the target.
#[utoipa::path(post, path = "/v1/targets", operation_id = "create_target", tag = "jobs",
    request_body(content = TargetUpload, content_type = "multipart/form-data"),
    params(IdempotencyKey),
    responses((status = 201, description = "target as it was read", body = Target)))]
pub async fn create(
    State(app): State<App>,
    key: IdempotencyKey,
    request: Request<Body>,
) -> Result<Response, ApiError> {
    let (head, body) = request.into_parts();
    let boundary = multipart_boundary(&head.headers)?;
    let body = read_body(&head.headers, body, limit::TARGET_BYTES + limit::JSON_BYTES).await?;
    let parts = Parts::of(&boundary, &body)?;
    let spec = parts.need("spec")?.clone();
    if spec.len() > limit::JSON_BYTES {
        let words = format!("the part spec must have at most {} bytes", limit::JSON_BYTES);
        return Err(ApiError::too_large(words));
    }
    let rest = parts.iter().filter(|(name, _)| *name != "spec");
    if rest.map(|(_, bytes)| bytes.len()).sum::<usize>() > limit::TARGET_BYTES {
        let words =
            format!("a target's files must have at most {} bytes together", limit::TARGET_BYTES);
        return Err(ApiError::too_large(words));
    }
    let hash = BodyHash::of(&same(&parts));
    let make = async |attempt: Attempt| {
        let spec: TargetSpec = parse_json(&spec)?;
        let kind = check(&spec)?;
        let parsed = match kind {
            TargetKind::Image => picture::read(&app, &spec, &parts).await?,
            _ => {
                parts.only(&["spec", "file"])?;
                measured(kind, parts.need("file")?.clone()).await?
            }
        };
        let target = describe(&spec, &parsed);
        let idempotency = attempt.record(StatusCode::CREATED, &target);
        let ParsedTarget { hash, bytes, .. } = parsed;
        let new = NewTarget { target: target.clone(), hash: *hash.as_bytes(), bytes, idempotency };
        app.store.create_target(new).await?;
        Ok(created(COLLECTION, &target))
    };
    let replay = async |answer| Ok(created(COLLECTION, &answer));
    app.ledger.once(&app.store, (key, hash), make, replay).await
}

/// Returns bytes that are equal for equal uploads. Each client draws a new boundary, so only names
/// and contents count.
fn same(parts: &Parts) -> Vec<u8> {
    let mut all = Vec::new();
    for (name, bytes) in parts.iter() {
        all.extend(blake3::hash(name.as_bytes()).as_bytes());
        all.extend(blake3::hash(bytes).as_bytes());
    }
    all
}

/// Parses a target measured at directions.
async fn measured(kind: TargetKind, file: Bytes) -> Result<ParsedTarget, ApiError> {
    read_blocking(1, move || ParsedTarget::read(kind, file.to_vec())).await?.map_err(refusal)
}

/// Lists the targets, newest first.
#[utoipa::path(get, path = "/v1/targets", operation_id = "list_targets", tag = "jobs", params(PageQuery),
    responses((status = 200, description = "page of targets", body = Page<Target>)))]
pub async fn list(
    State(app): State<App>,
    Query(query): Query<PageQuery>,
) -> Result<Json<Page<Target>>, ApiError> {
    let limit = query.limit()?;
    let items = app.store.list_targets(query.cursor::<TargetId>()?, limit + 1).await?;
    Ok(Json(page(items, limit, |last| last.id.to_string(), |one| one)))
}

/// Returns a target.
#[utoipa::path(get, path = "/v1/targets/{id}", operation_id = "get_target", tag = "jobs",
    params(("id" = TargetId, Path)), responses((status = 200, description = "target", body = Target)))]
pub async fn get(
    State(app): State<App>,
    Path(id): Path<TargetId>,
) -> Result<Json<Target>, ApiError> {
    Ok(Json(app.store.target(id).await?))
}

/// Deletes a target; fails while an unfinished search uses it.
#[utoipa::path(delete, path = "/v1/targets/{id}", operation_id = "delete_target", tag = "jobs",
    params(("id" = TargetId, Path)), responses((status = 204, description = "target deleted")))]
pub async fn delete(
    State(app): State<App>,
    Path(id): Path<TargetId>,
) -> Result<Response, ApiError> {
    app.store.delete_target(id).await?;
    Ok(StatusCode::NO_CONTENT.into_response())
}

fn check(spec: &TargetSpec) -> Result<TargetKind, ApiError> {
    let kind: TargetKind = spec.kind.parse().map_err(|error: brood_target::UnknownKind| {
        ApiError::refused(error.to_string()).at("/kind")
    })?;
    check_length(&spec.name, limit::NAME_CHARS, "/name")?;
    if !spec.name.is_empty() && !is_plain(&spec.name) {
        let words =
            "a name must not have characters that are invisible or change the order of text";
        return Err(ApiError::refused(words).at("/name"));
    }
    let (words, said) = match (kind, &spec.views) {
        (TargetKind::Image, None) => return Ok(kind),
        (TargetKind::Image, Some(_)) => {
            ("with `views`, each view has this field for itself", false)
        }
        _ => {
            let words = "only a picture has a scene, samples, gain, clip_from, crop, refine or views; this kind is measured at directions";
            (words, spec.views.is_some())
        }
    };
    let fields = [
        (spec.scene.is_some(), "/scene"),
        (spec.samples.is_some(), "/samples"),
        (spec.gain.is_some(), "/gain"),
        (spec.clip_from.is_some(), "/clip_from"),
        (spec.crop.is_some(), "/crop"),
        (spec.refine.is_some(), "/refine"),
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

fn describe(spec: &TargetSpec, parsed: &ParsedTarget) -> Target {
    let TargetFile { target, skipped, pictures, .. } = &parsed.read;
    let (fitted, held) = (target.fitted.observations() as u64, target.held.observations() as u64);
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
        reciprocal_floor: target.floor(),
        largest_albedo: target
            .reflected
            .map(|most| LargestAlbedo { albedo: most.albedo, theta_deg: most.theta_deg }),
        hash: parsed.hash.to_hex().to_string(),
        bytes: parsed.bytes.len() as u64,
        created_ms: now_ms(),
        views: views.iter().map(picture::describe).collect(),
    }
}
