//! An individual beside a target: drawn in the scene of one of its pictures, or exposed as the target is.
//!
//! Such pictures belong to the target, so they are drawn where its own are, and not by workers.

use std::sync::Arc;

use axum::response::Response;
use brood_inspect::{Picture, Shade, Shot, Specimen};
use brood_protocol::{PictureFormat, SceneId, Target, TargetId};
use brood_scene::{Exposure, Sampling};
use brood_search::KnownView;
use brood_storage::{StorageError, StoredIndividual};
use http::HeaderMap;

use super::{CACHE, SIZE, check_rays, content_type};
use crate::controller::file::FileHead;
use crate::controller::target_picture::{
    IN_ITS_SCENE, begun, check_view, measured, shot, stage_bytes,
};

use crate::library::Material;
use crate::problem::ApiError;
use crate::shelf::{Drawn, Shelf, StageView};
use crate::state::App;

/// What is asked for, checked as far as it can be without the target.
pub struct Beside {
    pub target: TargetId,
    pub view: Option<u32>,
    pub size_px: Option<u32>,
    pub scene: Option<SceneId>,
    pub light_deg: Option<f64>,
    /// Where it was given.
    pub sampling: Option<Sampling>,
    pub format: PictureFormat,
}

impl Beside {
    /// The picture.
    pub async fn answer(
        self,
        app: &App,
        individual: &StoredIndividual,
        headers: &HeaderMap,
    ) -> Result<Response, ApiError> {
        let target = app.store.target(self.target).await.map_err(|error| match error {
            StorageError::NotFound => ApiError::not_found("there is no target with that id"),
            other => other.into(),
        })?;
        let material = app.library.material(individual.hash).await?;
        if target.views.is_empty() {
            return self.exposed(app, &target, (individual, material), headers).await;
        }
        self.laid_over(app, &target, material, headers).await
    }

    /// In the scene of a picture.
    async fn laid_over(
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
        let mut hasher = begun("laid over", target);
        hasher.update(&n.to_le_bytes()).update(&size.to_le_bytes());
        hasher.update(sampling.unwrap_or(own.samples).to_string().as_bytes());
        hasher.update(material.program.hash().as_bytes()).update(format!("{format:?}").as_bytes());
        let key = hasher.finalize();
        let etag = format!("\"{}\"", key.to_hex());
        let head = FileHead { etag, content_type: content_type(format), cache: CACHE };
        let prepare = async {
            let known = Shelf::view(app, target, n).await?;
            Ok(move || {
                let specimen = Specimen::Bred(&material.genome, &material.program);
                Drawn::of(&laid_over(&known, &specimen, size, sampling), format)
            })
        };
        head.made(headers, Shelf::drawn(app, key, prepare)).await
    }

    /// Under any light, as a measured target is exposed there.
    async fn exposed(
        self,
        app: &App,
        target: &Target,
        (individual, material): (&StoredIndividual, Arc<Material>),
        headers: &HeaderMap,
    ) -> Result<Response, ApiError> {
        let format = self.format;
        if self.view.is_some() {
            return Err(ApiError::refused("a measured material has no pictures of its own"));
        }
        let scene = match self.scene {
            Some(scene) => scene,
            None => app.store.lineage(individual.lineage).await?.scene,
        };
        let size_px = self.size_px.unwrap_or(SIZE);
        let sampling = self.sampling.unwrap_or_default();
        check_rays(u64::from(size_px).pow(2), sampling)?;
        let view = StageView { scene, light_deg: self.light_deg, size_px, sampling };
        let mut hasher = begun("exposed as", target);
        hasher.update(&stage_bytes(view)).update(material.program.hash().as_bytes());
        hasher.update(format!("{format:?}").as_bytes());
        let key = hasher.finalize();
        let etag = format!("\"{}\"", key.to_hex());
        let head = FileHead { etag, content_type: content_type(format), cache: CACHE };
        let prepare = async {
            let ev = measured(app, target, view, None).await?.exposure_ev;
            let stage = Shelf::stage(app, view).await?;
            Ok(move || {
                let specimen = Specimen::Bred(&material.genome, &material.program);
                Drawn::of(&stage.take(&specimen, Some(ev)), format)
            })
        };
        head.made(headers, Shelf::drawn(app, key, prepare)).await
    }
}

/// A material in the scene of a picture, as bright as the picture is shown.
///
/// Where the picture's brightness is not known, the material's is made that of the picture by the gain that brings them nearest.
fn laid_over(
    known: &KnownView,
    material: &impl Shade,
    size_px: u32,
    sampling: Option<Sampling>,
) -> Picture {
    let mut scene = known.setting.scene.clone();
    let ev = known.gain.ev;
    scene.film.exposure = Exposure::Ev(ev);
    if known.view.is_gain_unknown() {
        let taken = shot(known, &scene).take_on(known.view.set(), material);
        let gain = known.view.compare(&taken.radiance).gain;
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
