//! Files of lights: IES profiles and environment images, parsed as a check and stored unchanged.

use axum::body::Body;
use axum::extract::State;
use axum::response::Response;
use brood_eval::decode_environment;
use brood_light::IesProfile;
use brood_protocol::{LightAssetAnswer, LightAssetKind};
use http::{Request, StatusCode};

use super::created;
use crate::clock::now_ms;
use crate::extract::{ContentType, NoQuery, read_body};
use crate::idempotency::{Begun, IdempotencyKey};
use crate::limit;
use crate::problem::ApiError;
use crate::state::App;

/// Uploads an IES file.
#[utoipa::path(post, path = "/v1/profiles", tag = "lights",
    request_body(content((String = "application/x-ies"), (String = "text/plain"))),
    responses((status = 201, body = LightAssetAnswer)))]
pub async fn create_profile(
    State(app): State<App>,
    NoQuery: NoQuery,
    key: IdempotencyKey,
    request: Request<Body>,
) -> Result<Response, ApiError> {
    let upload = Upload {
        kind: LightAssetKind::Profile,
        collection: "/v1/profiles",
        media_types: &["application/x-ies", "text/plain"],
        limit_bytes: limit::PROFILE_BYTES,
    };
    upload.store(&app, key, request).await
}

/// Uploads an environment image: equirectangular, Radiance HDR or EXR.
#[utoipa::path(post, path = "/v1/environments", tag = "lights",
    request_body(content((Vec<u8> = "image/vnd.radiance"), (Vec<u8> = "image/x-exr"))),
    responses((status = 201, body = LightAssetAnswer)))]
pub async fn create_environment(
    State(app): State<App>,
    NoQuery: NoQuery,
    key: IdempotencyKey,
    request: Request<Body>,
) -> Result<Response, ApiError> {
    let upload = Upload {
        kind: LightAssetKind::Environment,
        collection: "/v1/environments",
        media_types: &["image/vnd.radiance", "image/x-exr"],
        limit_bytes: limit::ENVIRONMENT_BYTES,
    };
    upload.store(&app, key, request).await
}

/// Kind of an upload and its limits.
struct Upload {
    kind: LightAssetKind,
    collection: &'static str,
    media_types: &'static [&'static str],
    limit_bytes: usize,
}

impl Upload {
    async fn store(
        &self,
        app: &App,
        key: IdempotencyKey,
        request: Request<Body>,
    ) -> Result<Response, ApiError> {
        let (head, body) = request.into_parts();
        ContentType::of(&head.headers).require(self.media_types)?;
        let bytes = read_body(&head.headers, body, self.limit_bytes).await?;
        let attempt = match app.ledger.begin(&app.store, key, &bytes).await? {
            Begun::Replay(answer) => return Ok(created(self.collection, &answer)),
            Begun::Fresh(attempt) => attempt,
        };
        let kind = self.kind;
        let read = app.processors.run(move || answer(kind, &bytes).map(|answer| (answer, bytes)));
        let (answer, bytes) = read.await??;
        let hash = *blake3::hash(&bytes).as_bytes();
        app.store.put_light_asset(hash, kind, bytes.to_vec()).await?;
        // Equal bytes always have the same kind: the kind follows from the first bytes of the file.
        if let Some(record) = attempt.record(StatusCode::CREATED, &answer) {
            app.store.store_idempotency(record, now_ms()).await?;
        }
        Ok(created(self.collection, &answer))
    }
}

/// Parses a file and returns its summary.
///
/// # Errors
/// [`ApiError`] if the file cannot be parsed.
pub fn answer(kind: LightAssetKind, bytes: &[u8]) -> Result<LightAssetAnswer, ApiError> {
    let refuse = |error: String| ApiError::refused(error);
    let mut answer = LightAssetAnswer {
        id: blake3::hash(bytes).to_hex().to_string(),
        kind,
        lumens: None,
        peak_candela: None,
        mean_radiance: None,
    };
    match kind {
        LightAssetKind::Profile => {
            let profile = IesProfile::parse(bytes).map_err(|error| refuse(error.to_string()))?;
            answer.lumens = Some(profile.lumens());
            answer.peak_candela = Some(profile.peak_candela());
        }
        LightAssetKind::Environment => {
            let map = decode_environment(bytes).map_err(|error| refuse(error.to_string()))?;
            answer.mean_radiance = Some(map.mean());
        }
    }
    Ok(answer)
}
