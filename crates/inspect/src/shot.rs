//! Pictures outside the road of programs: of measured materials, and of whatever is compared; rough pixels are sampled again
//! as there.
//!
//! Owns the way from a material and what the camera sees to a picture. Refuses to know files, formats and who looks.

use brood_brdf::Brdf;
use brood_eval::{
    Developed, Gain, RadianceImage, RoughTile, develop_samples, model_reflectance, rough_tiles,
    shade,
};
use brood_scene::{LightAssets, Mesh, PixelArea, Raster, SampleSet, Sampling, Scene};

use crate::Specimen;

/// What gives the reflectance of samples.
pub trait Shade {
    /// `out` is made `3 * set.len()` long: red, green, blue, in each the samples in order.
    fn shade(&self, set: &SampleSet, out: &mut Vec<f32>);
}

impl Shade for dyn Brdf + '_ {
    fn shade(&self, set: &SampleSet, out: &mut Vec<f32>) {
        model_reflectance(self, set, out);
    }
}

impl Shade for Specimen<'_> {
    fn shade(&self, set: &SampleSet, out: &mut Vec<f32>) {
        Specimen::shade(self, set, out);
    }
}

/// How a picture is made.
#[derive(Debug, Clone, Copy)]
pub struct Shot<'a> {
    /// What is shown.
    pub mesh: &'a Mesh,
    /// How it is seen and lit, and its film.
    pub scene: &'a Scene,
    /// What the lights refer to.
    pub assets: &'a LightAssets,
    /// Side in pixels.
    pub size_px: u32,
    /// Samples per pixel.
    pub sampling: Sampling,
}

/// A picture, developed and as linear radiance.
#[derive(Debug, Clone)]
pub struct Picture {
    /// As the film shows it.
    pub developed: Developed,
    /// Before the film.
    pub radiance: RadianceImage,
    /// Samples that were evaluated.
    pub samples: usize,
}

impl Shot<'_> {
    /// Takes the picture.
    pub fn take(&self, material: &(impl Shade + ?Sized)) -> Picture {
        self.take_on(&self.set(), material)
    }

    /// What the camera sees, whatever the material.
    #[must_use]
    pub fn set(&self) -> SampleSet {
        self.samples(self.sampling, PixelArea::whole(self.size_px))
    }

    /// Takes the picture on what [`Shot::set`] gave before: of many materials it is traced once.
    pub fn take_on(&self, set: &SampleSet, material: &(impl Shade + ?Sized)) -> Picture {
        let mut f = Vec::new();
        material.shade(set, &mut f);
        let gain = Gain::new(self.scene.film, set, &f);
        let mut developed = develop_samples(set, &f, gain);
        let mut radiance = shade(set, &f);
        let mut samples = set.len();
        for rough in rough_tiles(set, &developed) {
            let RoughTile { tile, pixels, .. } = rough;
            let fine = self.samples(RoughTile::SAMPLING, tile);
            material.shade(&fine, &mut f);
            samples += fine.len();
            let image = shade(&fine, &f);
            for (pixel, within) in pixels {
                let (pixel, within) = (pixel as usize, within as usize);
                let coverage = image.coverage()[within];
                // Its centre hit, so this is 0 for nothing but the finest of slits.
                if coverage > 0.0 {
                    let value = image.premultiplied()[within].map(|channel| channel / coverage);
                    developed.put(pixel, value, gain);
                    radiance.put(pixel, value);
                }
            }
        }
        Picture { developed, radiance, samples }
    }

    fn samples(&self, sampling: Sampling, area: PixelArea) -> SampleSet {
        let raster = Raster { size_px: self.size_px, sampling, area };
        SampleSet::render_lit(self.mesh, self.scene, self.assets, raster)
    }
}
