//! Pictures of materials that need not be programs, such as measured ones. Rough pixels (those that
//! one sample cannot represent, see docs/maths/film.md) are resampled as a worker does in pictures
//! of programs.

use std::convert::Infallible;

use brood_brdf::Brdf;
use brood_eval::{
    Developed, Gain, LitBackdrop, RadianceImage, Refinement, RoughTile, develop, develop_samples,
    is_prefilterable, model_reflectance, refine_radiance, rough_tiles, shade,
};
use brood_light::LightAssets;
use brood_mesh::Mesh;
use brood_scene::{
    Exposure, LightTerms, LobeShape, PictureSize, PixelArea, PixelTerms, Raster, SampleSet,
    Sampling, Scene,
};

use crate::{LinearImage, Specimen};

/// Number of rows of a band.
const BAND: u32 = 16;

/// A material that can be evaluated on a sample set.
pub trait Shade {
    /// Evaluates f for the samples of `set`.
    ///
    /// # Shapes
    /// `out` is resized to `3 * set.len()`: all red values in the order of the samples, then all
    /// green, then all blue.
    fn shade(&self, set: &SampleSet, out: &mut Vec<f32>);

    /// True if it is known to be isotropic and the same everywhere.
    fn is_prefilterable(&self) -> bool {
        false
    }
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

    fn is_prefilterable(&self) -> bool {
        match self {
            Specimen::Bred(_, program) => is_prefilterable(program),
            Specimen::Measured(_) => false,
        }
    }
}

/// Scene and size of a picture: everything but the material.
#[derive(Debug, Clone, Copy)]
pub struct Shot<'a> {
    /// Object.
    pub mesh: &'a Mesh,
    /// Camera, lights and film.
    pub scene: &'a Scene,
    /// Profiles and environments of the lights.
    pub assets: &'a LightAssets,
    /// Size of the picture.
    pub size_px: PictureSize,
    /// Samples per pixel.
    pub sampling: Sampling,
}

/// Picture, developed and as linear radiance.
#[derive(Debug, Clone)]
pub struct Picture {
    /// Picture after the film.
    pub developed: Developed,
    /// Radiance before the film.
    pub radiance: RadianceImage,
    /// Number of samples evaluated.
    pub samples: usize,
}

impl Picture {
    /// Returns the radiance after exposure, composed over black.
    #[must_use]
    pub fn linear(&self, exposure_ev: f64) -> LinearImage {
        LinearImage::of_radiance(&self.radiance).exposed(exposure_ev)
    }
}

impl Shot<'_> {
    /// Renders a material.
    pub fn take(&self, material: &(impl Shade + ?Sized)) -> Picture {
        self.take_on(&self.set(), material)
    }

    /// Returns the sample set of the picture, which does not depend on the material.
    #[must_use]
    pub fn set(&self) -> SampleSet {
        self.samples(self.sampling, PixelArea::whole(self.size_px))
    }

    /// Renders a material on a set from [`Shot::set`], so that several materials share one.
    pub fn take_on(&self, set: &SampleSet, material: &(impl Shade + ?Sized)) -> Picture {
        let (mut f, mut fine_f) = (Vec::new(), Vec::new());
        material.shade(set, &mut f);
        let gain = Gain::new(self.scene.film, set, &f);
        let mut developed = develop_samples(set, &f, gain);
        let mut samples = set.len();
        for rough in rough_tiles(set, &developed) {
            let RoughTile { tile, pixels, .. } = rough;
            let fine = self.samples(RoughTile::SAMPLING, tile);
            material.shade(&fine, &mut fine_f);
            samples += fine.len();
            let image = shade(&fine, &fine_f);
            for (pixel, within) in pixels {
                let (pixel, within) = (pixel as usize, within as usize);
                let coverage = image.coverage()[within];
                // The centre ray hit, so this is 0 only for slits thinner than the ray spacing.
                if coverage > 0.0 {
                    let value = image.premultiplied()[within].map(|channel| channel / coverage);
                    developed.put(pixel, value, gain);
                }
            }
        }
        let (radiance, refined) = self.refined_radiance((set, &f), material);
        samples += usize::try_from(refined.samples).expect("they were in memory");
        let view = (self.scene, self.mesh, self.assets);
        let backdrop = LitBackdrop::new(view, self.size_px, PixelArea::whole(self.size_px));
        Picture { developed: backdrop.behind(developed), radiance, samples }
    }

    /// Renders a material in bands, for scenes with many samples of light per pixel. The light of
    /// environments has no noise if it casts no shadows or the material is prefilterable; in the
    /// latter case light is that at the centres of pixels. Rough pixels are not resampled.
    pub fn take_in_bands(&self, material: &(impl Shade + ?Sized)) -> Picture {
        let PictureSize { width, height } = self.size_px;
        let (mut bands, mut f, mut samples) = (Vec::new(), Vec::new(), 0);
        for y in (0..height).step_by(BAND as usize) {
            let area = PixelArea { x: 0, y, width, height: BAND.min(height - y) };
            let has_shadows = self.scene.has_environment() && !self.scene.is_prefilterable();
            if has_shadows && material.is_prefilterable() {
                let (band, count) = self.band_of_terms(area, material);
                samples += count;
                bands.push(band);
                continue;
            }
            let set = self.band(area);
            material.shade(&set, &mut f);
            samples += set.len();
            bands.push(shade(&set, &f));
        }
        let radiance = RadianceImage::of_bands(&bands);
        let developed = develop(&radiance, self.scene.film);
        let view = (self.scene, self.mesh, self.assets);
        let backdrop = LitBackdrop::new(view, self.size_px, PixelArea::whole(self.size_px));
        Picture { developed: backdrop.behind(developed), radiance, samples }
    }

    /// Renders a part of the picture by the light at the centres of pixels; also returns the number
    /// of pairs at which the material was evaluated.
    fn band_of_terms(
        &self,
        area: PixelArea,
        material: &(impl Shade + ?Sized),
    ) -> (RadianceImage, usize) {
        let Self { mesh, scene, assets, size_px, sampling } = *self;
        // One light at the eye shows which share of a pixel the object covers.
        let raster = Raster { size_px, sampling, area };
        let covered = SampleSet::render_with_assets(mesh, &scene.lit_from_eye(), assets, raster);
        let mut image = shade(&covered, &vec![0.0; 3 * covered.len()]);
        let place = |at: u32| (area.x + at % area.width, area.y + at / area.width);
        let pixels: Vec<(u32, u32)> = (0..area.width * area.height).map(place).collect();
        let light = LightTerms::render(mesh, scene, assets, size_px, &pixels, 1);
        let mut f = Vec::new();
        material.shade(&SampleSet::from_pairs(&light.pairs, &[]), &mut f);
        let count = light.pairs.len();
        let radiance = |(at, pixel): (usize, &PixelTerms)| {
            let mut sum = [0.0; 3];
            for (pair, irradiance) in &pixel.terms {
                let f = [0, 1, 2].map(|channel| f[channel * count + *pair as usize]);
                sum = [0, 1, 2].map(|c| sum[c] + f[c].max(0.0) * irradiance[c]);
            }
            sum.map(|channel| channel * image.coverage()[at])
        };
        let lit: Vec<[f32; 3]> = light.pixels.iter().enumerate().map(radiance).collect();
        image.add(&lit);
        (image, count)
    }

    /// Returns the samples of a part of the picture; environments as directions of mean radiance
    /// where that is possible.
    fn band(&self, area: PixelArea) -> SampleSet {
        let Self { mesh, scene, assets, size_px, sampling } = *self;
        if !scene.is_prefilterable() {
            return self.samples(sampling, area);
        }
        SampleSet::render_direct(
            mesh,
            scene,
            assets,
            Raster { size_px, sampling, area },
            LobeShape::Any,
        )
    }

    /// Returns the linear picture of a material on a set from [`Shot::set`].
    pub fn radiance_on(
        &self,
        set: &SampleSet,
        material: &(impl Shade + ?Sized),
    ) -> (RadianceImage, Refinement) {
        let mut f = Vec::new();
        material.shade(set, &mut f);
        self.refined_radiance((set, &f), material)
    }

    fn refined_radiance(
        &self,
        (set, f): (&SampleSet, &[f32]),
        material: &(impl Shade + ?Sized),
    ) -> (RadianceImage, Refinement) {
        let mut radiance = shade(set, f);
        let refined = refine_radiance(
            &mut radiance,
            (set, f),
            // Linear radiance does not depend on the film.
            Gain::new(Exposure::Auto, set, f),
            |rays, pixels| {
                let picture = (self.size_px, rays);
                SampleSet::render_pixels(self.mesh, self.scene, self.assets, picture, pixels, None)
            },
            |set, f| -> Result<(), Infallible> {
                material.shade(set, f);
                Ok(())
            },
        );
        let Ok(refined) = refined;
        (radiance, refined)
    }

    /// Traces the samples of a part of the picture.
    fn samples(&self, sampling: Sampling, area: PixelArea) -> SampleSet {
        let raster = Raster { size_px: self.size_px, sampling, area };
        SampleSet::render_with_assets(self.mesh, self.scene, self.assets, raster)
    }
}
