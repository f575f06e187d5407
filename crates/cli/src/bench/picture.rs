//! Pictures for measuring: at a sampling mode in canonical f32, and the f64 reference at many samples a pixel.

use std::collections::HashMap;

use anyhow::Result;
use brood_eval::{
    CanonicalEvaluator, Evaluator, FineSamples, RadianceImage, ReferenceEvaluator, RoughTile,
    develop, rough_tiles, shade,
};
use brood_program::Program;
use brood_scene::{Exposure, Mesh, PixelArea, SampleSet, Sampling, Scene};

/// How a pixel is sampled; by default as pictures are where nothing else is asked for.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Mode(Sampling);

impl Mode {
    /// The modes that are compared.
    pub fn all() -> Vec<Self> {
        let fixed = [1, 4, 16, 64].map(|samples| Self(Sampling::Fixed(samples)));
        fixed.into_iter().chain([Self(Sampling::Adaptive)]).collect()
    }

    /// As requests name it.
    pub fn name(self) -> String {
        self.0.to_string()
    }

    /// Whether pictures are made this way where nothing else is asked for.
    pub fn is_default(self) -> bool {
        self == Self::default()
    }

    /// Whether pixels get what they need instead of a number.
    pub fn is_adaptive(self) -> bool {
        self.0 == Sampling::Adaptive
    }

    /// The samples of a picture.
    pub fn set(self, mesh: &Mesh, scene: &Scene, size_px: u32) -> SampleSet {
        SampleSet::render(mesh, scene, size_px, self.0)
    }
}

/// Linear radiance of a program, canonical bits; `f` is room that is used again.
pub fn canonical(set: &SampleSet, program: &Program, f: &mut Vec<f32>) -> Result<RadianceImage> {
    CanonicalEvaluator::default().eval(&[program], set, f)?;
    Ok(shade(set, f))
}

/// Pictures of one mesh in one mode as the product makes them, with everything kept that it keeps.
pub struct Studio<'a> {
    mesh: &'a Mesh,
    scene: &'a Scene,
    size_px: u32,
    mode: Mode,
    set: SampleSet,
    /// Fine samples, made where a material first needs them.
    tiles: HashMap<usize, SampleSet>,
    f: Vec<f32>,
}

impl<'a> Studio<'a> {
    /// Takes the set of that mode in, so that making it can be timed.
    pub fn new(
        mesh: &'a Mesh,
        scene: &'a Scene,
        size_px: u32,
        (mode, set): (Mode, SampleSet),
    ) -> Self {
        Self { mesh, scene, size_px, mode, set, tiles: HashMap::new(), f: Vec::new() }
    }

    /// The mode.
    pub fn mode(&self) -> Mode {
        self.mode
    }

    /// Samples of a picture, without those of rough pixels.
    pub fn samples(&self) -> usize {
        self.set.len()
    }

    /// Linear radiance over black and the automatic exposure in EV: evaluated, shaded and developed, and with more samples
    /// in the pixels that look rough, where the mode is adaptive.
    pub fn picture(&mut self, program: &Program) -> Result<(Vec<[f32; 3]>, f64)> {
        let Self { mesh, scene, size_px, set, tiles, f, .. } = self;
        let image = canonical(set, program, f)?;
        let developed = develop(&image, Exposure::Auto);
        let mut pixels = image.premultiplied().to_vec();
        let rough = rough_tiles(set, &developed);
        for RoughTile { number, tile, .. } in &rough {
            tiles.entry(*number).or_insert_with(|| {
                SampleSet::render_area(mesh, scene, *size_px, RoughTile::SAMPLING, *tile)
            });
        }
        let rough: Vec<_> = rough.iter().map(|rough| (rough, &tiles[&rough.number])).collect();
        for fine in FineSamples::batches(&rough, program) {
            CanonicalEvaluator::default().eval(&[program], &fine.set, f)?;
            fine.radiance(f, |pixel, radiance| pixels[pixel] = radiance);
        }
        Ok((pixels, developed.exposure_ev))
    }
}

/// The pixels of a picture times 2^`ev`, over black.
pub fn exposed(pixels: &[[f32; 3]], ev: f64) -> Vec<[f64; 3]> {
    let factor = libm::exp2(ev);
    pixels.iter().map(|rgb| rgb.map(|value| f64::from(value) * factor)).collect()
}

/// Samples held at once while a reference is made: some hundred bytes each.
const SAMPLES_AT_ONCE: u32 = 4 << 20;

/// A picture that others are held against.
#[derive(Debug, Clone, Copy)]
pub struct Yardstick<'a> {
    /// What is looked at.
    pub mesh: &'a Mesh,
    /// How.
    pub scene: &'a Scene,
    /// Side of the picture.
    pub size_px: u32,
    /// Rays in every pixel.
    pub samples: u16,
}

impl Yardstick<'_> {
    /// The same with half as many rays: how far it is from this one bounds, about, how far this one is from the truth.
    pub fn halved(self) -> Self {
        Self { samples: self.samples / 2, ..self }
    }

    /// Rows of pixels that are made together.
    fn band(&self) -> u32 {
        (SAMPLES_AT_ONCE / u32::from(self.samples) / self.size_px).clamp(1, self.size_px)
    }

    /// How often `step` is called by [`Yardstick::pictures`].
    pub fn steps(&self) -> u64 {
        self.size_px.div_ceil(self.band()).into()
    }

    /// Linear radiance of each program in f64, band by band, so that memory does not grow with the picture.
    pub fn pictures(&self, programs: &[&Program], step: impl Fn()) -> Vec<Vec<[f64; 3]>> {
        let mut pictures = vec![Vec::new(); programs.len()];
        let (band, sampling) = (self.band(), Sampling::Fixed(self.samples));
        for y in (0..self.size_px).step_by(band as usize) {
            let height = band.min(self.size_px - y);
            let area = PixelArea { x: 0, y, width: self.size_px, height };
            let set = SampleSet::render_area(self.mesh, self.scene, self.size_px, sampling, area);
            for (picture, program) in pictures.iter_mut().zip(programs) {
                picture.extend(reference(&set, program));
            }
            step();
        }
        pictures
    }
}

/// Linear radiance in f64 throughout, but for inputs and irradiance, which every evaluator reads as f32.
pub fn reference(set: &SampleSet, program: &Program) -> Vec<[f64; 3]> {
    let layout = set.image().expect("the samples are those of a picture");
    let irradiance = set.irradiance();
    let f = ReferenceEvaluator::reflectance(program, set);
    let mut pixels = vec![[0.0; 3]; layout.coverage.len()];
    for span in layout.spans() {
        let pixel = &mut pixels[span.pixel as usize];
        for sample in span.counted as usize..span.end as usize {
            for (channel, sum) in pixel.iter_mut().enumerate() {
                *sum += f[sample][channel] * f64::from(irradiance[channel][sample]);
            }
        }
        *pixel = pixel.map(|sum| sum * f64::from(layout.scale));
    }
    pixels
}

/// Pixels times 2^`ev`.
pub fn expose(pixels: &[[f64; 3]], ev: f64) -> Vec<[f64; 3]> {
    let factor = libm::exp2(ev);
    pixels.iter().map(|rgb| rgb.map(|value| value * factor)).collect()
}

#[cfg(test)]
mod tests {
    use brood_scene::BuiltinMesh;

    use super::super::measure::{difference, programs};
    use super::*;

    #[test]
    fn yardstick_is_the_picture_of_one_set_whatever_its_bands() {
        let (mesh, scene) = (Mesh::builtin(BuiltinMesh::Knob), Scene::default());
        let programs = programs(5, 2);
        let programs: Vec<&Program> = programs.iter().collect();
        // Bands of 2 rows: 60 x 30000 samples are nearly half of what is held.
        let (size_px, samples) = (60, 30_000);
        let yardstick = Yardstick { mesh: &mesh, scene: &scene, size_px, samples };
        assert_eq!((yardstick.band(), yardstick.steps()), (2, 30));
        let small = Yardstick { size_px: 9, samples: 5, ..yardstick };
        let set = SampleSet::render(&mesh, &scene, 9, Sampling::Fixed(5));
        let whole: Vec<_> = programs.iter().map(|program| reference(&set, program)).collect();
        assert_eq!(small.pictures(&programs, || ()), whole);
    }

    #[test]
    fn reference_is_the_canonical_picture_but_for_rounding() {
        let set = Mode(Sampling::Fixed(4)).set(
            &Mesh::builtin(BuiltinMesh::Sphere),
            &Scene::default(),
            16,
        );
        for program in programs(5, 6) {
            let exact = reference(&set, &program);
            let canonical = canonical(&set, &program, &mut Vec::new()).unwrap();
            let canonical = exposed(canonical.premultiplied(), 0.0);
            let brightest = exact.as_flattened().iter().copied().fold(1e-30, f64::max);
            let apart = difference(&canonical, &exact, f64::INFINITY).rmse / brightest;
            assert!(apart < 1e-2, "{apart}");
        }
    }
}
