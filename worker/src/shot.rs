//! One program's samples, evaluated, on their way to a picture: developed, and its rough pixels sampled again.
//!
//! It refuses to know how batches are evaluated and how pictures are encoded.

use brood_eval::{
    Developed, Gain, ROUGH_SAMPLING, RadianceImage, RoughTile, develop_samples, rough_tiles, shade,
};
use brood_program::Program;
use brood_protocol::{Backend, Frame};
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

    /// Calls back with the rough pixels and their radiance. Fine samples are traced where they are first needed, a tile at
    /// a time, and kept with the other sample sets.
    fn refine(
        &self,
        rough: Vec<RoughTile>,
        mut put: impl FnMut(usize, [f32; 3]),
    ) -> Result<(), RenderError> {
        let Refiner { renderer, view, frame, program } = &self.refiner;
        // Too few samples for a GPU; the exact evaluators give the same bits.
        let backend = match frame.backend {
            Backend::Reference => Backend::Reference,
            Backend::Auto | Backend::Cpu | Backend::Gpu => Backend::Cpu,
        };
        let mut f = Vec::new();
        for rough in rough {
            let raster =
                Raster { size_px: frame.size_px, sampling: ROUGH_SAMPLING, area: rough.tile };
            let tile = renderer.caches.sample_set_in_task(view, raster);
            let wanted: Vec<u32> = rough.pixels.iter().map(|pixel| pixel.1).collect();
            let picked = tile.pick(&wanted, program.inputs());
            renderer.evaluators.eval(backend, &[*program], &picked, &mut f)?;
            let fine = shade(&picked, &f);
            let fine = fine.premultiplied().iter().zip(fine.coverage());
            for ((pixel, _), (radiance, coverage)) in rough.pixels.iter().zip(fine) {
                // Its centre hit, so this is 0 for nothing but the finest of slits.
                if *coverage > 0.0 {
                    put(*pixel as usize, radiance.map(|channel| channel / coverage));
                }
            }
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
