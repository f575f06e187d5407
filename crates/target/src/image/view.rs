//! A picture with its scene.

use brood_eval::LinearPicture;
use brood_light::LightAssets;
use brood_mesh::Mesh;
use brood_scene::{ClipFrom, Refine, Sampling, Scene};

/// A picture with its scene and everything else that it was made with.
#[derive(Debug, Clone, Copy)]
pub struct View<'a> {
    /// Mesh that is shown.
    pub mesh: &'a Mesh,
    /// Camera, lights and film.
    pub scene: &'a Scene,
    /// Assets that the lights refer to.
    pub assets: &'a LightAssets,
    /// Sampling of its pixels.
    pub sampling: Sampling,
    /// Decoded picture.
    pub picture: &'a LinearPicture,
    /// Mask: white at the pixels to use.
    pub mask: Option<&'a LinearPicture>,
    /// True if the brightness is unknown. It is always unknown for pictures with automatic
    /// exposure.
    pub is_gain_unknown: bool,
    /// Code from which a channel counts as clipped.
    pub clip_from: ClipFrom,
    /// Uncertainties within which the scene will be corrected.
    pub refine: Refine,
}
