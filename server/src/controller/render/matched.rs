//! Individual rendered to match a target: in the scene of one of its pictures, or at the target's
//! exposure.
//!
//! These pictures are drawn by the server, like the target's own, and not by workers.

use std::sync::Arc;

use axum::response::Response;
use brood_inspect::{Picture, Shade, Shot, Specimen};
use brood_protocol::{PictureFormat, SceneId, Target, TargetId};
use brood_scene::{Exposure, Sampling};
use brood_storage::{StorageError, StoredIndividual};
use brood_target::KnownView;
use http::HeaderMap;

use super::{CACHE, SIZE, check_rays, content_type};
use crate::controller::file::FileHead;
use crate::controller::target_picture::{
    IN_ITS_SCENE, check_view, draw_measured, key_hasher, shot, view_bytes,
};

use crate::library::Material;
use crate::problem::ApiError;
use crate::state::App;
use crate::target_cache::{Drawn, TargetCache, ViewParams};

/// Request, checked as far as possible without the target.
pub struct MatchedRender {
    /// Target to match.
    pub target: TargetId,
    /// Index of the target's picture, if given.
    pub view: Option<u32>,
    /// Side in pixels, if given.
    pub size_px: Option<u32>,
    /// Scene, if given.
    pub scene: Option<SceneId>,
    /// Light angle in degrees, if given.
    pub light_deg: Option<f64>,
    /// Samples per pixel, if given.
    pub sampling: Option<Sampling>,
    /// File format.
    pub format: PictureFormat,
}

impl MatchedRender {
    /// Answers the request.
    ///
    /// # Errors
    /// [`ApiError`] if the target is missing, the options do not fit it, or drawing fails.
    pub async fn answer(
        self,
        app: &App,
        individual: &StoredIndividual,
        headers: &HeaderMap,
    ) -> Result<Response, ApiError> {
        let target = app.store.target(self.target).await.map_err(|error| match error {
            StorageError::NotFound => ApiError::not_found("there is no target with this id"),
            other => other.into(),
        })?;
        let material = app.library.material(individual.hash).await?;
        if target.views.is_empty() {
            return self.at_target_exposure(app, &target, (individual, material), headers).await;
        }
        self.in_target_scene(app, &target, material, headers).await
    }

    /// Draws the individual in the scene of the target's picture.
    async fn in_target_scene(
        self,
        app: &App,
        target: &Target,
        material: Arc<Material>,
        headers: &HeaderMap,
    ) -> Result<Response, ApiError> {
        let Self { size_px, sampling, format, .. } = self;
        if self.scene.is_some() || self.light_deg.is_some() {
            return Err(ApiError::refused(IN_ITS_SCENE));
        }
        let n = self.view.unwrap_or(0);
        check_view(target, n)?;
        let own = &target.views[n as usize];
        let size = size_px.unwrap_or(own.size_px);
        check_rays(u64::from(size).pow(2), sampling.unwrap_or(own.samples))?;
        let mut hasher = key_hasher("laid over", target);
        hasher.update(&n.to_le_bytes()).update(&size.to_le_bytes());
        hasher.update(sampling.unwrap_or(own.samples).to_string().as_bytes());
        hasher.update(material.program.hash().as_bytes()).update(format!("{format:?}").as_bytes());
        let key = hasher.finalize();
        let etag = format!("\"{}\"", key.to_hex());
        let head = FileHead { etag, content_type: content_type(format), cache: CACHE };
        let prepare = async {
            let known = TargetCache::view(app, target, n).await?;
            Ok(move || {
                let specimen = Specimen::Bred(&material.genome, &material.program);
                Drawn::of(&in_target_scene(&known, &specimen, size, sampling), format)
            })
        };
        head.made(headers, TargetCache::picture(app, key, prepare)).await
    }

    /// Draws the individual in any scene and light, at the exposure of the measured target there.
    async fn at_target_exposure(
        self,
        app: &App,
        target: &Target,
        (individual, material): (&StoredIndividual, Arc<Material>),
        headers: &HeaderMap,
    ) -> Result<Response, ApiError> {
        let format = self.format;
        if self.view.is_some() {
            return Err(ApiError::refused(
                "`view` is only allowed for image targets; this one is measured",
            ));
        }
        let scene = match self.scene {
            Some(scene) => scene,
            None => app.store.lineage(individual.lineage).await?.scene,
        };
        let size_px = self.size_px.unwrap_or(SIZE);
        let sampling = self.sampling.unwrap_or_default();
        check_rays(u64::from(size_px).pow(2), sampling)?;
        let view = ViewParams { scene, light_deg: self.light_deg, size_px, sampling };
        let mut hasher = key_hasher("exposed as", target);
        hasher.update(&view_bytes(view)).update(material.program.hash().as_bytes());
        hasher.update(format!("{format:?}").as_bytes());
        let key = hasher.finalize();
        let etag = format!("\"{}\"", key.to_hex());
        let head = FileHead { etag, content_type: content_type(format), cache: CACHE };
        let prepare = async {
            let ev = draw_measured(app, target, view, None).await?.exposure_ev;
            let traced = TargetCache::traced_view(app, view).await?;
            Ok(move || {
                let specimen = Specimen::Bred(&material.genome, &material.program);
                Drawn::of(&traced.render(&specimen, Some(ev)), format)
            })
        };
        head.made(headers, TargetCache::picture(app, key, prepare)).await
    }
}

/// Draws a material in the scene of a picture, as bright as the picture is shown.
///
/// If the picture's gain is unknown, uses the gain that minimises the difference between the two.
fn in_target_scene(
    known: &KnownView,
    material: &impl Shade,
    size_px: u32,
    sampling: Option<Sampling>,
) -> Picture {
    let mut scene = known.setting.scene.clone();
    let ev = known.gain.ev;
    scene.film.exposure = Exposure::Ev(ev);
    if known.view.is_gain_unknown() {
        let picture = shot(known, &scene).take_on(known.view.set(), material);
        let gain = known.view.compare(&picture.radiance).gain;
        if gain > 0.0 {
            scene.film.exposure = Exposure::Ev(ev + libm::log2(gain));
        }
    }
    let own = shot(known, &scene);
    let sampling = sampling.unwrap_or(own.sampling);
    if (size_px, sampling) == (own.size_px, own.sampling) {
        return own.take_on(known.view.set(), material);
    }
    Shot { size_px, sampling, ..own }.take(material)
}
