//! Files of lights and painted materials: IES profiles, environment images and control images,
//! parsed as a check and stored unchanged.

use axum::Json;
use axum::body::Body;
use axum::extract::State;
use axum::response::{IntoResponse, Response};
use brood_eval::{IMAGE_SIDE_MOST, decode_display, decode_environment, picture_size};
use brood_light::{BuiltinEnvironment, IesProfile};
use brood_protocol::{LightAssetAnswer, LightAssetKind};
use http::{Request, StatusCode, header};

use super::create_once;
use super::file::IMMUTABLE;
use super::target::read::{REASON_CHARS, clean};
use crate::control_image;
use crate::extract::{Path, read_upload};
use crate::idempotency::IdempotencyKey;
use crate::limit;
use crate::problem::ApiError;
use crate::scene_asset;
use crate::state::App;

/// Uploads an IES file.
#[utoipa::path(post, path = "/v1/profiles", tag = "lights",
    request_body(content((Vec<u8> = "application/x-ies"), (Vec<u8> = "text/plain"))),
    params(IdempotencyKey),
    responses((status = 201, description = "id and summary of the profile", body = LightAssetAnswer)))]
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
    params(IdempotencyKey),
    responses((status = 201, description = "id and summary of the environment", body = LightAssetAnswer)))]
pub async fn create_environment(
    State(app): State<App>,
    key: IdempotencyKey,
    request: Request<Body>,
) -> Result<Response, ApiError> {
    ENVIRONMENT.store(&app, key, request).await
}

/// Uploads an image for painted materials or scenes: PNG or JPEG, at most 4096 pixels a side.
#[utoipa::path(post, path = "/v1/images", tag = "genomes",
    request_body(content((Vec<u8> = "image/png"), (Vec<u8> = "image/jpeg"))),
    params(IdempotencyKey),
    responses((status = 201, description = "id and size of the image", body = LightAssetAnswer)))]
pub async fn create_image(
    State(app): State<App>,
    key: IdempotencyKey,
    request: Request<Body>,
) -> Result<Response, ApiError> {
    IMAGE.store(&app, key, request).await
}

/// Returns an image as it was uploaded.
#[utoipa::path(get, path = "/v1/images/{id}", operation_id = "get_image", tag = "genomes",
    params(("id" = String, Path, description = "64 hexadecimal digits")),
    responses((status = 200, description = "image file",
        content((Vec<u8> = "image/png"), (Vec<u8> = "image/jpeg")))))]
pub async fn image(
    State(app): State<App>,
    Path(id): Path<String>,
) -> Result<impl IntoResponse, ApiError> {
    let bytes = control_image::file(&app.store, &id).await?;
    let media_type = if bytes.starts_with(b"\x89PNG") { "image/png" } else { "image/jpeg" };
    Ok(([(header::CACHE_CONTROL, IMMUTABLE), (header::CONTENT_TYPE, media_type)], bytes))
}

/// Environment as painted materials see it: light from one direction.
#[derive(Debug, Clone, serde::Serialize, utoipa::ToSchema)]
pub struct EnvironmentMean {
    /// Mean radiance in pixel values, red, green and blue.
    radiance: [f64; 3],
    /// Mean direction to the light, weighted by luminance, of the unrotated environment; absent if
    /// the directions cancel.
    #[serde(skip_serializing_if = "Option::is_none")]
    direction: Option<[f64; 3]>,
}

/// Returns the mean light of a built-in or uploaded environment.
#[utoipa::path(get, path = "/v1/environments/{image}/mean", operation_id = "get_environment_mean", tag = "lights",
    params(("image" = String, Path, description = "name of a built-in environment, or id of an image")),
    responses((status = 200, description = "mean light", body = EnvironmentMean)))]
pub async fn environment_mean(
    State(app): State<App>,
    Path(image): Path<String>,
) -> Result<impl IntoResponse, ApiError> {
    let map = match BuiltinEnvironment::from_name(&image) {
        Some(builtin) => app.processors.run(move || builtin.map()).await?,
        None => scene_asset::environment(&app.store, &image).await?,
    };
    let mean = EnvironmentMean {
        radiance: map.mean(),
        direction: map.mean_direction().map(|direction| direction.to_array()),
    };
    Ok(([(header::CACHE_CONTROL, IMMUTABLE)], Json(mean)))
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

const IMAGE: Upload = Upload {
    kind: LightAssetKind::Image,
    collection: "/v1/images",
    media_types: &["image/png", "image/jpeg"],
    limit_bytes: limit::TARGET_BYTES,
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

/// Checks the size of an environment from its header. Files that are no pictures pass.
///
/// # Errors
/// 413 if it has too many pixels.
fn check_pixels(bytes: &[u8]) -> Result<(), ApiError> {
    let Ok((width, height)) = picture_size(bytes) else { return Ok(()) };
    let (pixels, most) = (u64::from(width) * u64::from(height), limit::ENVIRONMENT_PIXELS);
    if pixels <= most {
        return Ok(());
    }
    let words = format!(
        "an environment has at most {most} pixels (4096 x 2048), this one has {width} x {height}: \
         scale it down"
    );
    Err(ApiError::too_large(words))
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
        width: None,
        height: None,
    };
    match kind {
        LightAssetKind::Profile => {
            let profile = IesProfile::parse(bytes).map_err(|error| refuse(error.to_string()))?;
            answer.lumens = Some(profile.lumens());
            answer.peak_candela = Some(profile.peak_candela());
        }
        LightAssetKind::Environment => {
            check_pixels(bytes)?;
            let map = decode_environment(bytes).map_err(|error| refuse(error.to_string()))?;
            answer.mean_radiance = Some(map.mean());
        }
        LightAssetKind::Image => {
            let read = decode_display(bytes, IMAGE_SIDE_MOST);
            let read = read.map_err(|error| refuse(clean(&error.to_string(), REASON_CHARS)))?;
            (answer.width, answer.height) = (Some(read.width), Some(read.height));
        }
    }
    Ok(answer)
}
