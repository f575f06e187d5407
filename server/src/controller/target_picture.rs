//! Pictures of targets: the uploaded ones as they were understood, and measured materials drawn in any scene.

use axum::extract::State;
use axum::response::Response;
use brood_brdf::{Model, ModelKind};
use brood_eval::encode_png;
use brood_inspect::Shot;
use brood_protocol::{PictureFormat, RENDERER_VERSION, SceneId, Target, TargetId};
use brood_scene::{EV_MAX, Scene};
use brood_search::{KnownView, PixelFate};
use http::HeaderMap;
use serde::Deserialize;

use super::file::FileHead;
use super::render::{check_light, check_rays, sampling, size};
use crate::extract::{NoQuery, Path, Query};
use crate::problem::ApiError;
use crate::shelf::{Drawn, Shelf, StageView, Volume};
use crate::state::App;

/// A target never changes.
const CACHE: &str = "private, max-age=31536000, immutable";
/// What is asked of pictures and cannot be had.
pub const IN_ITS_SCENE: &str = "a picture is known in its own scene and light alone";

/// What is shown of a picture.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Aspect {
    Picture,
    Scene,
    Pixels,
    Mask,
}

/// A picture of a target as the scene's film shows it. `n` counts from 0.
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

/// The scene of a picture as it was understood, on a grey diffuse material of albedo 0.5: the same size, the same framing.
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

/// What became of the pixels of a picture, one colour each: used #4caf50, masked #000000, background #30363d, edge #ffb300, clipped
/// #e53935, grazing #8e24aa, half_lit #1e88e5, several_lights #00acc1, unlit #6d4c41.
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

/// The mask of a picture: white where it is looked at. 404 where it has none.
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
    let mut hasher = begun("view", target);
    hasher.update(&n.to_le_bytes()).update(format!("{aspect:?}").as_bytes());
    let key = hasher.finalize();
    let etag = format!("\"{}\"", key.to_hex());
    let head = FileHead { etag, content_type: "image/png", cache: CACHE };
    let prepare = async {
        let known = Shelf::view(app, target, n).await?;
        if aspect == Aspect::Mask && !known.is_masked {
            let words = format!("picture {n} of this target has no mask");
            return Err(ApiError::not_found(words));
        }
        Ok(move || draw(&known, aspect))
    };
    let drawn = Shelf::drawn(app, key, prepare);
    match aspect {
        // Whether there is one is said before whether it has changed.
        Aspect::Mask => Ok(head.answer(headers, drawn.await?)),
        Aspect::Picture | Aspect::Scene | Aspect::Pixels => head.made(headers, drawn).await,
    }
}

/// Refuses a picture that a target does not have.
pub fn check_view(target: &Target, n: u32) -> Result<(), ApiError> {
    if usize::try_from(n).is_ok_and(|n| n < target.views.len()) {
        return Ok(());
    }
    Err(ApiError::not_found(match target.views.len() {
        0 => "this target is no picture".to_owned(),
        count => format!("the target's pictures are 0 to {}", count - 1),
    }))
}

fn draw(known: &KnownView, aspect: Aspect) -> Result<Drawn, ApiError> {
    let side = known.side();
    let fates = |color: &dyn Fn(PixelFate) -> [u8; 3]| {
        let opaque = |fate: &PixelFate| {
            let [r, g, b] = color(*fate);
            [r, g, b, u8::MAX]
        };
        let rgba: Vec<u8> = known.view.fates().iter().flat_map(opaque).collect();
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
            let taken = shot(known, &known.setting.scene).take_on(known.view.set(), &*grey.brdf());
            Drawn::of(&taken, PictureFormat::Png)?
        }
        Aspect::Pixels => fates(&color),
        Aspect::Mask => fates(&|fate| [if fate == PixelFate::Masked { 0 } else { u8::MAX }; 3]),
    })
}

/// A legend for people; pictures of it are described with these colours.
fn color(fate: PixelFate) -> [u8; 3] {
    match fate {
        PixelFate::Used => [0x4c, 0xaf, 0x50],
        PixelFate::Masked => [0x00, 0x00, 0x00],
        PixelFate::Background => [0x30, 0x36, 0x3d],
        PixelFate::Edge => [0xff, 0xb3, 0x00],
        PixelFate::Clipped => [0xe5, 0x39, 0x35],
        PixelFate::Grazing => [0x8e, 0x24, 0xaa],
        PixelFate::HalfLit => [0x1e, 0x88, 0xe5],
        PixelFate::SeveralLights => [0x00, 0xac, 0xc1],
        PixelFate::Unlit => [0x6d, 0x4c, 0x41],
    }
}

/// How a picture was taken, of whatever scene beside its own.
pub fn shot<'a>(known: &'a KnownView, scene: &'a Scene) -> Shot<'a> {
    Shot {
        mesh: &known.setting.mesh,
        scene,
        assets: &known.setting.assets,
        size_px: known.side(),
        sampling: known.setting.sampling,
    }
}

/// What the picture of a target is to be.
#[derive(Debug, Clone, Deserialize, utoipa::IntoParams)]
#[into_params(parameter_in = Query)]
#[serde(deny_unknown_fields)]
pub struct TargetRenderQuery {
    /// Side in pixels, 16 to 2048; 256 unless asked otherwise. Not of pictures.
    #[param(minimum = 16, maximum = 2048)]
    size: Option<u32>,
    /// The scene; the default one unless asked otherwise. Not of pictures.
    scene: Option<SceneId>,
    /// Position on the scene's light circle, degrees. Not of pictures.
    light_deg: Option<f64>,
    /// Samples per pixel: `adaptive`, or 1 to 64 in every pixel; adaptive unless asked otherwise. Not of pictures.
    samples: Option<String>,
    /// Exposure; the film's unless asked otherwise. Not of pictures.
    exposure_ev: Option<f64>,
    /// Which picture, counted from 0; the first unless asked otherwise. Of pictures alone.
    view: Option<u32>,
}

/// A measured material as an individual is drawn, or one of a target's pictures as it is.
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
        let words = format!("a number of EV from -{EV_MAX} to {EV_MAX}");
        return Err(ApiError::bad_parameter("exposure_ev", words));
    }
    let target = app.store.target(id).await?;
    if !target.views.is_empty() {
        if query.scene.is_some() || query.light_deg.is_some() {
            return Err(ApiError::refused(IN_ITS_SCENE));
        }
        if query.size.is_some() || query.samples.is_some() || query.exposure_ev.is_some() {
            let words = "a picture is shown as it is: without size, samples and exposure_ev";
            return Err(ApiError::refused(words));
        }
        let n = query.view.unwrap_or(0);
        return answer(&app, &target, n, &headers, Aspect::Picture).await;
    }
    if query.view.is_some() {
        return Err(ApiError::refused("a measured material has no pictures of its own"));
    }
    let scene = match query.scene {
        Some(scene) => scene,
        None => super::scene::store(&app, &Scene::default()).await?,
    };
    let view = StageView { scene, light_deg: query.light_deg, size_px, sampling };
    let etag = format!("\"{}\"", measured_key(&target, view, query.exposure_ev).to_hex());
    let head = FileHead { etag, content_type: "image/png", cache: CACHE };
    head.made(&headers, measured(&app, &target, view, query.exposure_ev)).await
}

/// A measured material, drawn.
pub async fn measured(
    app: &App,
    target: &Target,
    view: StageView,
    exposure_ev: Option<f64>,
) -> Result<Drawn, ApiError> {
    let key = measured_key(target, view, exposure_ev);
    let prepare = async {
        let stage = Shelf::stage(app, view).await?;
        let volume = Shelf::volume(app, target).await?;
        Ok(move || match &*volume {
            Volume::Measured(brdf) => {
                Drawn::of(&stage.take(&**brdf, exposure_ev), PictureFormat::Png)
            }
            Volume::Pictures(..) => Err(ApiError::refused(IN_ITS_SCENE)),
        })
    };
    Shelf::drawn(app, key, prepare).await
}

fn measured_key(target: &Target, view: StageView, exposure_ev: Option<f64>) -> blake3::Hash {
    let mut hasher = begun("measured", target);
    hasher.update(&stage_bytes(view));
    hasher.update(&ev_bytes(exposure_ev));
    hasher.finalize()
}

/// The beginning of a key: what a picture is of, and by which version it is drawn.
pub fn begun(what: &str, target: &Target) -> blake3::Hasher {
    let mut hasher = blake3::Hasher::new();
    hasher.update(b"brood target picture\n");
    hasher.update(&RENDERER_VERSION.to_le_bytes());
    hasher.update(env!("CARGO_PKG_VERSION").as_bytes());
    hasher.update(what.as_bytes()).update(b"\n");
    hasher.update(target.hash.as_bytes());
    hasher
}

/// What a picture depends on of its scene.
pub fn stage_bytes(view: StageView) -> Vec<u8> {
    let StageView { scene, light_deg, size_px, sampling } = view;
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
