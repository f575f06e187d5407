//! Pictures of targets: uploaded pictures as they were understood, and measured materials rendered
//! in any scene. Workers render them.

use axum::extract::State;
use axum::response::Response;
use brood_protocol::{
    Aspect, Backend, Frame, MeshSource, PictureFormat, SceneId, Subject, Target, TargetId,
    TargetSource, TargetView,
};
use brood_scene::{EV_MAX, PictureSize, Sampling, Scene};
use http::HeaderMap;
use serde::Deserialize;

use super::file::{FileHead, IMMUTABLE};
use super::picture_query::{check_light, check_rays, sampling, size};
use crate::dispatch::PictureRequest;
use crate::extract::{Path, Query};
use crate::library::Framing;
use crate::problem::ApiError;
use crate::state::App;

/// Error of requests with another scene or light than the picture's.
pub const IN_ITS_SCENE: &str =
    "an image target is only known in its own scene and light: omit scene and light_deg";

/// Returns a target's picture, developed with the scene's film. `n` counts from 0.
#[utoipa::path(get, path = "/v1/targets/{id}/views/{n}/picture.png", operation_id = "get_target_picture", tag = "jobs",
    params(("id" = TargetId, Path), ("n" = u32, Path)),
    responses((status = 200, description = "developed picture as PNG", content_type = "image/png"),
        (status = 304)))]
pub async fn picture(
    state: State<App>,
    path: Path<(TargetId, u32)>,
    headers: HeaderMap,
) -> Result<Response, ApiError> {
    aspect(state, path, &headers, Aspect::Picture).await
}

/// Returns the scene of a target's picture, with a grey diffuse material of albedo 0.5.
///
/// Same size and framing as the picture.
#[utoipa::path(get, path = "/v1/targets/{id}/views/{n}/scene.png", operation_id = "get_target_scene", tag = "jobs",
    params(("id" = TargetId, Path), ("n" = u32, Path), TargetSceneQuery),
    responses((status = 200, description = "picture of the scene as PNG", content_type = "image/png"),
        (status = 304)))]
pub async fn scene(
    state: State<App>,
    path: Path<(TargetId, u32)>,
    Query(query): Query<TargetSceneQuery>,
    headers: HeaderMap,
) -> Result<Response, ApiError> {
    let shown = if query.corrected { Aspect::Corrected } else { Aspect::Scene };
    aspect(state, path, &headers, shown).await
}

/// Options of the picture of a target's scene.
#[derive(Debug, Clone, Deserialize, utoipa::IntoParams)]
#[into_params(parameter_in = Query)]
#[serde(deny_unknown_fields)]
pub struct TargetSceneQuery {
    /// True for the scene as corrected by a search, 404 if there is none; default: as stated.
    #[serde(default)]
    corrected: bool,
}

/// Returns a map of pixel statuses of a target's picture.
///
/// Colours: used #4caf50, masked #000000, background #30363d, edge #ffb300, clipped #e53935,
/// grazing #8e24aa, outlier #f06292, half_lit
/// #1e88e5, several_lights #00acc1, unlit #6d4c41.
#[utoipa::path(get, path = "/v1/targets/{id}/views/{n}/pixels.png", operation_id = "get_target_pixels", tag = "jobs",
    params(("id" = TargetId, Path), ("n" = u32, Path)),
    responses((status = 200, description = "map of pixel statuses as PNG", content_type = "image/png"),
        (status = 304)))]
pub async fn pixels(
    state: State<App>,
    path: Path<(TargetId, u32)>,
    headers: HeaderMap,
) -> Result<Response, ApiError> {
    aspect(state, path, &headers, Aspect::Pixels).await
}

/// Returns the mask of a target's picture, white where pixels are used; 404 if it has no mask.
#[utoipa::path(get, path = "/v1/targets/{id}/views/{n}/mask.png", operation_id = "get_target_mask", tag = "jobs",
    params(("id" = TargetId, Path), ("n" = u32, Path)),
    responses((status = 200, description = "mask as PNG", content_type = "image/png"), (status = 304)))]
pub async fn mask(
    state: State<App>,
    path: Path<(TargetId, u32)>,
    headers: HeaderMap,
) -> Result<Response, ApiError> {
    aspect(state, path, &headers, Aspect::Mask).await
}

async fn aspect(
    State(app): State<App>,
    Path((id, n)): Path<(TargetId, u32)>,
    headers: &HeaderMap,
    aspect: Aspect,
) -> Result<Response, ApiError> {
    let target = app.store.target(id).await?;
    answer(&app, &target, n, headers, aspect).await
}

async fn answer(
    app: &App,
    target: &Target,
    n: u32,
    headers: &HeaderMap,
    aspect: Aspect,
) -> Result<Response, ApiError> {
    let own = view(target, n)?;
    let scene = match (&own.corrected, aspect) {
        (Some(corrected), Aspect::Corrected) => &corrected.scene,
        (None, Aspect::Corrected) => {
            let words = "no search has corrected the scene of this picture";
            return Err(ApiError::not_found(words));
        }
        _ => &own.scene,
    };
    let frame = view_frame(scene, own.size_px, own.samples, PictureFormat::Png);
    let request = PictureRequest::own(frame, &Subject::Target(source(target, Some(n))?, aspect));
    let head = FileHead::of_picture(request.key(), "image/png", IMMUTABLE);
    let picture = app.pictures.get(request);
    match aspect {
        // Rendered before the ETag is compared: a missing mask must be 404, not 304.
        Aspect::Mask => Ok(head.answer(headers, picture.await?)),
        Aspect::Picture | Aspect::Scene | Aspect::Corrected | Aspect::Pixels => {
            head.made(headers, picture).await
        }
    }
}

/// Returns the source of a target for workers, with the index of its picture if it is an image
/// target.
///
/// # Errors
/// 500 if the stored hash is malformed.
pub fn source(target: &Target, view: Option<u32>) -> Result<TargetSource, ApiError> {
    let hash = blake3::Hash::from_hex(&target.hash)
        .map_err(|error| ApiError::internal(format!("a stored target has no hash: {error}")))?;
    Ok(TargetSource { kind: target.kind.clone(), hash: *hash.as_bytes(), view })
}

/// Returns the frame of a target's picture in its scene, in this size, sampling and format.
pub fn view_frame(
    scene: &Scene,
    size_px: PictureSize,
    sampling: Sampling,
    format: PictureFormat,
) -> Frame {
    Frame::new(scene, MeshSource::Target, size_px, sampling, (format, Backend::Auto))
}

/// Returns the picture of a target with this index.
///
/// # Errors
/// 404 if it has none.
pub fn view(target: &Target, n: u32) -> Result<&TargetView, ApiError> {
    let view = usize::try_from(n).ok().and_then(|n| target.views.get(n));
    view.ok_or_else(|| {
        ApiError::not_found(match target.views.len() {
            0 => "this target is measured and has no pictures".to_owned(),
            1 => "the picture index must be 0".to_owned(),
            count => format!("the picture index must be 0 to {}", count - 1),
        })
    })
}

/// Options of a target's picture.
#[derive(Debug, Clone, Deserialize, utoipa::IntoParams)]
#[into_params(parameter_in = Query)]
#[serde(deny_unknown_fields)]
pub struct TargetRenderQuery {
    /// Size in pixels: the side of a square picture, or width and height as in `640x360`; each side
    /// 16 to 2048, default 256. Measured targets only.
    #[param(pattern = "^[0-9]+(x[0-9]+)?$")]
    size: Option<String>,
    /// Scene to render; default: the default scene. Measured targets only.
    scene: Option<SceneId>,
    /// Light angle on the scene's light circle, in degrees. Measured targets only.
    light_deg: Option<f64>,
    /// Samples per pixel: `adaptive` (default), or a fixed number from 1 to 64. Measured targets
    /// only.
    samples: Option<String>,
    /// Exposure in EV; default: the film's. Measured targets only.
    exposure_ev: Option<f64>,
    /// Index of the picture, from 0; default 0. Image targets only.
    view: Option<u32>,
}

/// Returns a measured material drawn in a scene, or a picture of an image target.
#[utoipa::path(get, path = "/v1/targets/{id}/render.png", operation_id = "render_target", tag = "jobs",
    params(("id" = TargetId, Path), TargetRenderQuery),
    responses((status = 200, description = "picture as PNG", content_type = "image/png"), (status = 304)))]
pub async fn render(
    State(app): State<App>,
    Path(id): Path<TargetId>,
    Query(query): Query<TargetRenderQuery>,
    headers: HeaderMap,
) -> Result<Response, ApiError> {
    let size_px = size(query.size.as_deref())?;
    let sampling = sampling(query.samples.as_deref())?;
    check_light(query.light_deg)?;
    check_rays(size_px.pixels(), sampling)?;
    if query.exposure_ev.is_some_and(|ev| !(-EV_MAX..=EV_MAX).contains(&ev)) {
        let words = format!("must be a number from -{EV_MAX} to {EV_MAX}");
        return Err(ApiError::bad_parameter("exposure_ev", words));
    }
    let target = app.store.target(id).await?;
    if !target.views.is_empty() {
        if query.scene.is_some() || query.light_deg.is_some() {
            return Err(ApiError::refused(IN_ITS_SCENE));
        }
        if query.size.is_some() || query.samples.is_some() || query.exposure_ev.is_some() {
            let words = "size, samples and exposure_ev are only allowed for measured targets";
            return Err(ApiError::refused(words));
        }
        let n = query.view.unwrap_or(0);
        return answer(&app, &target, n, &headers, Aspect::Picture).await;
    }
    if query.view.is_some() {
        return Err(ApiError::refused(
            "`view` is only allowed for image targets; this one is measured",
        ));
    }
    let scene = match query.scene {
        Some(scene) => scene,
        None => super::scene::store(&app, &Scene::default()).await?,
    };
    if app.library.scene(scene).await?.scene.has_surroundings() {
        let words = "a target is drawn in scenes without other objects and without ground";
        return Err(ApiError::refused(words));
    }
    let view = Framing {
        light_deg: query.light_deg,
        sampling,
        ..Framing::png(scene, size_px, Backend::Auto)
    };
    let mut frame = app.library.frame(view).await?.frame.clone();
    if let Some(ev) = query.exposure_ev {
        frame = frame.exposed(ev).map_err(|error| ApiError::internal(error.to_string()))?;
    }
    let subject = Subject::Target(source(&target, None)?, Aspect::Picture);
    let request = PictureRequest::own(frame, &subject);
    let head = FileHead::of_picture(request.key(), "image/png", IMMUTABLE);
    head.made(&headers, app.pictures.get(request)).await
}
