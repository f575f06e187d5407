//! Development of one program's evaluated samples into a picture, including supersampling of rough
//! pixels.

use std::sync::{Arc, OnceLock};

use brood_eval::{
    Developed, FineSamples, Gain, RadianceImage, Refinement, RoughTile, develop_exposed,
    develop_samples, refine_radiance, rough_tile_count, rough_tiles, shade,
};
use brood_program::Program;
use brood_protocol::{Backend, Frame, RenderStats};
use brood_scene::{Exposure, PictureSize, PixelArea, SampleSet, Sampling};

use crate::cache::Caches;
use crate::error::RenderError;
use crate::evaluator::Evaluators;
use crate::scene_view::{Raster, SceneView};

/// Evaluated picture of one program.
pub(crate) trait EvaluatedPicture {
    /// Returns the developed picture.
    fn develop(&self) -> Result<Developed, RenderError>;

    /// Returns the picture as linear radiance.
    fn radiance(&self) -> Result<RadianceImage, RenderError>;

    /// Returns the exposure and tone curve with which the picture is developed.
    fn gain(&self) -> Gain;

    /// Returns the number of samples evaluated, without those of rough pixels.
    fn samples(&self) -> u64;
}

/// Evaluated samples of one program.
pub(crate) struct SampledPicture<'a> {
    pub(crate) set: &'a SampleSet,
    pub(crate) f: &'a [f32],
    pub(crate) gain: Gain,
    /// Requested part of the set's image, in pixels of the whole picture.
    pub(crate) area: PixelArea,
    pub(crate) refiner: Refiner<'a>,
    /// Light that is not in the samples.
    pub(crate) prefiltered: Option<Prefiltered<'a>>,
    /// Number of samples evaluated.
    pub(crate) samples: u64,
}

/// Radiance of prefiltered light.
pub(crate) struct Prefiltered<'a> {
    /// Radiance of all light.
    pub(crate) image: &'a RadianceImage,
    /// Radiance times coverage of this light alone.
    pub(crate) radiance: &'a [[f32; 3]],
}

impl Prefiltered<'_> {
    /// Adds this light to the radiance of a covered part of a pixel.
    fn added_to(&self, pixel: usize, radiance: [f32; 3]) -> [f32; 3] {
        let coverage = self.image.coverage()[pixel];
        let own = self.radiance[pixel];
        [0, 1, 2].map(|c| radiance[c] + own[c] / coverage)
    }
}

/// Inputs for supersampling some of the pixels.
pub(crate) struct Refiner<'a> {
    pub(crate) caches: &'a Caches,
    pub(crate) evaluators: &'a Evaluators,
    pub(crate) view: &'a SceneView<'a>,
    pub(crate) frame: &'a Frame,
    pub(crate) program: &'a Program,
    pub(crate) tiles: &'a FineTiles,
}

/// Returns the evaluator of supersampled pixels of a frame. They have too few samples for a GPU;
/// the exact evaluators compute the same bits.
pub(crate) fn fine_backend(frame: &Frame) -> Backend {
    match frame.backend {
        Backend::Reference => Backend::Reference,
        Backend::Auto | Backend::Cpu | Backend::Gpu => Backend::Cpu,
    }
}

/// Fine samples of the tiles of one view, looked up once for all programs of a batch.
pub(crate) struct FineTiles {
    size_px: PictureSize,
    sets: Vec<OnceLock<Arc<SampleSet>>>,
}

impl FineTiles {
    pub(crate) fn new(size_px: PictureSize) -> Self {
        let sets = (0..rough_tile_count(size_px)).map(|_| OnceLock::new()).collect();
        Self { size_px, sets }
    }

    /// Returns the fine samples of a tile. They are traced on first use and kept in the sample set
    /// cache.
    fn set(&self, caches: &Caches, view: &SceneView<'_>, rough: &RoughTile) -> &SampleSet {
        let cell = &self.sets[rough.number];
        if cell.get().is_none() {
            let raster =
                Raster { size_px: self.size_px, sampling: RoughTile::SAMPLING, area: rough.tile };
            // Not inside `get_or_init`: while this thread traces rays, rayon may run another task
            // on it that needs the same tile, which would deadlock.
            let set = caches.sample_set_nonblocking(view, raster);
            cell.get_or_init(|| set);
        }
        cell.get().expect("the cell was filled above")
    }
}

impl EvaluatedPicture for SampledPicture<'_> {
    fn develop(&self) -> Result<Developed, RenderError> {
        let mut developed = match &self.prefiltered {
            Some(light) => develop_exposed(light.image, self.gain),
            None => develop_samples(self.set, self.f, self.gain),
        };
        let rough = rough_tiles(self.set, &developed);
        self.refine(rough, |pixel, radiance| {
            let radiance = match &self.prefiltered {
                Some(light) => light.added_to(pixel, radiance),
                None => radiance,
            };
            developed.put(pixel, radiance, self.gain);
        })?;
        Ok(match self.own_area() {
            Some(own) => developed.crop(own),
            None => developed,
        })
    }

    fn radiance(&self) -> Result<RadianceImage, RenderError> {
        let mut image = shade(self.set, self.f);
        let Refiner { caches, evaluators, view, frame, program, .. } = &self.refiner;
        let backend = fine_backend(self.refiner.frame);
        let Refinement { pixels, samples } = refine_radiance(
            &mut image,
            (self.set, self.f),
            self.automatic_gain()?,
            |rays, pixels| view.render_pixels((frame.size_px, rays), pixels, None),
            |set, f| evaluators.eval(backend, &[*program], set, f),
        )?;
        caches.counters.add(RenderStats {
            rough_pixels: pixels,
            rough_samples: samples,
            ..RenderStats::default()
        });
        if let Some(light) = &self.prefiltered {
            image.add(light.radiance);
        }
        Ok(match self.own_area() {
            Some(own) => image.crop(own),
            None => image,
        })
    }

    fn gain(&self) -> Gain {
        self.gain
    }

    fn samples(&self) -> u64 {
        self.samples
    }
}

impl SampledPicture<'_> {
    /// Evaluates all rough pixels and calls `put` with each pixel's index and radiance.
    fn refine(
        &self,
        rough: Vec<RoughTile>,
        mut put: impl FnMut(usize, [f32; 3]),
    ) -> Result<(), RenderError> {
        if rough.is_empty() {
            return Ok(());
        }
        let Refiner { caches, evaluators, view, program, tiles, .. } = &self.refiner;
        let backend = fine_backend(self.refiner.frame);
        let mut f = Vec::new();
        let mut add = |fine: FineSamples| {
            evaluators.eval(backend, &[*program], &fine.set, &mut f)?;
            fine.radiance(&f, &mut put);
            let (rough_pixels, rough_samples) = (fine.pixels(), fine.set.len() as u64);
            caches.counters.add(RenderStats {
                rough_pixels,
                rough_samples,
                ..RenderStats::default()
            });
            Ok(())
        };
        if program.bumps().is_some() {
            // No other program has these bumps, so nothing would share samples of whole tiles.
            let mut pixels: Vec<u32> =
                rough.iter().flat_map(|tile| &tile.pixels).map(|pixel| pixel.0).collect();
            pixels.sort_unstable();
            let PixelArea { x, y, width, .. } =
                self.set.image().expect("the samples are those of a picture").area;
            let places: Vec<(u32, u32)> =
                pixels.iter().map(|pixel| (x + pixel % width, y + pixel / width)).collect();
            let set = view.render_pixels((tiles.size_px, RoughTile::SAMPLES), &places, None);
            return add(FineSamples::of_pixels((&set, &pixels), &pixels, program));
        }
        let with_set = |rough| (rough, tiles.set(caches, view, rough));
        let rough: Vec<(&RoughTile, &SampleSet)> = rough.iter().map(with_set).collect();
        FineSamples::batches(&rough, program).try_for_each(add)
    }

    /// Returns the automatic exposure of the whole picture: linear radiance does not depend on the
    /// film.
    fn automatic_gain(&self) -> Result<Gain, RenderError> {
        if let Some(light) = &self.prefiltered {
            return Ok(Gain::of_image(Exposure::Auto, light.image));
        }
        if self.own_area().is_none() {
            return Ok(Gain::new(Exposure::Auto, self.set, self.f));
        }
        let Refiner { caches, evaluators, view, frame, program, .. } = &self.refiner;
        let (size_px, sampling) = (frame.size_px, Sampling::Fixed(1));
        let raster = Raster { size_px, sampling, area: PixelArea::whole(size_px) };
        let set = caches.sample_set_nonblocking(view, raster);
        let mut f = Vec::new();
        evaluators.eval(fine_backend(frame), &[*program], &set, &mut f)?;
        Ok(Gain::new(Exposure::Auto, &set, &f))
    }

    /// Returns the requested part in pixels of the set's image, or `None` if it is the whole image.
    fn own_area(&self) -> Option<PixelArea> {
        let image_area = self.set.image().expect("the samples are those of a picture").area;
        let own =
            PixelArea { x: self.area.x - image_area.x, y: self.area.y - image_area.y, ..self.area };
        (image_area != self.area).then_some(own)
    }
}
