//! Picture whose samples are evaluated band by band and not kept: environments on materials that
//! vary over the surface take many samples per pixel.

use std::time::Instant;

use brood_eval::{
    Developed, Gain, RadianceImage, Refinement, RoughTile, develop_exposed, refine_lone_rays,
    rough_pixels, shade, shade_each,
};
use brood_program::Program;
use brood_protocol::RenderStats;
use brood_scene::{Exposure, LobeShape, PixelArea, Raster, Sampling};
use rayon::prelude::*;

use crate::cache::Caches;
use crate::error::RenderError;
use crate::evaluated_picture::{EvaluatedPicture, FineTiles, Refiner};
use crate::evaluator::Evaluators;
use crate::render_counters::micros;
use crate::shot::{BATCH_FLOATS, Shot};

/// Largest number of samples of a band, of which one takes about 100 bytes.
const BAND_SAMPLES: usize = if cfg!(test) { 1 << 14 } else { 1 << 19 };
/// Number of rough pixels that are evaluated together.
const PIXELS_TOGETHER: usize = 256;

/// Evaluated picture of one program.
struct BandedPicture<'a> {
    /// Radiance of `lit`.
    image: &'a RadianceImage,
    /// True for each pixel of `lit` that has one ray.
    lone: &'a [bool],
    gain: Gain,
    /// Evaluated part, in pixels of the whole picture.
    lit: PixelArea,
    /// Requested part, within `lit`.
    area: PixelArea,
    refiner: Refiner<'a>,
    lobes: LobeShape,
    samples: u64,
}

/// Returns the bands of an area, from the top.
fn bands(area: PixelArea, lobes: LobeShape) -> impl Iterator<Item = PixelArea> {
    let rows = (BAND_SAMPLES / lobes.samples() / area.width as usize).max(1);
    let rows = u32::try_from(rows).expect("a band has fewer than 2^32 rows");
    (0..area.height.div_ceil(rows)).map(move |band| {
        let y = band * rows;
        PixelArea { y: area.y + y, height: rows.min(area.height - y), ..area }
    })
}

/// Evaluates programs under all lights, environments included, in bands of the picture, and
/// finishes the pictures in parallel. `f` is a buffer for reflectances.
pub(crate) fn banded_images<T: Send>(
    shot: &Shot<'_>,
    lobes: LobeShape,
    programs: &[&Program],
    (caches, evaluators): (&Caches, &Evaluators),
    f: &mut Vec<f32>,
    finish: impl Fn(&Program, &dyn EvaluatedPicture) -> Result<T, RenderError> + Sync,
) -> Result<Vec<T>, RenderError> {
    let Shot { view, frame, film, area } = shot;
    let size_px = frame.size_px;
    let lit = shot.lit_area();
    let mut parts: Vec<Vec<RadianceImage>> = programs.iter().map(|_| Vec::new()).collect();
    let (mut lone, mut samples) = (Vec::new(), 0);
    for band in bands(lit, lobes) {
        let raster = Raster { size_px, sampling: Sampling::Adaptive, area: band };
        let set = caches.counters.timed(
            || view.render_direct(raster, lobes),
            |sets_us| RenderStats { sets_us, sets_made: 1, ..RenderStats::default() },
        );
        lone.extend(set.image().expect("the set is that of a picture").lone_rays());
        samples += set.len() as u64;
        let floats = 3 * set.len();
        let together = (BATCH_FLOATS / floats.max(1)).max(1);
        for (programs, parts) in programs.chunks(together).zip(parts.chunks_mut(together)) {
            caches.counters.timed(
                || evaluators.eval(frame.backend, programs, &set, f),
                |evaluation_us| RenderStats { evaluation_us, ..RenderStats::default() },
            )?;
            parts.par_iter_mut().enumerate().for_each(|(index, parts)| {
                parts.push(shade(&set, &f[floats * index..][..floats]));
            });
        }
    }
    let started = Instant::now();
    let tiles = FineTiles::new(size_px);
    let pictures = programs.par_iter().zip(&parts).map(|(program, parts)| {
        let image = &RadianceImage::of_bands(parts);
        let picture = BandedPicture {
            image,
            lone: &lone,
            gain: Gain::of_image(*film, image),
            lit,
            area: *area,
            refiner: Refiner { caches, evaluators, view, frame, program, tiles: &tiles },
            lobes,
            samples,
        };
        finish(program, &picture)
    });
    let pictures: Result<Vec<T>, RenderError> = pictures.collect();
    caches
        .counters
        .add(RenderStats { film_us: micros(started.elapsed()), ..RenderStats::default() });
    pictures
}

impl EvaluatedPicture for BandedPicture<'_> {
    fn develop(&self) -> Result<Developed, RenderError> {
        let mut developed = develop_exposed(self.image, self.gain);
        let Sampling::Fixed(rays) = RoughTile::SAMPLING else {
            unreachable!("rough pixels have a fixed number of rays")
        };
        let rough = rough_pixels(&developed, self.lone);
        let mut f = Vec::new();
        for pixels in rough.chunks(PIXELS_TOGETHER) {
            let places: Vec<(u32, u32)> = pixels.iter().map(|pixel| self.place(*pixel)).collect();
            let Refiner { evaluators, view, frame, program, .. } = &self.refiner;
            let lobes = Some(self.lobes);
            let fine = view.render_pixels((frame.size_px, rays), &places, lobes);
            evaluators.eval(self.refiner.fine_backend(), &[*program], &fine, &mut f)?;
            let coverage = &fine.image().expect("pixels were traced").coverage;
            let mut found = vec![[0.0; 3]; pixels.len()];
            shade_each(&fine, &f, |k, radiance| found[k] = radiance);
            for ((pixel, radiance), coverage) in pixels.iter().zip(found).zip(coverage.iter()) {
                // The centre of the pixel was hit, so coverage is 0 only in the finest of slits.
                if *coverage > 0.0 {
                    let radiance = radiance.map(|channel| channel / coverage);
                    developed.put(*pixel as usize, radiance, self.gain);
                }
            }
            self.count(pixels.len() as u64, fine.len() as u64);
        }
        Ok(match self.own_area() {
            Some(own) => developed.crop(own),
            None => developed,
        })
    }

    fn radiance(&self) -> Result<RadianceImage, RenderError> {
        let mut image = self.image.clone();
        let Refiner { evaluators, view, frame, program, .. } = &self.refiner;
        let backend = self.refiner.fine_backend();
        let Refinement { pixels, samples } = refine_lone_rays(
            &mut image,
            (self.lit, self.lone),
            // Linear radiance does not depend on the film.
            Gain::of_image(Exposure::Auto, self.image),
            |rays, pixels| view.render_pixels((frame.size_px, rays), pixels, Some(self.lobes)),
            |set, f| evaluators.eval(backend, &[*program], set, f),
        )?;
        self.count(pixels, samples);
        Ok(match self.own_area() {
            Some(own) => image.crop(own),
            None => image,
        })
    }

    fn samples(&self) -> u64 {
        self.samples
    }
}

impl BandedPicture<'_> {
    /// Returns column and row of a pixel in the whole picture.
    fn place(&self, pixel: u32) -> (u32, u32) {
        (self.lit.x + pixel % self.lit.width, self.lit.y + pixel / self.lit.width)
    }

    fn count(&self, rough_pixels: u64, rough_samples: u64) {
        let stats = RenderStats { rough_pixels, rough_samples, ..RenderStats::default() };
        self.refiner.caches.counters.add(stats);
    }

    /// Returns the requested part in pixels of the evaluated one, or `None` if it is all of it.
    fn own_area(&self) -> Option<PixelArea> {
        let own =
            PixelArea { x: self.area.x - self.lit.x, y: self.area.y - self.lit.y, ..self.area };
        (self.lit != self.area).then_some(own)
    }
}
