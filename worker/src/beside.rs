//! A material held against a picture of a known scene: both as linear light at one exposure, and how far they are apart.
//!
//! Owns the exposure that they have in common and the figures. Refuses to know what becomes of them.

use brood_inspect::{LinearImage, Shade, Shot};
use brood_search::{ImageError, KnownView};

/// A picture and what a material looks like in its scene.
#[derive(Debug)]
pub struct Beside {
    /// The picture, as bright as the material where its brightness is not known.
    pub wanted: LinearImage,
    /// The material.
    pub found: LinearImage,
    /// How far apart they are as linear radiance.
    pub error: ImageError,
    /// Mean FLIP error of both as exposed.
    pub flip: f64,
    /// The exposure of both: the scene's own, or what is automatic for the material.
    pub exposure_ev: f64,
}

impl Beside {
    /// Draws a material in the scene of a picture.
    #[must_use]
    pub fn of(known: &KnownView, material: &(impl Shade + ?Sized)) -> Self {
        let (setting, view, side) = (&known.setting, &known.view, known.side());
        let shot = Shot {
            mesh: &setting.mesh,
            scene: &setting.scene,
            assets: &setting.assets,
            size_px: side,
            sampling: setting.sampling,
        };
        let taken = shot.take_on(view.set(), material);
        let error = view.compare(&taken.radiance);
        let exposure_ev = taken.developed.exposure_ev;
        let gain_ev = if error.gain > 0.0 { libm::log2(error.gain) } else { 0.0 };
        let linear = |pixels: Vec<[f64; 3]>| LinearImage::new(side, side, pixels);
        let wanted = linear(view.wanted().to_vec()).exposed(exposure_ev - gain_ev);
        let found = taken.radiance.premultiplied().iter().map(|pixel| pixel.map(f64::from));
        let found = linear(found.collect()).exposed(exposure_ev);
        let flip = wanted.flip(&found);
        Self { wanted, found, error, flip, exposure_ev }
    }
}
