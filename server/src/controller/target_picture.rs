//! Pictures of targets: uploaded pictures as they were understood, and measured materials drawn in
//! any scene.

use axum::extract::State;
use axum::response::Response;
use brood_brdf::{Model, ModelKind};
use brood_eval::encode_png;
use brood_inspect::Shot;
use brood_protocol::{PictureFormat, RENDERER_VERSION, SceneId, Target, TargetId};
use brood_scene::{EV_MAX, Scene};
use brood_target::{KnownView, PixelStatus};
use http::HeaderMap;
use serde::Deserialize;

use super::file::FileHead;
use super::render::{check_light, check_rays, sampling, size};
use crate::extract::{NoQuery, Path, Query};
use crate::problem::ApiError;
use crate::state::App;
use crate::target_cache::{Drawn, LoadedTarget, TargetCache, ViewParams};

/// Immutable: a target never changes.
const CACHE: &str = "private, max-age=31536000, immutable";
/// Error of requests with another scene or light than the picture's.
pub const IN_ITS_SCENE: &str =
    "an image target is only known in its own scene and light: omit scene and light_deg";

/// Aspect of a target's picture to show.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Aspect {
    Picture,
    Scene,
    Pixels,
    Mask,
}

/// Returns a target's picture, developed with the scene's film. `n` counts from 0.
#[utoipa::path(get, path = "/v1/targets/{id}/views/{n}/picture.png", tag = "jobs",
    params(("id" = TargetId, Path), ("n" = u32, Path)),
    responses((status = 200, content_type = "image/png"), (status = 304, description = "unchanged")))]
pub async fn picture(
    state: State<App>,
    NoQuery: NoQuery,
    path: Path<(TargetId, u32)>,
    headers: HeaderMap,
) -> Result<Response, ApiError> {
    aspect(state, path, &headers, Aspect::Picture).await
}

/// Returns the scene of a target's picture, with a grey diffuse material of albedo 0.5.
///
/// Same size and framing as the picture.
#[utoipa::path(get, path = "/v1/targets/{id}/views/{n}/scene.png", tag = "jobs",
    params(("id" = TargetId, Path), ("n" = u32, Path)),
    responses((status = 200, content_type = "image/png"), (status = 304, description = "unchanged")))]
pub async fn scene(
    state: State<App>,
    NoQuery: NoQuery,
    path: Path<(TargetId, u32)>,
    headers: HeaderMap,
) -> Result<Response, ApiError> {
    aspect(state, path, &headers, Aspect::Scene).await
}

/// Returns a map of pixel statuses of a target's picture.
///
/// Colours: used #4caf50, masked #000000, background #30363d, edge #ffb300, clipped #e53935,
/// grazing #8e24aa, half_lit
/// #1e88e5, several_lights #00acc1, unlit #6d4c41.
#[utoipa::path(get, path = "/v1/targets/{id}/views/{n}/pixels.png", tag = "jobs",
    params(("id" = TargetId, Path), ("n" = u32, Path)),
    responses((status = 200, content_type = "image/png"), (status = 304, description = "unchanged")))]
pub async fn pixels(
    state: State<App>,
    NoQuery: NoQuery,
    path: Path<(TargetId, u32)>,
    headers: HeaderMap,
) -> Result<Response, ApiError> {
    aspect(state, path, &headers, Aspect::Pixels).await
}

/// Returns the mask of a target's picture, white where pixels are used; 404 if it has no mask.
#[utoipa::path(get, path = "/v1/targets/{id}/views/{n}/mask.png", tag = "jobs",
    params(("id" = TargetId, Path), ("n" = u32, Path)),
    responses((status = 200, content_type = "image/png"), (status = 304, description = "unchanged")))]
pub async fn mask(
    state: State<App>,
    NoQuery: NoQuery,
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
    check_view(target, n)?;
    let mut hasher = key_hasher("view", target);
    hasher.update(&n.to_le_bytes()).update(format!("{aspect:?}").as_bytes());
    let key = hasher.finalize();
    let etag = format!("\"{}\"", key.to_hex());
    let head = FileHead { etag, content_type: "image/png", cache: CACHE };
    let prepare = async {
        let known = TargetCache::view(app, target, n).await?;
        if aspect == Aspect::Mask && !known.is_masked {
            let words = format!("picture {n} of the target has no mask");
            return Err(ApiError::not_found(words));
        }
        Ok(move || draw(&known, aspect))
    };
    let drawn = TargetCache::picture(app, key, prepare);
    match aspect {
        // Drawn before the ETag is compared: a missing mask must be 404, not 304.
        Aspect::Mask => Ok(head.answer(headers, drawn.await?)),
        Aspect::Picture | Aspect::Scene | Aspect::Pixels => head.made(headers, drawn).await,
    }
}

/// Checks that a target has a picture of this index.
///
/// # Errors
/// 404 if it has not.
pub fn check_view(target: &Target, n: u32) -> Result<(), ApiError> {
    if usize::try_from(n).is_ok_and(|n| n < target.views.len()) {
        return Ok(());
    }
    Err(ApiError::not_found(match target.views.len() {
        0 => "this target is measured and has no pictures".to_owned(),
        count => format!("the picture index must be 0 to {}", count - 1),
    }))
}

fn draw(known: &KnownView, aspect: Aspect) -> Result<Drawn, ApiError> {
    let side = known.side();
    let statuses = |color: &dyn Fn(PixelStatus) -> [u8; 3]| {
        let opaque = |status: &PixelStatus| {
            let [r, g, b] = color(*status);
            [r, g, b, u8::MAX]
        };
        let rgba: Vec<u8> = known.view.statuses().iter().flat_map(opaque).collect();
        Drawn { bytes: encode_png(side, side, &rgba).into(), exposure_ev: 0.0 }
    };
    Ok(match aspect {
        Aspect::Picture => {
            let shown = known.shown();
            let bytes = encode_png(shown.width, shown.height, &shown.rgba).into();
            Drawn { bytes, exposure_ev: shown.exposure_ev }
        }
        Aspect::Scene => {
            let grey = Model::new(ModelKind::Lambert).with("albedo", &[0.5; 3]);
            let grey = grey.map_err(|error| ApiError::internal(error.to_string()))?;
            let picture =
                shot(known, &known.setting.scene).take_on(known.view.set(), &*grey.brdf());
            Drawn::of(&picture, PictureFormat::Png)?
        }
        Aspect::Pixels => statuses(&color),
        Aspect::Mask => {
            statuses(&|status| [if status == PixelStatus::Masked { 0 } else { u8::MAX }; 3])
        }
    })
}

/// Returns the colour of a status; the API documentation lists these colours.
fn color(status: PixelStatus) -> [u8; 3] {
    match status {
        PixelStatus::Used => [0x4c, 0xaf, 0x50],
        PixelStatus::Masked => [0x00, 0x00, 0x00],
        PixelStatus::Background => [0x30, 0x36, 0x3d],
        PixelStatus::Edge => [0xff, 0xb3, 0x00],
        PixelStatus::Clipped => [0xe5, 0x39, 0x35],
        PixelStatus::Grazing => [0x8e, 0x24, 0xaa],
        PixelStatus::HalfLit => [0x1e, 0x88, 0xe5],
        PixelStatus::SeveralLights => [0x00, 0xac, 0xc1],
        PixelStatus::Unlit => [0x6d, 0x4c, 0x41],
    }
}

/// Returns a shot with the picture's camera settings and another scene.
pub fn shot<'a>(known: &'a KnownView, scene: &'a Scene) -> Shot<'a> {
    Shot {
        mesh: &known.setting.mesh,
        scene,
        assets: &known.setting.assets,
        size_px: known.side(),
        sampling: known.setting.sampling,
    }
}

/// Options of a target's picture.
#[derive(Debug, Clone, Deserialize, utoipa::IntoParams)]
#[into_params(parameter_in = Query)]
#[serde(deny_unknown_fields)]
pub struct TargetRenderQuery {
    /// Side in pixels, 16 to 2048; default 256. Measured targets only.
    #[param(minimum = 16, maximum = 2048)]
    size: Option<u32>,
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
#[utoipa::path(get, path = "/v1/targets/{id}/render.png", tag = "jobs",
    params(("id" = TargetId, Path), TargetRenderQuery),
    responses((status = 200, content_type = "image/png"), (status = 304, description = "unchanged")))]
pub async fn render(
    State(app): State<App>,
    Path(id): Path<TargetId>,
    Query(query): Query<TargetRenderQuery>,
    headers: HeaderMap,
) -> Result<Response, ApiError> {
    let size_px = size(query.size)?;
    let sampling = sampling(query.samples.as_deref())?;
    check_light(query.light_deg)?;
    check_rays(u64::from(size_px).pow(2), sampling)?;
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
    let view = ViewParams { scene, light_deg: query.light_deg, size_px, sampling };
    let etag = format!("\"{}\"", measured_key(&target, view, query.exposure_ev).to_hex());
    let head = FileHead { etag, content_type: "image/png", cache: CACHE };
    head.made(&headers, draw_measured(&app, &target, view, query.exposure_ev)).await
}

/// Draws a measured material.
///
/// # Errors
/// [`ApiError`] if the target or the scene cannot be read, or drawing takes too long.
pub async fn draw_measured(
    app: &App,
    target: &Target,
    view: ViewParams,
    exposure_ev: Option<f64>,
) -> Result<Drawn, ApiError> {
    let key = measured_key(target, view, exposure_ev);
    let prepare = async {
        let traced = TargetCache::traced_view(app, view).await?;
        let loaded = TargetCache::load(app, target).await?;
        Ok(move || match &*loaded {
            LoadedTarget::Measured(brdf) => {
                Drawn::of(&traced.render(&**brdf, exposure_ev), PictureFormat::Png)
            }
            LoadedTarget::Pictures(..) => Err(ApiError::refused(IN_ITS_SCENE)),
        })
    };
    TargetCache::picture(app, key, prepare).await
}

fn measured_key(target: &Target, view: ViewParams, exposure_ev: Option<f64>) -> blake3::Hash {
    let mut hasher = key_hasher("measured", target);
    hasher.update(&view_bytes(view));
    hasher.update(&ev_bytes(exposure_ev));
    hasher.finalize()
}

/// Returns a hasher for a picture's cache key, seeded with the kind of picture, the target and the
/// versions.
pub fn key_hasher(what: &str, target: &Target) -> blake3::Hasher {
    let mut hasher = blake3::Hasher::new();
    hasher.update(b"brood target picture\n");
    hasher.update(&RENDERER_VERSION.to_le_bytes());
    hasher.update(env!("CARGO_PKG_VERSION").as_bytes());
    hasher.update(what.as_bytes()).update(b"\n");
    hasher.update(target.hash.as_bytes());
    hasher
}

/// Returns the bytes of a view for a cache key.
pub fn view_bytes(view: ViewParams) -> Vec<u8> {
    let ViewParams { scene, light_deg, size_px, sampling } = view;
    let mut bytes = scene.as_bytes().to_vec();
    bytes.extend(ev_bytes(light_deg));
    bytes.extend(size_px.to_le_bytes());
    bytes.extend(sampling.to_string().bytes());
    bytes
}

fn ev_bytes(value: Option<f64>) -> [u8; 9] {
    let mut bytes = [0; 9];
    if let Some(value) = value {
        bytes[0] = 1;
        bytes[1..].copy_from_slice(&value.to_le_bytes());
    }
    bytes
}
