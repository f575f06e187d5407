//! Picture whose samples are evaluated band by band and not kept: environments on materials that
//! vary over the surface take many samples per pixel.

use std::time::Instant;

use brood_eval::{
    Developed, FineSamples, Gain, RadianceImage, Refinement, RoughTile, develop_exposed,
    refine_lone_rays, rough_pixels, shade,
};
use brood_program::Program;
use brood_protocol::{Backend, PictureFormat, RenderStats};
use brood_scene::{Exposure, LobeShape, PixelArea, Raster, Sampling};
use rayon::prelude::*;

use crate::cache::Caches;
use crate::error::RenderError;
use crate::evaluated_picture::{EvaluatedPicture, fine_backend};
use crate::evaluator::Evaluators;
use crate::render_counters::micros;
use crate::shot::{BATCH_FLOATS, Shot};

/// Largest number of samples of a band, of which one takes about 100 bytes.
const BAND_SAMPLES: usize = if cfg!(test) { 1 << 14 } else { 1 << 19 };

/// Batch of pictures.
struct Batch<'a> {
    shot: &'a Shot<'a>,
    lobes: LobeShape,
    caches: &'a Caches,
    evaluators: &'a Evaluators,
    /// Evaluated part, in pixels of the whole picture.
    lit: PixelArea,
    /// True for each pixel of `lit` that has one ray.
    lone: Vec<bool>,
    /// Number of samples of each picture.
    samples: u64,
}

/// Evaluated picture of one program.
struct BandedPicture<'a> {
    batch: &'a Batch<'a>,
    program: &'a Program,
    /// Radiance of the evaluated part.
    image: &'a RadianceImage,
    gain: Gain,
    /// Developed image, if the frame asks for one.
    developed: Option<Developed>,
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
    let Shot { view, frame, film, .. } = shot;
    let size_px = frame.size_px;
    let lit = shot.lit_area();
    let mut parts: Vec<Vec<RadianceImage>> = programs.iter().map(|_| Vec::new()).collect();
    let (mut lone, mut samples) = (Vec::new(), 0);
    for band in bands(lit, lobes) {
        caches.check()?;
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
        caches.advance(3 * programs.len() as u64 * set.counts().rays);
    }
    let batch = Batch { shot, lobes, caches, evaluators, lit, lone, samples };
    let started = Instant::now();
    let images: Vec<RadianceImage> =
        parts.iter().map(|parts| RadianceImage::of_bands(parts)).collect();
    let exposed: Vec<(&RadianceImage, Gain)> =
        images.par_iter().map(|image| (image, Gain::of_image(*film, image))).collect();
    let mut developed: Vec<Option<Developed>> = match frame.format {
        PictureFormat::Png => batch.develop(programs, &exposed)?.into_iter().map(Some).collect(),
        PictureFormat::Exr
        | PictureFormat::Spheres
        | PictureFormat::Angles
        | PictureFormat::RayEnds => programs.iter().map(|_| None).collect(),
    };
    let pictures = (programs, &exposed, &mut developed).into_par_iter().map(
        |(program, &(image, gain), developed)| {
            let developed = developed.take();
            finish(program, &BandedPicture { batch: &batch, program, image, gain, developed })
        },
    );
    let pictures: Result<Vec<T>, RenderError> = pictures.collect();
    caches
        .counters
        .add(RenderStats { film_us: micros(started.elapsed()), ..RenderStats::default() });
    pictures
}

impl Batch<'_> {
    /// Develops images of programs. Samples of rough pixels are made once for all programs that
    /// need them.
    fn develop(
        &self,
        programs: &[&Program],
        exposed: &[(&RadianceImage, Gain)],
    ) -> Result<Vec<Developed>, RenderError> {
        let Sampling::Fixed(rays) = RoughTile::SAMPLING else {
            unreachable!("rough pixels have a fixed number of rays")
        };
        let develop = |&(image, gain): &(&RadianceImage, Gain)| {
            let developed = develop_exposed(image, gain);
            let rough = rough_pixels(&developed, &self.lone);
            (developed, rough)
        };
        let mut pictures: Vec<(Developed, Vec<u32>)> = exposed.par_iter().map(develop).collect();
        let mut is_rough = vec![false; self.lone.len()];
        for pixel in pictures.iter().flat_map(|(_, rough)| rough) {
            is_rough[*pixel as usize] = true;
        }
        let all = (0..).zip(is_rough).filter_map(|(pixel, is_rough)| is_rough.then_some(pixel));
        let all: Vec<u32> = all.collect();
        let Shot { view, frame, .. } = self.shot;
        let together = (BAND_SAMPLES / (usize::from(rays) * self.lobes.samples())).max(1);
        for pixels in all.chunks(together) {
            self.caches.check()?;
            let places: Vec<(u32, u32)> = pixels.iter().map(|pixel| self.place(*pixel)).collect();
            let fine = view.render_pixels((frame.size_px, rays), &places, Some(self.lobes));
            let batch = (programs, exposed, &mut pictures).into_par_iter();
            batch.try_for_each_init(Vec::new, |f, (program, (_, gain), (developed, rough))| {
                let within = |end: u32| rough.partition_point(|pixel| *pixel < end);
                let (first, last) = (pixels[0], pixels[pixels.len() - 1]);
                let own = &rough[within(first)..within(last + 1)];
                if own.is_empty() {
                    return Ok(());
                }
                let samples = FineSamples::of_pixels((&fine, pixels), own, program);
                self.evaluators.eval(self.fine_backend(), &[*program], &samples.set, f)?;
                samples.radiance(f, |pixel, radiance| developed.put(pixel, radiance, *gain));
                self.count(samples.pixels(), samples.set.len() as u64);
                Ok::<(), RenderError>(())
            })?;
        }
        Ok(pictures.into_iter().map(|(developed, _)| developed).collect())
    }

    fn fine_backend(&self) -> Backend {
        fine_backend(self.shot.frame)
    }

    /// Returns column and row of a pixel in the whole picture.
    fn place(&self, pixel: u32) -> (u32, u32) {
        (self.lit.x + pixel % self.lit.width, self.lit.y + pixel / self.lit.width)
    }

    fn count(&self, rough_pixels: u64, rough_samples: u64) {
        let stats = RenderStats { rough_pixels, rough_samples, ..RenderStats::default() };
        self.caches.counters.add(stats);
    }

    /// Returns the requested part in pixels of the evaluated one, or `None` if it is all of it.
    fn own_area(&self) -> Option<PixelArea> {
        let (area, lit) = (self.shot.area, self.lit);
        let own = PixelArea { x: area.x - lit.x, y: area.y - lit.y, ..area };
        (lit != area).then_some(own)
    }
}

impl EvaluatedPicture for BandedPicture<'_> {
    fn develop(&self) -> Result<Developed, RenderError> {
        let developed = match &self.developed {
            Some(developed) => developed.clone(),
            None => self.batch.develop(&[self.program], &[(self.image, self.gain)])?.swap_remove(0),
        };
        Ok(match self.batch.own_area() {
            Some(own) => developed.crop(own),
            None => developed,
        })
    }

    fn radiance(&self) -> Result<RadianceImage, RenderError> {
        let mut image = self.image.clone();
        let Batch { shot: Shot { view, frame, .. }, evaluators, lit, lone, lobes, .. } = self.batch;
        let backend = self.batch.fine_backend();
        let Refinement { pixels, samples } = refine_lone_rays(
            &mut image,
            (*lit, lone),
            // Linear radiance does not depend on the film.
            Gain::of_image(Exposure::Auto, self.image),
            |rays, pixels| view.render_pixels((frame.size_px, rays), pixels, Some(*lobes)),
            |set, f| evaluators.eval(backend, &[self.program], set, f),
        )?;
        self.batch.count(pixels, samples);
        Ok(match self.batch.own_area() {
            Some(own) => image.crop(own),
            None => image,
        })
    }

    fn gain(&self) -> Gain {
        self.gain
    }

    fn samples(&self) -> u64 {
        self.batch.samples
    }
}
