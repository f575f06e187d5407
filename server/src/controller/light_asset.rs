//! Files of lights: IES profiles and environment images, parsed as a check and stored unchanged.

use axum::body::Body;
use axum::extract::State;
use axum::response::Response;
use brood_eval::decode_environment;
use brood_light::IesProfile;
use brood_protocol::{LightAssetAnswer, LightAssetKind};
use http::{Request, StatusCode};

use super::create_once;
use crate::extract::read_upload;
use crate::idempotency::IdempotencyKey;
use crate::limit;
use crate::problem::ApiError;
use crate::state::App;

/// Uploads an IES file.
#[utoipa::path(post, path = "/v1/profiles", tag = "lights",
    request_body(content((String = "application/x-ies"), (String = "text/plain"))),
    responses((status = 201, body = LightAssetAnswer)))]
pub async fn create_profile(
    State(app): State<App>,
    key: IdempotencyKey,
    request: Request<Body>,
) -> Result<Response, ApiError> {
    PROFILE.store(&app, key, request).await
}

/// Uploads an environment image: equirectangular, Radiance HDR or EXR.
#[utoipa::path(post, path = "/v1/environments", tag = "lights",
    request_body(content((Vec<u8> = "image/vnd.radiance"), (Vec<u8> = "image/x-exr"))),
    responses((status = 201, body = LightAssetAnswer)))]
pub async fn create_environment(
    State(app): State<App>,
    key: IdempotencyKey,
    request: Request<Body>,
) -> Result<Response, ApiError> {
    ENVIRONMENT.store(&app, key, request).await
}

/// Kind of an upload and its limits.
struct Upload {
    kind: LightAssetKind,
    collection: &'static str,
    media_types: &'static [&'static str],
    limit_bytes: usize,
}

const PROFILE: Upload = Upload {
    kind: LightAssetKind::Profile,
    collection: "/v1/profiles",
    media_types: &["application/x-ies", "text/plain"],
    limit_bytes: limit::PROFILE_BYTES,
};
const ENVIRONMENT: Upload = Upload {
    kind: LightAssetKind::Environment,
    collection: "/v1/environments",
    media_types: &["image/vnd.radiance", "image/x-exr"],
    limit_bytes: limit::ENVIRONMENT_BYTES,
};

impl Upload {
    async fn store(
        &self,
        app: &App,
        key: IdempotencyKey,
        request: Request<Body>,
    ) -> Result<Response, ApiError> {
        let kind = self.kind;
        let (_, bytes) = read_upload(request, self.media_types, self.limit_bytes).await?;
        create_once(app, key, self.collection, bytes.clone(), async |attempt| {
            let read =
                app.processors.run(move || answer(kind, &bytes).map(|answer| (answer, bytes)));
            let (answer, bytes) = read.await??;
            let hash = *blake3::hash(&bytes).as_bytes();
            // Equal bytes always have the same kind: the kind follows from the first bytes of the
            // file.
            app.store.put_light_asset(hash, kind, bytes.to_vec()).await?;
            attempt.store(&app.store, StatusCode::CREATED, &answer).await?;
            Ok(answer)
        })
        .await
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
