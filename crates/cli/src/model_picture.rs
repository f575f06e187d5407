//! Pictures outside the road of programs: of measured materials, and of whatever is compared; rough pixels are sampled again
//! as there.

use brood_brdf::Brdf;
use brood_eval::{
    Developed, Gain, RadianceImage, RoughTile, develop_samples, model_reflectance, rough_tiles,
    shade,
};
use brood_scene::{LightAssets, Mesh, PixelArea, Raster, SampleSet, Sampling, Scene};

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

/// How a picture is made.
pub struct Shot<'a> {
    pub mesh: &'a Mesh,
    pub scene: &'a Scene,
    pub assets: &'a LightAssets,
    pub size_px: u32,
    pub sampling: Sampling,
}

/// A picture, developed and as linear radiance.
pub struct Picture {
    pub developed: Developed,
    pub radiance: RadianceImage,
    /// Samples that were evaluated.
    pub samples: usize,
}

impl Shot<'_> {
    /// Takes the picture.
    pub fn take(&self, material: &(impl Shade + ?Sized)) -> Picture {
        let set = self.samples(self.sampling, PixelArea::whole(self.size_px));
        let mut f = Vec::new();
        material.shade(&set, &mut f);
        let gain = Gain::new(self.scene.film, &set, &f);
        let mut developed = develop_samples(&set, &f, gain);
        let mut radiance = shade(&set, &f);
        let mut samples = set.len();
        for rough in rough_tiles(&set, &developed) {
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
