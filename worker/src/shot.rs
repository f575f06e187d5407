//! One program's samples, evaluated, on their way to a picture: developed, and its rough pixels sampled again.
//!
//! It refuses to know how batches are evaluated and how pictures are encoded.

use std::sync::{Arc, OnceLock};

use brood_eval::{
    Developed, FineSamples, Gain, RadianceImage, RoughTile, develop_samples, rough_tile_count,
    rough_tiles, shade,
};
use brood_program::Program;
use brood_protocol::{Backend, Frame, Work};
use brood_scene::{PixelArea, SampleSet};

use crate::cache::{Raster, View};
use crate::renderer::{RenderError, Renderer};

/// A program's samples, evaluated.
pub(crate) struct Shot<'a> {
    pub(crate) set: &'a SampleSet,
    pub(crate) f: &'a [f32],
    pub(crate) gain: Gain,
    /// The part of the set's image that is wanted, in the pixels of the whole picture.
    pub(crate) area: PixelArea,
    pub(crate) refiner: Refiner<'a>,
}

/// What is needed to sample some pixels again.
pub(crate) struct Refiner<'a> {
    pub(crate) renderer: &'a Renderer,
    pub(crate) view: &'a View<'a>,
    pub(crate) frame: &'a Frame,
    pub(crate) program: &'a Program,
    pub(crate) tiles: &'a FineTiles,
}

/// Fine samples of the tiles of one view, looked up once for all programs of a batch.
pub(crate) struct FineTiles {
    size_px: u32,
    sets: Vec<OnceLock<Arc<SampleSet>>>,
}

impl FineTiles {
    pub(crate) fn new(size_px: u32) -> Self {
        let sets = (0..rough_tile_count(size_px)).map(|_| OnceLock::new()).collect();
        Self { size_px, sets }
    }

    /// Traced where they are first needed, and kept with the other sample sets.
    fn set(&self, renderer: &Renderer, view: &View<'_>, rough: &RoughTile) -> &SampleSet {
        let kept = &self.sets[rough.number];
        if kept.get().is_none() {
            let raster =
                Raster { size_px: self.size_px, sampling: RoughTile::SAMPLING, area: rough.tile };
            // Not inside `get_or_init`: who makes it may be given another task meanwhile, which may want it too.
            let set = renderer.caches.sample_set_in_task(view, raster);
            kept.get_or_init(|| set);
        }
        kept.get().expect("it has just been put there")
    }
}

impl Shot<'_> {
    /// The picture.
    pub(crate) fn develop(&self) -> Result<Developed, RenderError> {
        let mut developed = develop_samples(self.set, self.f, self.gain);
        let rough = rough_tiles(self.set, &developed);
        self.refine(rough, |pixel, radiance| developed.put(pixel, radiance, self.gain))?;
        Ok(match self.own_area() {
            Some(own) => developed.crop(own),
            None => developed,
        })
    }

    /// Linear radiance.
    pub(crate) fn radiance(&self) -> Result<RadianceImage, RenderError> {
        let rough = rough_tiles(self.set, &develop_samples(self.set, self.f, self.gain));
        let mut image = shade(self.set, self.f);
        // Rough pixels are covered whole: radiance is radiance times coverage.
        self.refine(rough, |pixel, radiance| image.put(pixel, radiance))?;
        Ok(match self.own_area() {
            Some(own) => image.crop(own),
            None => image,
        })
    }

    /// Calls back with the rough pixels and their radiance. All are evaluated together.
    fn refine(
        &self,
        rough: Vec<RoughTile>,
        mut put: impl FnMut(usize, [f32; 3]),
    ) -> Result<(), RenderError> {
        if rough.is_empty() {
            return Ok(());
        }
        let Refiner { renderer, view, frame, program, tiles } = &self.refiner;
        // Too few samples for a GPU; the exact evaluators give the same bits.
        let backend = match frame.backend {
            Backend::Reference => Backend::Reference,
            Backend::Auto | Backend::Cpu | Backend::Gpu => Backend::Cpu,
        };
        let with_set = |rough| (rough, tiles.set(renderer, view, rough));
        let rough: Vec<(&RoughTile, &SampleSet)> = rough.iter().map(with_set).collect();
        let mut f = Vec::new();
        for fine in FineSamples::batches(&rough, program) {
            renderer.evaluators.eval(backend, &[*program], &fine.set, &mut f)?;
            fine.radiance(&f, &mut put);
            let (rough_pixels, rough_samples) = (fine.pixels(), fine.set.len() as u64);
            renderer.caches.tally.add(Work { rough_pixels, rough_samples, ..Work::default() });
        }
        Ok(())
    }

    /// The wanted part in the pixels of the set's image, where that is not all of it.
    fn own_area(&self) -> Option<PixelArea> {
        let seen = self.set.image().expect("the samples are those of a picture").area;
        let own = PixelArea { x: self.area.x - seen.x, y: self.area.y - seen.y, ..self.area };
        (seen != self.area).then_some(own)
    }
}
