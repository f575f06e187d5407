//! Comparison of a material with an image of a known scene: both as linear images at one exposure,
//! with their differences.

use brood_inspect::{LinearImage, Picture, Shade, Shot};
use brood_scene::PictureSize;
use brood_target::{ImageError, KnownView};

/// Image of a target and the rendered material in the same scene.
#[derive(Debug)]
pub struct ViewComparison {
    /// The target image, scaled to the material's brightness if its own is unknown.
    pub wanted: LinearImage,
    /// The rendered material.
    pub found: LinearImage,
    /// Difference in linear radiance.
    pub error: ImageError,
    /// Mean FLIP error of the exposed images.
    pub flip: f64,
    /// Exposure of both images, in EV: that of the scene, or the automatic exposure of the
    /// material.
    pub exposure_ev: f64,
}

impl ViewComparison {
    /// Renders a material in the scene of an image and compares the two.
    #[must_use]
    pub fn of(known: &KnownView, material: &(impl Shade + ?Sized)) -> Self {
        let (view, PictureSize { width, height }) = (&known.view, known.size_px());
        let taken = taken(known, material);
        let error = view.compare(&taken.radiance);
        let exposure_ev = taken.developed.exposure_ev;
        let gain_ev = if error.gain > 0.0 { libm::log2(error.gain) } else { 0.0 };
        let wanted = LinearImage::new(width, height, view.target().to_vec());
        let wanted = wanted.exposed(exposure_ev - gain_ev);
        let found = taken.linear(exposure_ev);
        let flip = wanted.flip(&found);
        Self { wanted, found, error, flip, exposure_ev }
    }
}

/// Renders a material in the scene of an image.
pub(crate) fn taken(known: &KnownView, material: &(impl Shade + ?Sized)) -> Picture {
    match known.view.is_soft() {
        false => shot(known).take_on(known.view.set(), material),
        true => shot(known).take_in_bands(material),
    }
}

/// Returns the parameters with which a picture was made.
fn shot(known: &KnownView) -> Shot<'_> {
    let setting = &known.setting;
    Shot {
        mesh: &setting.mesh,
        scene: &setting.scene,
        assets: &setting.assets,
        size_px: known.size_px(),
        sampling: setting.sampling,
    }
}
