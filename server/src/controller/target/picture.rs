//! Image targets: reads the pictures of an upload and bundles them with their scenes into one
//! self-contained file.

use std::collections::BTreeMap;
use std::collections::btree_map::Entry;
use std::sync::Arc;

use brood_light::AssetRef;
use brood_mesh::Mesh;
use brood_protocol::{MeshSource, SceneId, TargetPixels, TargetSpec, TargetView, ViewSpec};
use brood_scene::{ClipFrom, PixelArea, Refine, Sampling, Scene};
use brood_target::{
    BundleError, BundledView, ImageTargetError, KnownView, PictureBundle, PicturesError,
    PixelCounts, TargetFileError, TargetKind, ViewError,
};
use bytes::Bytes;
use serde_json::Value;

use super::read::{ParsedTarget, READ_PERMITS, REASON_CHARS, clean, read_blocking};
use crate::extract::{Parts, parse_value};
use crate::limit;
use crate::problem::{ApiError, quote};
use crate::scene_asset;
use crate::state::App;

/// Uploads with more samples than this are read one at a time.
const LARGE_RAYS: u64 = 1 << 20;

/// Requested view with its parts.
#[derive(Clone)]
struct RequestedView {
    /// JSON pointer to the view in the spec.
    at: String,
    /// JSON pointer to the field that names the picture.
    picture_at: String,
    scene: Option<Value>,
    sampling: Sampling,
    is_gain_unknown: bool,
    clip_from: ClipFrom,
    crop: Option<PixelArea>,
    is_held_out: bool,
    refine: Refine,
    picture: Bytes,
    mask: Option<Bytes>,
}

/// Reads the pictures of a spec and bundles them as the target's file.
pub(super) async fn read(
    app: &App,
    spec: &TargetSpec,
    parts: &Parts,
) -> Result<ParsedTarget, ApiError> {
    let (asked, all_at) = match spec.views.as_deref() {
        Some(views) => (several(views, parts)?, "/views"),
        None => (vec![alone(spec, parts)?], "/file"),
    };
    if let Some(one) = asked.iter().find(|one| one.sampling.min_rays() > limit::SAMPLES) {
        let words = format!("`samples` must be adaptive or 1 to {}", limit::SAMPLES);
        return Err(ApiError::refused(words).at(format!("{}/samples", one.at)));
    }
    let rays: u64 = asked.iter().map(rays).sum();
    if rays > limit::TARGET_RAYS {
        let words = format!(
            "the pictures need {rays} samples; at most {} are allowed, and a search uses about 10,000 of them: crop the picture or make it smaller",
            limit::TARGET_RAYS
        );
        return Err(ApiError::refused(words).at(all_at));
    }
    let mut files = LightFiles::default();
    let (mut scenes, mut meshes) = (Vec::with_capacity(asked.len()), BTreeMap::new());
    for one in &asked {
        let scene = scene(app, one).await?;
        let mesh = mesh(app, &scene, &mut meshes).await?;
        files.take(app, &scene).await?;
        scenes.push((scene, mesh));
    }
    let pictures = asked.clone();
    let read = read_blocking(if rays > LARGE_RAYS { READ_PERMITS } else { 1 }, move || {
        let views = pictures.into_iter().zip(scenes).map(RequestedView::bundled).collect();
        // Parsed from the encoded bundle, which is what workers will read.
        let LightFiles { profiles, environments } = files;
        let bundle = PictureBundle { views, profiles, environments };
        ParsedTarget::read(TargetKind::Image, bundle.encode()?)
    });
    read.await?.map_err(|error| refusal(&error, &asked, all_at))
}

impl RequestedView {
    fn bundled((asked, (scene, mesh)): (Self, (Scene, Option<Arc<Mesh>>))) -> BundledView {
        BundledView {
            scene,
            mesh,
            sampling: asked.sampling,
            is_gain_unknown: asked.is_gain_unknown,
            clip_from: asked.clip_from,
            crop: asked.crop,
            is_held_out: asked.is_held_out,
            refine: asked.refine,
            picture: asked.picture.to_vec(),
            mask: asked.mask.as_ref().map(|mask| mask.to_vec()),
        }
    }
}

/// Returns the one picture of a spec without views, in the part `file`.
fn alone(spec: &TargetSpec, parts: &Parts) -> Result<RequestedView, ApiError> {
    parts.only(&["spec", "file", "mask"])?;
    Ok(RequestedView {
        at: String::new(),
        picture_at: "/file".to_owned(),
        scene: spec.scene.clone(),
        sampling: spec.samples.unwrap_or_default(),
        is_gain_unknown: spec.gain.unwrap_or_default(),
        clip_from: spec.clip_from.unwrap_or_default(),
        crop: spec.crop.map(area),
        is_held_out: false,
        refine: refine(spec.refine, "")?,
        picture: parts.need("file")?.clone(),
        mask: parts.get("mask").cloned(),
    })
}

/// Returns the pictures of a spec with views.
fn several(views: &[ViewSpec], parts: &Parts) -> Result<Vec<RequestedView>, ApiError> {
    if !(1..=PictureBundle::VIEWS_MOST).contains(&views.len()) {
        let words = BundleError::Views(views.len()).to_string();
        return Err(ApiError::refused(words).at("/views"));
    }
    let mut names = vec!["spec"];
    let mut asked = Vec::with_capacity(views.len());
    for (index, view) in views.iter().enumerate() {
        let at = format!("/views/{index}");
        let part = |name: &str, field: &str| {
            let missing = || {
                let words = format!("there is no part {}", quote(name));
                ApiError::refused(words).at(format!("{at}/{field}"))
            };
            parts.get(name).filter(|_| name != "spec").cloned().ok_or_else(missing)
        };
        let refine = refine(view.refine, &at)?;
        let picture = part(&view.picture, "picture")?;
        let mask = view.mask.as_deref().map(|name| part(name, "mask")).transpose()?;
        names.push(&view.picture);
        names.extend(view.mask.as_deref());
        asked.push(RequestedView {
            picture_at: format!("{at}/picture"),
            at,
            scene: view.scene.clone(),
            sampling: view.samples.unwrap_or_default(),
            is_gain_unknown: view.gain,
            clip_from: view.clip_from.unwrap_or_default(),
            crop: view.crop.map(area),
            is_held_out: view.held_out,
            refine,
            picture,
            mask,
        });
    }
    parts.only(&names)?;
    Ok(asked)
}

/// Checks uncertainties. `at` is the JSON pointer of the view.
fn refine(asked: Option<Refine>, at: &str) -> Result<Refine, ApiError> {
    let refine = asked.unwrap_or_default();
    refine.validate().map_err(|error| ApiError::from(error).inside(&format!("{at}/refine")))?;
    Ok(refine)
}

fn area([x, y, width, height]: [u32; 4]) -> PixelArea {
    PixelArea { x, y, width, height }
}

/// Returns the number of samples of a picture, from its header; 0 if it is invalid and will be
/// refused on reading.
fn rays(one: &RequestedView) -> u64 {
    let (width, height) = brood_eval::picture_size(&one.picture).unwrap_or_default();
    let pixels = u64::from(width) * u64::from(height);
    let is_read = width.max(height) <= KnownView::SIDE_MOST;
    let pixels = one.crop.map_or(pixels, |area| pixels.min(area.pixels()));
    if is_read { pixels * u64::from(one.sampling.min_rays()) } else { 0 }
}

async fn scene(app: &App, one: &RequestedView) -> Result<Scene, ApiError> {
    let prefix = format!("{}/scene", one.at);
    let scene = match &one.scene {
        None => Scene::default(),
        Some(Value::String(id)) => {
            let unknown = || {
                let words = format!("{} is not a scene id", quote(id));
                ApiError::refused(words).at(prefix.clone())
            };
            let id: SceneId = id.parse().map_err(|_| unknown())?;
            let known = app.library.scene(id).await;
            known.map_err(|error| error.inside(&prefix))?.scene.clone()
        }
        Some(value) => parse_value(value).map_err(|error: ApiError| error.inside(&prefix))?,
    };
    let checked = async {
        scene.validate()?;
        if scene.has_surroundings() {
            let words = "a target shows one object, without others and without ground";
            return Err(ApiError::refused(words).at(if scene.ground.is_some() {
                "/ground"
            } else {
                "/objects"
            }));
        }
        if scene.normal_map.is_some() {
            let words = "a target shows an object without a normal map";
            return Err(ApiError::refused(words).at("/normal_map"));
        }
        app.library.mesh(&scene).await?;
        scene_asset::check(&app.store, &scene).await
    };
    checked.await.map_err(|error: ApiError| error.inside(&prefix))?;
    Ok(scene)
}

/// Returns the uploaded mesh of a scene, reading each mesh once; `None` for a built-in mesh.
async fn mesh(
    app: &App,
    scene: &Scene,
    read: &mut BTreeMap<[u8; 32], Arc<Mesh>>,
) -> Result<Option<Arc<Mesh>>, ApiError> {
    let MeshSource::Uploaded(hash) = app.library.mesh(scene).await? else { return Ok(None) };
    Ok(Some(match read.entry(hash) {
        Entry::Occupied(known) => known.get().clone(),
        Entry::Vacant(place) => place.insert(app.library.uploaded_mesh(hash).await?).clone(),
    }))
}

/// Files of the lights of all scenes, by their names.
#[derive(Default)]
struct LightFiles {
    profiles: BTreeMap<String, Vec<u8>>,
    environments: BTreeMap<String, Vec<u8>>,
}

impl LightFiles {
    /// Adds the files of a scene's lights.
    async fn take(&mut self, app: &App, scene: &Scene) -> Result<(), ApiError> {
        for (asset, _) in scene.assets() {
            let (name, files) = match asset {
                AssetRef::Profile(name) => (name, &mut self.profiles),
                AssetRef::Environment(name) => (name, &mut self.environments),
                AssetRef::Image(_) => continue,
            };
            if let Entry::Vacant(place) = files.entry(name.to_owned()) {
                place.insert(scene_asset::file(&app.store, name).await?);
            }
        }
        Ok(())
    }
}

/// Returns why pictures are refused, with a pointer into the spec.
fn refusal(error: &TargetFileError, asked: &[RequestedView], all_at: &str) -> ApiError {
    let TargetFileError::Bundle(error) = error else {
        return ApiError::refused(clean(&error.to_string(), REASON_CHARS)).at(all_at);
    };
    let words = error.to_string();
    match error {
        BundleError::TooLarge(_) => ApiError::too_large(words),
        BundleError::Pictures(PicturesError::View { index, error }) => {
            let most = match error {
                ViewError::Picture(_) | ViewError::Mask(_) => REASON_CHARS,
                ViewError::Large(..) | ViewError::Crop { .. } | ViewError::Target(_) => 500,
            };
            ApiError::refused(clean(&words, most)).at(pointer(error, &asked[*index]))
        }
        _ => ApiError::refused(clean(&words, 500)).at(all_at),
    }
}

fn pointer(error: &ViewError, one: &RequestedView) -> String {
    let at = |field: &str| format!("{}{field}", one.at);
    match error {
        ViewError::Picture(_) | ViewError::Large(..) => one.picture_at.clone(),
        ViewError::Mask(_) => at("/mask"),
        ViewError::Crop { .. } => at("/crop"),
        ViewError::Target(ImageTargetError::Small(..)) if one.crop.is_some() => at("/crop"),
        ViewError::Target(error) => match error {
            ImageTargetError::Small(..)
            | ImageTargetError::NotFinite(..)
            | ImageTargetError::Few(_) => one.picture_at.clone(),
            ImageTargetError::MaskSize { .. } | ImageTargetError::MaskEmpty => at("/mask"),
            ImageTargetError::Refine(_) => at("/refine"),
            ImageTargetError::Unlit => at("/scene/lights"),
            ImageTargetError::ClipFrom(_) => at("/clip_from"),
            ImageTargetError::Tone(_) => at("/scene/film/tone"),
            ImageTargetError::Nothing => at("/scene/camera"),
        },
    }
}

/// Describes a picture as it was understood.
pub fn describe(known: &KnownView) -> TargetView {
    TargetView {
        size_px: known.size_px(),
        crop: known.setting.crop.map(|area| [area.x, area.y, area.width, area.height]),
        scene: known.setting.scene.clone(),
        samples: known.setting.sampling,
        gain_solved: known.view.is_gain_unknown(),
        clip_from: known.setting.clip_from,
        clipped_from: Some(known.view.clipped_from()),
        held_out: known.setting.is_held_out,
        pixels: counted(known.view.counts()),
        refine: known.setting.refine,
        corrected: None,
    }
}

/// Converts the counts. Destructured without `..`, so that a new status cannot be forgotten.
fn counted(counts: PixelCounts) -> TargetPixels {
    let PixelCounts {
        pixels,
        used,
        masked,
        background,
        edge,
        clipped,
        unlit,
        half_lit,
        several_lights,
        grazing,
        outlier,
    } = counts;
    TargetPixels {
        pixels,
        used,
        masked,
        background,
        edge,
        clipped,
        unlit,
        half_lit,
        several_lights,
        grazing,
        outlier,
    }
}
