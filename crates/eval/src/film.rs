//! Film: exposure, tone curve and sRGB transfer curve, from radiance to 8-bit pictures.

mod backdrop;
mod developed;
mod exposure;
mod paint;
mod refinement;
mod rough;
mod srgb;
mod surroundings;
mod tone;

use std::ops::Range;

pub use backdrop::LitBackdrop;
use brood_brdf::{Level, SimdKernel};
use brood_scene::{Film, SampleSet};
pub use developed::Developed;
pub use exposure::Gain;
pub use paint::{develop_colors, linear_colors};
pub use refinement::{Refinement, refine_lone_rays, refine_radiance};
pub use rough::{FineSamples, RoughTile, rough_pixels, rough_tile_count, rough_tiles};
pub use srgb::{decode_srgb, encode_srgb};
pub use surroundings::Surroundings;

use self::tone::{Curve, WithCurve, with_curve};
use crate::radiance::{RadianceImage, ReflectedLight};

/// Develops a radiance image.
///
/// # Source
/// Automatic exposure maps the 97th percentile of the largest channel at the centres of pixels to
/// linear 0.9 (docs/maths/film.md).
#[must_use]
pub fn develop(image: &RadianceImage, film: impl Into<Film>) -> Developed {
    develop_exposed(image, Gain::of_image(film, image))
}

/// Develops a radiance image with a known gain.
#[must_use]
pub fn develop_exposed(image: &RadianceImage, gain: Gain) -> Developed {
    let rgba = with_curve(gain.tone, Pixels { image, factor: gain.factor });
    Developed { width: image.width(), height: image.height(), rgba, exposure_ev: gain.ev }
}

/// Development of a radiance image with a tone curve known at compile time.
struct Pixels<'a> {
    image: &'a RadianceImage,
    /// Factor of radiance by the exposure.
    factor: f32,
}

impl WithCurve for Pixels<'_> {
    type Output = Vec<u8>;

    fn with<T: Curve>(self, tone: T) -> Vec<u8> {
        let Self { image, factor } = self;
        let transfer = Transfer { curve: srgb::curve(), tone, factor };
        let mut rgba = vec![0; 4 * image.coverage().len()];
        let pixels = image.premultiplied().iter().zip(image.coverage());
        for (place, (radiance, coverage)) in rgba.chunks_exact_mut(4).zip(pixels) {
            if *coverage > 0.0 {
                place.copy_from_slice(&transfer.pixel(*radiance, *coverage));
            }
        }
        rgba
    }
}

/// Develops a picture directly from its samples: bit-equal to [`crate::shade`] followed by
/// [`develop`], without the radiance image in between.
///
/// # Shapes
/// As [`crate::shade`].
///
/// # Panics
/// As [`crate::shade`].
#[must_use]
pub fn develop_samples(set: &SampleSet, f: &[f32], gain: Gain) -> Developed {
    let light = ReflectedLight::new(set, f);
    let (width, height) = (light.layout.width, light.layout.height);
    let mut rgba = vec![0; 4 * light.layout.coverage.len()];
    with_curve(gain.tone, Samples { light, factor: gain.factor, pixels: rgba.as_chunks_mut().0 });
    Developed { width, height, rgba, exposure_ev: gain.ev }
}

/// Number of pixels that are encoded together.
const PIXELS_TOGETHER: usize = 32;

/// Development of samples, before the tone curve is known at compile time.
struct Samples<'a> {
    light: ReflectedLight<'a>,
    factor: f32,
    pixels: &'a mut [[u8; 4]],
}

impl WithCurve for Samples<'_> {
    type Output = ();

    fn with<T: Curve>(self, tone: T) {
        let Self { light, factor, pixels } = self;
        let transfer = Transfer { curve: srgb::curve(), tone, factor };
        Level::best().run(Development { light, transfer, pixels });
    }
}

/// Exposure factor, tone curve and transfer curve.
#[derive(Clone, Copy)]
struct Transfer<'a, T> {
    curve: &'a srgb::Curve,
    tone: T,
    factor: f32,
}

/// Development of samples with a known tone curve: the kernel.
struct Development<'a, T> {
    light: ReflectedLight<'a>,
    transfer: Transfer<'a, T>,
    pixels: &'a mut [[u8; 4]],
}

impl<T: Curve> SimdKernel for Development<'_, T> {
    type Output = ();

    #[inline(always)]
    fn run(mut self) {
        let layout = self.light.layout;
        for (pixel, coverage) in self.pixels.iter_mut().zip(layout.coverage.iter()) {
            pixel[3] = alpha(*coverage);
        }
        for run in &layout.runs {
            let (first, last) = (run.pixel as usize, (run.pixel + run.pixels) as usize);
            let counts = (run.samples, run.centre, run.radiance_start);
            if layout.scale >= 1.0 && counts == (1, 1, 0) {
                // One ray per pixel, which hit and is lit by one light: coverage is 1, so that no
                // division is needed.
                let mut sample = run.start as usize;
                for pixel in (first..last).step_by(PIXELS_TOGETHER) {
                    let count = PIXELS_TOGETHER.min(last - pixel);
                    self.opaque(pixel..pixel + count, sample..sample + count);
                    sample += count;
                }
                continue;
            }
            let coverage = &layout.coverage[first..last];
            let Self { light, transfer, pixels } = &mut self;
            let pixels = &mut pixels[first..last];
            light.each_pixel(run, |k, radiance| pixels[k] = transfer.pixel(radiance, coverage[k]));
        }
    }
}

impl<T: Curve> Development<'_, T> {
    /// Develops opaque pixels of one sample each, at most [`PIXELS_TOGETHER`] of them.
    #[inline(always)]
    fn opaque(&mut self, pixels: Range<usize>, samples: Range<usize>) {
        let Transfer { curve, tone, factor } = self.transfer;
        let scale = self.light.layout.scale;
        let mut codes = [[0; PIXELS_TOGETHER]; 3];
        for (channel, codes) in codes.iter_mut().enumerate() {
            let (f, irradiance) = self.light.channel(channel, samples.clone());
            let mut exposed = [0.0; PIXELS_TOGETHER];
            match (f.first_chunk::<PIXELS_TOGETHER>(), irradiance.first_chunk::<PIXELS_TOGETHER>())
            {
                (Some(f), Some(irradiance)) => expose(&mut exposed, f, irradiance, scale, factor),
                _ => expose(&mut exposed, f, irradiance, scale, factor),
            }
            for value in &mut exposed {
                *value = tone.apply(*value);
            }
            *codes = curve.encode_each(&exposed);
        }
        let [red, green, blue] = &codes;
        let pixels = &mut self.pixels[pixels];
        for (((pixel, red), green), blue) in pixels.iter_mut().zip(red).zip(green).zip(blue) {
            *pixel = (red | green << 8 | blue << 16 | 255 << 24).to_le_bytes();
        }
    }
}

/// Computes exposed radiance. The order of the products is that of shading followed by exposure, so
/// that the bits are equal.
#[inline(always)]
fn expose(exposed: &mut [f32], f: &[f32], irradiance: &[f32], scale: f32, factor: f32) {
    for ((exposed, f), irradiance) in exposed.iter_mut().zip(f).zip(irradiance) {
        *exposed = f * irradiance * scale * factor;
    }
}

/// Returns the 8-bit alpha of a coverage.
#[inline(always)]
fn alpha(coverage: f32) -> u8 {
    (coverage * 255.0 + 0.5) as u8
}

impl<T: Curve> Transfer<'_, T> {
    /// Develops a pixel, given its radiance times coverage.
    #[inline(always)]
    fn pixel(&self, radiance: [f32; 3], coverage: f32) -> [u8; 4] {
        let mut code = [0, 0, 0, alpha(coverage)];
        for (code, channel) in code.iter_mut().zip(radiance) {
            let exposed = channel * self.factor;
            // Most pixels are fully covered, and a division by 1 changes nothing.
            let exposed = if coverage < 1.0 { exposed / coverage } else { exposed };
            *code = self.curve.encode(self.tone.apply(exposed));
        }
        code
    }
}

#[cfg(test)]
mod tests {
    use brood_genome::{BirthKey, Dialect, Variation};
    use brood_light::Light;
    use brood_mesh::{BuiltinMesh, Mesh};
    use brood_program::Program;
    use brood_scene::{Exposure, Sampling, Scene, Tone};

    use super::*;
    use crate::{CanonicalEvaluator, Evaluator, shade};

    #[test]
    fn developing_from_samples_equals_shading_then_developing() {
        let random = Variation::random(Dialect::default());
        let programs: Vec<Program> = (0..3)
            .map(|slot| Program::lower(&random.birth(BirthKey { seed: 5, slot, attempt: 0 })))
            .collect();
        let programs: Vec<&Program> = programs.iter().collect();
        let mut scene = Scene::default();
        let mesh = Mesh::builtin(BuiltinMesh::Knob);
        for lights in 1..3 {
            for sampling in [Sampling::Adaptive, Sampling::Fixed(1), Sampling::Fixed(3)] {
                let set = SampleSet::render(&mesh, &scene, 40, sampling);
                let mut f = Vec::new();
                CanonicalEvaluator::default().eval(&programs, &set, &mut f).unwrap();
                for f in f.chunks(3 * set.len()) {
                    let exposures = [Exposure::Auto, Exposure::Ev(-1.5)];
                    let films = exposures
                        .into_iter()
                        .flat_map(|exposure| Tone::ALL.map(|tone| Film { exposure, tone }));
                    for film in films {
                        let gain = Gain::new(film, &set, f);
                        let developed = develop_samples(&set, f, gain);
                        let image = shade(&set, f);
                        assert_eq!(developed, develop(&image, film));
                        assert!(developed.rgba.chunks(4).any(|p| p[3] == 255 && p[..3] != [0; 3]));
                        let mut put = developed.clone();
                        for (pixel, coverage) in image.coverage().iter().enumerate() {
                            if *coverage == 1.0 {
                                put.put(pixel, image.premultiplied()[pixel], gain);
                            }
                        }
                        assert_eq!(
                            put, developed,
                            "putting the same radiance again changes nothing"
                        );
                    }
                }
            }
            scene.lights.push(Light::point_at([-4.0, 1.0, f64::from(lights)]));
        }
    }

    #[test]
    fn pixel_is_transparent_when_only_the_ray_through_its_centre_hits() {
        let scene = Scene { scale: 1e-3, ..Scene::default() };
        let mesh = Mesh::builtin(BuiltinMesh::Sphere);
        let set = SampleSet::render(&mesh, &scene, 17, Sampling::Adaptive);
        let layout = set.image().unwrap();
        let lone = layout.spans().find(|span| span.radiance_start == span.end);
        let pixel = lone.expect("the sphere is smaller than the distance of rays").pixel as usize;
        assert_eq!(layout.coverage[pixel], 0.0);
        let f = vec![0.3; 3 * set.len()];
        let developed = develop_samples(&set, &f, Gain::new(Film::default(), &set, &f));
        assert_eq!(developed, develop(&shade(&set, &f), Film::default()));
        assert_eq!(developed.rgba[4 * pixel..][..4], [0; 4]);
    }
}
