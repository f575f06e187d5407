//! Reports of searches of pictures: corrected scenes, and the spread of the materials that match.

use brood_eval::picture_size;
use brood_protocol::{
    CalibratedView, CorrectedScene, Directive, MaterialSpread, ReportedSpread, SceneCorrection,
};
use brood_scene::Scene;
use brood_storage::{StorageError, StoredSearch};

use super::Searches;
use crate::problem::ApiError;

/// Largest side of the pictures of a spread.
const SPREAD_PX: u32 = 512;
/// Largest size of such a picture: twice its pixels, for PNGs that did not compress.
const SPREAD_BYTES: usize = 2 * 4 * 512 * 512;
/// First bytes of a PNG.
const PNG_SIGNATURE: &[u8] = b"\x89PNG\r\n\x1a\n";
/// Largest number of rows of the maps of a spread.
const SPREAD_CELLS: u32 = 90;

impl Searches {
    /// Stores the corrected scenes of the target's images.
    pub(super) async fn take_scenes(
        &self,
        search: &StoredSearch,
        views: Vec<CalibratedView>,
    ) -> Result<Directive, ApiError> {
        let target = match self.store.target(search.target).await {
            Ok(target) => target,
            Err(StorageError::NotFound) => return Ok(Directive::Continue),
            Err(error) => return Err(error.into()),
        };
        if target.views.len() != views.len() {
            return Err(ApiError::refused("a report must have a scene for each image"));
        }
        let read = |CalibratedView { scene, corrections }: CalibratedView| {
            if corrections.is_empty() {
                return Ok(None);
            }
            let scene: Scene = serde_json::from_str(&scene)
                .map_err(|error| ApiError::refused(format!("a corrected scene: {error}")))?;
            scene.validate()?;
            let of = |one: &SceneCorrection| [one.value, one.stated_deviation, one.deviation];
            if !corrections.iter().flat_map(of).all(f64::is_finite) {
                return Err(ApiError::refused("corrections must be finite"));
            }
            Ok(Some(CorrectedScene { scene, corrections }))
        };
        let corrected = views.into_iter().map(read).collect::<Result<Vec<_>, ApiError>>()?;
        self.store.correct_target(search.target, corrected).await?;
        Ok(Directive::Continue)
    }

    /// Stores the spread of the materials that match the pictures of the target.
    pub(super) async fn take_spread(
        &self,
        search: &StoredSearch,
        reported: &ReportedSpread,
    ) -> Result<Directive, ApiError> {
        let spread: MaterialSpread = serde_json::from_str(&reported.spread)
            .map_err(|error| ApiError::refused(format!("a spread: {error}")))?;
        let MaterialSpread { e_log, cells, seen, deviation, next, .. } = &spread;
        let count = u64::from(*cells).pow(2);
        if *cells > SPREAD_CELLS || [seen, deviation].iter().any(|map| map.len() as u64 != count) {
            return Err(ApiError::refused("a spread must have maps of at most 90 x 90 cells"));
        }
        let numbers = seen.iter().chain(deviation).chain([e_log]);
        if !numbers.chain(next.iter().map(|next| &next.e_log)).all(|number| number.is_finite()) {
            return Err(ApiError::refused("a spread must have finite numbers"));
        }
        if let Some(next) = next {
            next.scene.validate()?;
        }
        let pictures = [&reported.darkest, &reported.brightest].map(Vec::as_slice);
        let is_small = |side: u32| (1..=SPREAD_PX).contains(&side);
        for picture in pictures {
            // Only a picture of these sides is sent to a browser.
            let size = picture_size(picture).ok();
            let is_small = size.is_some_and(|(width, height)| is_small(width) && is_small(height));
            if !is_small || !picture.starts_with(PNG_SIGNATURE) || picture.len() > SPREAD_BYTES {
                return Err(ApiError::refused("a spread must have PNGs of at most 512 x 512"));
            }
        }
        self.store.set_search_spread(search.id, &spread, pictures).await?;
        Ok(Directive::Continue)
    }
}
