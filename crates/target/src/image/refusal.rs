//! Checks of pictures before rays are traced, and errors of those that cannot be targets.

use brood_eval::LinearPicture;
use brood_scene::PictureSize;

use super::pixel::PixelCounts;
use super::soft::soft_light;
use super::view::View;
use crate::measured::FEWEST;

/// Least width and height of a picture, in pixels.
pub(super) const SIDE: u32 = 8;

/// Error of using a picture as a target.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum ImageTargetError {
    /// The picture is too small.
    #[error("a picture of {0} x {1} pixels is too small; the least is {SIDE} x {SIDE}")]
    Small(u32, u32),
    /// A pixel is NaN or infinite.
    #[error("the pixel {0}, {1} is not a finite number")]
    NotFinite(u32, u32),
    /// The mask's size differs from the picture's.
    #[error(
        "the mask has {} x {} pixels and the picture {} x {}; both must be equal",
        mask_px.width, mask_px.height, size_px.width, size_px.height
    )]
    MaskSize {
        /// Size of the mask.
        mask_px: PictureSize,
        /// Size of the picture.
        size_px: PictureSize,
    },
    /// The mask excludes every pixel.
    #[error("the mask leaves no pixel; it must be white where the picture is used")]
    MaskEmpty,
    /// Uncertainties of a scene with a light that shines from many directions.
    #[error(
        "the scene has a light of kind {0}, which shines from many directions at once; such scenes \
         cannot be corrected yet, so leave out `refine`"
    )]
    Refine(&'static str),
    /// A tone curve that cannot be inverted.
    #[error(
        "the scene's tone curve is {0}, which cannot be undone; give the picture as linear EXR, or with the curve none or reinhard"
    )]
    Tone(&'static str),
    /// A code in a picture that has none.
    #[error(
        "`clip_from` is {0}, but a picture of linear light has no codes; use \"auto\" or \"off\""
    )]
    ClipFrom(u8),
    /// The camera does not see the mesh.
    #[error("the camera of the scene sees nothing of the mesh")]
    Nothing,
    /// No visible point is lit.
    #[error("no light of the scene reaches anything that the camera sees")]
    Unlit,
    /// Too few usable pixels.
    #[error("{usable} pixels can be used and {FEWEST} are needed: {0}", usable = .0.usable())]
    Few(PixelCounts),
}

pub(super) fn is_white(pixel: [f32; 3]) -> bool {
    pixel.iter().all(|value| *value > 0.2)
}

/// Checks everything that needs no rays; returns the size of the picture.
pub(super) fn check(view: &View<'_>) -> Result<PictureSize, ImageTargetError> {
    let LinearPicture { width, height, ref pixels, .. } = *view.picture;
    let size_px = PictureSize { width, height };
    if size_px.shorter() < SIDE {
        return Err(ImageTargetError::Small(width, height));
    }
    if let Some(mask) = view.mask {
        let mask_px = PictureSize { width: mask.width, height: mask.height };
        if mask_px != size_px {
            return Err(ImageTargetError::MaskSize { mask_px, size_px });
        }
        if !mask.pixels.iter().any(|pixel| is_white(*pixel)) {
            return Err(ImageTargetError::MaskEmpty);
        }
    }
    if let Some(at) = pixels.iter().position(|pixel| pixel.iter().any(|value| !value.is_finite())) {
        let at = u32::try_from(at).expect("pictures have fewer pixels");
        return Err(ImageTargetError::NotFinite(at % width, at / width));
    }
    match soft_light(view.scene) {
        Some(light) if !view.refine.is_exact() => Err(ImageTargetError::Refine(light.kind())),
        _ => Ok(size_px),
    }
}
