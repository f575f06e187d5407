//! Pictures of known scenes, decoded: each with the scene that it was made with, and all of them
//! joined to one target.
//!
//! Owns the conversion of encoded pictures and masks to views, and of views to a target. Shared by
//! the command line, the server and its workers. Does not depend on where the bytes come from.

use std::sync::Arc;

use brood_eval::{Developed, Gain, LinearPicture, LinearPictureError, decode_linear, picture_size};
use brood_light::LightAssets;
use brood_mesh::Mesh;
use brood_scene::{ClipFrom, Exposure, PictureSize, PixelArea, Refine, Sampling, Scene};

use crate::image::{ImageTargetError, ImageView, PixelCounts, PixelStatus, View, pooled};
use crate::{MeasuredTarget, Samples, TargetError};

/// Largest side of a picture in pixels, as for pictures rendered on the command line.
const SIDE_MOST: u32 = 4096;

/// Scene of a picture, and its role in the target.
#[derive(Debug, Clone)]
pub struct ViewSetup {
    /// Camera, lights and film.
    pub scene: Scene,
    /// Mesh that is shown.
    pub mesh: Arc<Mesh>,
    /// Assets that the lights refer to.
    pub assets: LightAssets,
    /// Sampling of its pixels.
    pub sampling: Sampling,
    /// True if its brightness is unknown.
    pub is_gain_unknown: bool,
    /// Code from which a channel counts as clipped.
    pub clip_from: ClipFrom,
    /// Part of the picture that the scene describes; `None` for all of it.
    pub crop: Option<PixelArea>,
    /// True if it is held out: not fitted, only compared with the result.
    pub is_held_out: bool,
    /// Uncertainties within which the scene may be corrected.
    pub refine: Refine,
}

/// A decoded picture of a known scene.
#[derive(Debug)]
pub struct KnownView {
    /// Scene and role.
    pub setting: ViewSetup,
    /// Classified pixels.
    pub view: ImageView,
    /// Exposure and tone curve of the scene's film.
    pub gain: Gain,
    /// True if it has a mask.
    pub is_masked: bool,
}

/// Error of reading a picture of a known scene.
#[derive(Debug, thiserror::Error)]
pub enum ViewError {
    /// The picture cannot be decoded.
    #[error(transparent)]
    Picture(LinearPictureError),
    /// The mask cannot be decoded.
    #[error("the mask cannot be read: {0}")]
    Mask(LinearPictureError),
    /// The picture is too large.
    #[error("a picture has at most {SIDE_MOST} x {SIDE_MOST} pixels; this one has {0} x {1}")]
    Large(u32, u32),
    /// The crop is empty or reaches beyond the picture.
    #[error(
        "the crop {area} must lie within the picture, which has {} x {} pixels, and must not be empty",
        size_px.width, size_px.height
    )]
    Crop {
        /// Requested crop.
        area: PixelArea,
        /// Size of the whole picture.
        size_px: PictureSize,
    },
    /// The picture cannot be used as a target.
    #[error(transparent)]
    Target(#[from] ImageTargetError),
}

impl KnownView {
    /// Largest side in pixels.
    pub const SIDE_MOST: u32 = SIDE_MOST;

    /// Decodes a picture and its mask, and crops both; also returns the reflectance at the usable
    /// pixels.
    ///
    /// # Errors
    /// Returns [`ViewError`] if the picture or the mask cannot be decoded, is too large, or cannot
    /// be used as a target, or if the crop reaches beyond the picture.
    pub fn read(
        setting: ViewSetup,
        picture: &[u8],
        mask: Option<&[u8]>,
    ) -> Result<(Self, Samples), ViewError> {
        let (width, height) = picture_size(picture).map_err(ViewError::Picture)?;
        if width.max(height) > SIDE_MOST {
            return Err(ViewError::Large(width, height));
        }
        let size_px = PictureSize { width, height };
        if let Some(area) = setting.crop.filter(|area| !area.is_within(size_px)) {
            return Err(ViewError::Crop { area, size_px });
        }
        let picture = decode_linear(picture, SIDE_MOST).map_err(ViewError::Picture)?;
        let mask = mask.map(|mask| decode_linear(mask, SIDE_MOST)).transpose();
        let mask = mask.map_err(ViewError::Mask)?;
        let (picture, mask) = match setting.crop {
            Some(area) => crop(area, &picture, mask.as_ref())?,
            None => (picture, mask),
        };
        let view = View {
            mesh: &setting.mesh,
            scene: &setting.scene,
            assets: &setting.assets,
            sampling: setting.sampling,
            picture: &picture,
            mask: mask.as_ref(),
            is_gain_unknown: setting.is_gain_unknown,
            clip_from: setting.clip_from,
            refine: setting.refine,
        };
        let (view, samples) = ImageView::new(&view)?;
        let gain = gain(&setting.scene, &picture, &view);
        Ok((Self { setting, view, gain, is_masked: mask.is_some() }, samples))
    }

    /// Returns the same picture in a corrected scene, and the reflectance at the usable pixels. The
    /// radiance of red, green and blue is divided by `balance`.
    ///
    /// # Errors
    /// Returns [`ViewError::Target`] if nothing lit is seen in that scene.
    pub fn in_scene(&self, scene: Scene, balance: [f64; 3]) -> Result<(Self, Samples), ViewError> {
        let setting = ViewSetup { scene, ..self.setting.clone() };
        let (view, samples) =
            self.view.in_scene(&setting.mesh, (&setting.scene, &setting.assets), balance)?;
        Ok((Self { setting, view, ..*self }, samples))
    }

    /// Size of the picture.
    #[must_use]
    pub fn size_px(&self) -> PictureSize {
        self.view.set().image().expect("the set has a picture layout").size_px
    }

    /// The picture as displayed by the scene's film.
    #[must_use]
    pub fn shown(&self) -> Developed {
        let PictureSize { width, height } = self.size_px();
        let pixels = self.view.target();
        let rgba = vec![u8::MAX; 4 * pixels.len()];
        let exposure_ev = self.gain.ev;
        let mut shown = Developed { width, height, rgba, exposure_ev };
        for (pixel, radiance) in pixels.iter().enumerate() {
            #[expect(clippy::cast_possible_truncation, reason = "what is shown has 8 bits")]
            shown.put(pixel, radiance.map(|channel| channel as f32), self.gain);
        }
        shown
    }

    /// Approximate memory use in bytes.
    #[must_use]
    pub fn bytes(&self) -> usize {
        self.view.set().bytes() + 32 * self.view.target().len()
    }
}

/// Crops a picture and its mask, which has the size of the whole picture.
fn crop(
    area: PixelArea,
    picture: &LinearPicture,
    mask: Option<&LinearPicture>,
) -> Result<(LinearPicture, Option<LinearPicture>), ViewError> {
    let size = |of: &LinearPicture| PictureSize { width: of.width, height: of.height };
    let size_px = size(picture);
    if let Some(mask_px) = mask.map(size).filter(|mask_px| *mask_px != size_px) {
        return Err(ImageTargetError::MaskSize { mask_px, size_px }.into());
    }
    Ok((picture.cropped(area), mask.map(|mask| mask.cropped(area))))
}

/// Exposure and tone curve for displaying a picture's radiance. A picture of display codes with
/// unknown exposure is displayed unchanged.
fn gain(scene: &Scene, picture: &LinearPicture, view: &ImageView) -> Gain {
    let film = scene.film;
    let gain = match film.exposure {
        Exposure::Ev(ev) => Gain::fixed(ev),
        Exposure::Auto if !picture.is_linear => Gain::fixed(0.0),
        Exposure::Auto => {
            let shows = |status: PixelStatus| {
                !matches!(status, PixelStatus::Masked | PixelStatus::Background)
            };
            let pixels = picture.pixels.iter().zip(view.statuses());
            let seen = pixels.filter(|(_, status)| shows(**status));
            Gain::automatic(seen.map(|(pixel, _)| pixel[0].max(pixel[1]).max(pixel[2])).collect())
        }
    };
    gain.with_tone(film.tone)
}

/// Pictures of one material.
#[derive(Debug)]
pub struct Pictures {
    /// Views in the order in which they were given.
    pub views: Vec<KnownView>,
    /// Number of pixels by status, of all views that are not held out.
    pub counts: PixelCounts,
}

/// Error of joining pictures to a target.
#[derive(Debug, thiserror::Error)]
pub enum PicturesError {
    /// A view cannot be read.
    #[error("{error}")]
    View {
        /// Index of the view, from 0.
        index: usize,
        /// Reason.
        error: ViewError,
    },
    /// All pictures are held out.
    #[error("every picture is held out, so nothing is left to fit")]
    HeldOut,
    /// All pictures together have too few usable pixels.
    #[error(transparent)]
    Few(ImageTargetError),
    /// The reflectances cannot be matched.
    #[error(transparent)]
    Target(#[from] TargetError),
}

impl Pictures {
    /// Joins views, and splits the samples of the fitted ones into a fitted and a held-out part.
    ///
    /// # Errors
    /// Returns [`PicturesError`] if a view cannot be read, all are held out, or too few pixels are
    /// usable.
    pub fn gather(
        views: impl IntoIterator<Item = Result<(KnownView, Samples), ViewError>>,
    ) -> Result<(Self, MeasuredTarget), PicturesError> {
        let (mut read, mut fitted) = (Vec::new(), Vec::new());
        for (index, view) in views.into_iter().enumerate() {
            let (view, samples) = view.map_err(|error| PicturesError::View { index, error })?;
            if !view.setting.is_held_out {
                fitted.push((index, samples));
            }
            read.push(view);
        }
        if fitted.is_empty() {
            return Err(PicturesError::HeldOut);
        }
        let together = pooled(fitted.iter().map(|(index, samples)| (&read[*index].view, samples)));
        let (samples, counts) = together.map_err(PicturesError::Few)?;
        let target = MeasuredTarget::of_pixels(&samples)?;
        Ok((Self { views: read, counts }, target))
    }

    /// Approximate memory use in bytes.
    #[must_use]
    pub fn bytes(&self) -> usize {
        self.views.iter().map(KnownView::bytes).sum()
    }
}
