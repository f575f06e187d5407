//! Why a picture is no target.

use super::{FEWEST, PixelCounts, SIDE};

/// Why a picture is no target.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum ImageTargetError {
    /// Scenes make square ones.
    #[error("pictures of a scene are square; this one has {0} x {1} pixels")]
    NotSquare(u32, u32),
    /// Too small to say anything.
    #[error("a picture of {0} x {0} pixels is too small; it has at least {SIDE} x {SIDE}")]
    Small(u32),
    /// NaN or infinite.
    #[error("the pixel {0}, {1} is not a finite number")]
    NotFinite(u32, u32),
    /// Of another size than the picture.
    #[error("the mask has {mask_width} x {mask_height} pixels and the picture {side} x {side}")]
    MaskSize {
        /// The mask's.
        mask_width: u32,
        /// The mask's.
        mask_height: u32,
        /// The picture's.
        side: u32,
    },
    /// Nothing is left.
    #[error("the mask leaves no pixel: pixels that are looked at are white in it")]
    MaskEmpty,
    /// Light from an extent cannot be told apart by direction.
    #[error(
        "the scene has a light of kind {0}, which shines from many directions at once; a target is lit by point, spot, \
         directional and ies lights"
    )]
    Light(&'static str),
    /// A curve without a way back.
    #[error(
        "the scene's tone curve is {0}, which cannot be undone; give the picture as linear EXR, or with the curve none or reinhard"
    )]
    Tone(&'static str),
    /// The camera looks past it.
    #[error("the camera of the scene sees nothing of the mesh")]
    Nothing,
    /// Dark all over.
    #[error("no light of the scene reaches anything that the camera sees")]
    Unlit,
    /// Too little is left.
    #[error("{used} pixels can be used and {FEWEST} are needed: {0}", used = .0.used)]
    Few(PixelCounts),
}
