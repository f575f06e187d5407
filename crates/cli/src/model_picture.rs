//! Pictures of models: as a program's are made, with rough pixels sampled again, by the models' own arithmetic.

use brood_brdf::Brdf;
use brood_eval::{
    Developed, Gain, RadianceImage, RoughTile, develop_samples, model_reflectance, rough_tiles,
    shade,
};
use brood_scene::{Mesh, SampleSet, Sampling, Scene};

/// How a picture is made.
pub struct Shot<'a> {
    pub mesh: &'a Mesh,
    pub scene: &'a Scene,
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
    pub fn take(&self, brdf: &dyn Brdf) -> Picture {
        let set = SampleSet::render(self.mesh, self.scene, self.size_px, self.sampling);
        let mut f = Vec::new();
        model_reflectance(brdf, &set, &mut f);
        let gain = Gain::new(self.scene.film.exposure, &set, &f);
        let mut developed = develop_samples(&set, &f, gain);
        let mut radiance = shade(&set, &f);
        let mut samples = set.len();
        for rough in rough_tiles(&set, &developed) {
            let RoughTile { tile, pixels, .. } = rough;
            let (mesh, scene) = (self.mesh, self.scene);
            let fine = SampleSet::render_area(mesh, scene, self.size_px, RoughTile::SAMPLING, tile);
            model_reflectance(brdf, &fine, &mut f);
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
}
