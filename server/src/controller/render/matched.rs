//! Individual rendered to match a target: in the scene of one of its pictures, or at the target's
//! exposure.

use axum::response::Response;
use brood_protocol::{
    Backend, Frame, PictureFormat, SceneId, Subject, Target, TargetId, TargetSource,
};
use brood_scene::{PictureSize, Sampling};
use brood_storage::{StorageError, StoredIndividual};
use http::HeaderMap;

use crate::controller::file::{FileHead, REVALIDATED};
use crate::controller::picture_query::{SIZE, check_rays, content_type};
use crate::controller::target_picture::{IN_ITS_SCENE, source, view, view_frame};
use crate::dispatch::PictureRequest;
use crate::library::Framing;
use crate::problem::ApiError;
use crate::state::App;

/// Request, checked as far as possible without the target.
pub struct MatchedRender {
    /// Target to match.
    pub target: TargetId,
    /// Index of the target's picture, if given.
    pub view: Option<u32>,
    /// Size, if given.
    pub size_px: Option<PictureSize>,
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
        let (frame, source) = match target.views.is_empty() {
            true => self.in_any_scene(app, &target, individual).await?,
            false => self.in_target_scene(&target)?,
        };
        let material = app.library.brdf(individual.hash).await?;
        let request = PictureRequest::own(frame, &Subject::Matched(material, source));
        let head = FileHead::of_picture(request.key(), content_type(self.format), REVALIDATED);
        head.made(headers, app.pictures.get(request)).await
    }

    /// Returns the frame of the target's picture.
    fn in_target_scene(&self, target: &Target) -> Result<(Frame, TargetSource), ApiError> {
        if self.scene.is_some() || self.light_deg.is_some() {
            return Err(ApiError::refused(IN_ITS_SCENE));
        }
        let n = self.view.unwrap_or(0);
        let own = view(target, n)?;
        let size_px = self.size_px.unwrap_or(own.size_px);
        let sampling = self.sampling.unwrap_or(own.samples);
        check_rays(size_px.pixels(), sampling)?;
        let scene = own.corrected.as_ref().map_or(&own.scene, |corrected| &corrected.scene);
        let frame = view_frame(scene, size_px, sampling, self.format);
        Ok((frame, source(target, Some(n))?))
    }

    /// Returns the frame of a measured target, in any scene and light.
    async fn in_any_scene(
        &self,
        app: &App,
        target: &Target,
        individual: &StoredIndividual,
    ) -> Result<(Frame, TargetSource), ApiError> {
        if self.view.is_some() {
            return Err(ApiError::refused(
                "`view` is only allowed for image targets; this one is measured",
            ));
        }
        let scene = match self.scene {
            Some(scene) => scene,
            None => app.store.lineage(individual.lineage).await?.scene,
        };
        let size_px = self.size_px.unwrap_or(SIZE.into());
        let sampling = self.sampling.unwrap_or_default();
        check_rays(size_px.pixels(), sampling)?;
        let view = Framing {
            light_deg: self.light_deg,
            sampling,
            format: self.format,
            ..Framing::png(scene, size_px, Backend::Auto)
        };
        Ok((app.library.frame(view).await?.frame.clone(), source(target, None)?))
    }
}
