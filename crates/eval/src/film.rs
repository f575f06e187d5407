//! Film: exposure and the sRGB transfer curve, to 8 bits.

mod exposure;
mod rough;
mod srgb;

use std::ops::Range;

use brood_scene::{Exposure, PixelArea, SampleSet};
pub use exposure::Gain;
pub use rough::{FineSamples, RoughTile, rough_tile_count, rough_tiles};
pub use srgb::encode_srgb;

use crate::canonical::Work;
use crate::radiance::ReflectedLight;
use crate::{Level, RadianceImage};

/// A developed picture: sRGB with straight alpha, row by row from the top.
#[derive(Debug, Clone, PartialEq)]
pub struct Developed {
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// Four bytes a pixel.
    pub rgba: Vec<u8>,
    /// The exposure used: radiance was multiplied by 2^this.
    pub exposure_ev: f64,
}

impl Developed {
    /// Replaces the colour of a pixel by another radiance (of what is covered, not times coverage).
    ///
    /// # Panics
    /// Where there is no such pixel.
    pub fn put(&mut self, pixel: usize, radiance: [f32; 3], gain: Gain) {
        let codes = radiance.map(|channel| srgb::curve().encode(channel * gain.factor));
        self.rgba[4 * pixel..4 * pixel + 3].copy_from_slice(&codes);
    }

    /// A part of the picture; the area counts from its own upper left corner.
    ///
    /// # Panics
    /// Where the area is not within the picture.
    #[must_use]
    pub fn crop(&self, area: PixelArea) -> Self {
        let row = |y: u32| {
            let start = 4 * ((area.y + y) as usize * self.width as usize + area.x as usize);
            &self.rgba[start..start + 4 * area.width as usize]
        };
        let rgba = (0..area.height).flat_map(row).copied().collect();
        Self { width: area.width, height: area.height, rgba, exposure_ev: self.exposure_ev }
    }
}

/// Develops a picture.
///
/// # Source
/// Automatic exposure: the 97th percentile of the largest channel at the pixels' centres becomes linear 0.9
/// (docs/maths/film.md).
#[must_use]
pub fn develop(image: &RadianceImage, exposure: Exposure) -> Developed {
    let gain = Gain::of(exposure, || image.centres().to_vec());
    let curve = srgb::curve();
    let mut rgba = vec![0; 4 * image.coverage().len()];
    let pixels = image.premultiplied().iter().zip(image.coverage());
    for (place, (radiance, coverage)) in rgba.chunks_exact_mut(4).zip(pixels) {
        if *coverage > 0.0 {
            place.copy_from_slice(&pixel(curve, *radiance, *coverage, gain.factor));
        }
    }
    Developed { width: image.width(), height: image.height(), rgba, exposure_ev: gain.ev }
}

/// Develops a picture straight from its samples: what [`crate::shade`] and [`develop`] make of them one after the other,
/// to the bit, without the radiance image in between.
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
    let (curve, factor) = (srgb::curve(), gain.factor);
    Level::best().run(Development { light, curve, factor, pixels: rgba.as_chunks_mut().0 });
    Developed { width, height, rgba, exposure_ev: gain.ev }
}

/// Pixels that are encoded together.
const TOGETHER: usize = 32;

/// The pixels of a picture in the making.
struct Development<'a> {
    light: ReflectedLight<'a>,
    curve: &'a srgb::Curve,
    factor: f32,
    pixels: &'a mut [[u8; 4]],
}

impl Work for Development<'_> {
    type Done = ();

    #[inline(always)]
    fn run(mut self) {
        let layout = self.light.layout;
        for (pixel, coverage) in self.pixels.iter_mut().zip(layout.coverage.iter()) {
            pixel[3] = alpha(*coverage);
        }
        for run in &layout.runs {
            let (first, last) = (run.pixel as usize, (run.pixel + run.pixels) as usize);
            if layout.scale >= 1.0 && run.samples == 1 && run.centre == 1 {
                // One ray for each pixel, which hit: nothing to divide by.
                let mut sample = run.start as usize;
                for pixel in (first..last).step_by(TOGETHER) {
                    let count = TOGETHER.min(last - pixel);
                    self.opaque(pixel..pixel + count, sample..sample + count);
                    sample += count;
                }
                continue;
            }
            let coverage = &layout.coverage[first..last];
            let Self { light, curve, factor, pixels } = &mut self;
            let pixels = &mut pixels[first..last];
            light.each_pixel(run, |k, radiance| {
                pixels[k] = pixel(curve, radiance, coverage[k], *factor);
            });
        }
    }
}

impl Development<'_> {
    /// Opaque pixels of one sample each, at most [`TOGETHER`] of them.
    #[inline(always)]
    fn opaque(&mut self, pixels: Range<usize>, samples: Range<usize>) {
        let (scale, factor) = (self.light.layout.scale, self.factor);
        let mut codes = [[0; TOGETHER]; 3];
        for (channel, codes) in codes.iter_mut().enumerate() {
            let (f, irradiance) = self.light.channel(channel, samples.clone());
            let mut exposed = [0.0; TOGETHER];
            match (f.first_chunk::<TOGETHER>(), irradiance.first_chunk::<TOGETHER>()) {
                (Some(f), Some(irradiance)) => expose(&mut exposed, f, irradiance, scale, factor),
                _ => expose(&mut exposed, f, irradiance, scale, factor),
            }
            *codes = self.curve.encode_each(&exposed);
        }
        let [red, green, blue] = &codes;
        let pixels = &mut self.pixels[pixels];
        for (((pixel, red), green), blue) in pixels.iter_mut().zip(red).zip(green).zip(blue) {
            *pixel = (red | green << 8 | blue << 16 | 255 << 24).to_le_bytes();
        }
    }
}

#[inline(always)]
fn expose(exposed: &mut [f32], f: &[f32], irradiance: &[f32], scale: f32, factor: f32) {
    for ((exposed, f), irradiance) in exposed.iter_mut().zip(f).zip(irradiance) {
        *exposed = f * irradiance * scale * factor;
    }
}

#[inline(always)]
fn alpha(coverage: f32) -> u8 {
    (coverage * 255.0 + 0.5) as u8
}

#[inline(always)]
fn pixel(curve: &srgb::Curve, radiance: [f32; 3], coverage: f32, factor: f32) -> [u8; 4] {
    let mut code = [0, 0, 0, alpha(coverage)];
    for (code, channel) in code.iter_mut().zip(radiance) {
        let exposed = channel * factor;
        // Most pixels are covered whole, and a division by 1 changes nothing.
        *code = curve.encode(if coverage < 1.0 { exposed / coverage } else { exposed });
    }
    code
}

#[cfg(test)]
mod tests {
    use brood_genome::{BirthKey, Dialect, Variation};
    use brood_program::Program;
    use brood_scene::{BuiltinMesh, Light, Mesh, Sampling, Scene};

    use super::*;
    use crate::{CanonicalEvaluator, Evaluator, shade};

    #[test]
    fn developing_from_samples_is_shading_and_developing() {
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
                    for exposure in [Exposure::Auto, Exposure::Ev(-1.5)] {
                        let gain = Gain::new(exposure, &set, f);
                        let developed = develop_samples(&set, f, gain);
                        assert_eq!(developed, develop(&shade(&set, f), exposure));
                        assert!(developed.rgba.chunks(4).any(|p| p[3] == 255 && p[..3] != [0; 3]));
                    }
                }
            }
            scene.lights.push(Light::Point {
                position: Some([-4.0, 1.0, f64::from(lights)]),
                intensity: None,
            });
        }
    }
}
