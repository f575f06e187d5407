//! Rendering for the benchmarks: pictures in canonical f32 at a sampling mode, and the f64
//! reference at many samples per pixel.

use std::collections::HashMap;

use anyhow::Result;
use brood_eval::{
    CanonicalEvaluator, Evaluator, FineSamples, RadianceImage, ReferenceEvaluator, RoughTile,
    develop, rough_tiles, shade,
};
use brood_mesh::Mesh;
use brood_program::Program;
use brood_scene::{Exposure, PixelArea, SampleSet, Sampling, Scene};

/// Sampling of pixels; the default is that of brood.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Mode(Sampling);

impl Mode {
    /// Modes that are compared.
    pub fn all() -> Vec<Self> {
        let fixed = [1, 4, 16, 64].map(|samples| Self(Sampling::Fixed(samples)));
        fixed.into_iter().chain([Self(Sampling::Adaptive)]).collect()
    }

    /// Name in requests.
    pub fn name(self) -> String {
        self.0.to_string()
    }

    /// True if brood uses this mode by default.
    pub fn is_default(self) -> bool {
        self == Self::default()
    }

    /// True if the number of samples adapts to the pixel.
    pub fn is_adaptive(self) -> bool {
        self.0 == Sampling::Adaptive
    }

    /// Sample set of a picture.
    pub fn set(self, mesh: &Mesh, scene: &Scene, size_px: u32) -> SampleSet {
        SampleSet::render(mesh, scene, size_px, self.0)
    }
}

/// Linear radiance of a program in canonical f32; `f` is a buffer that callers reuse.
pub fn canonical(set: &SampleSet, program: &Program, f: &mut Vec<f32>) -> Result<RadianceImage> {
    CanonicalEvaluator::default().eval(&[program], set, f)?;
    Ok(shade(set, f))
}

/// Renders one mesh in one mode as a worker does, with the same caches.
pub struct ModeRenderer<'a> {
    mesh: &'a Mesh,
    scene: &'a Scene,
    size_px: u32,
    mode: Mode,
    set: SampleSet,
    /// Fine samples by tile, computed when a material first needs them.
    tiles: HashMap<usize, SampleSet>,
    f: Vec<f32>,
}

impl<'a> ModeRenderer<'a> {
    /// Takes ownership of the set of that mode, so that callers can time its construction.
    pub fn new(
        mesh: &'a Mesh,
        scene: &'a Scene,
        size_px: u32,
        (mode, set): (Mode, SampleSet),
    ) -> Self {
        Self { mesh, scene, size_px, mode, set, tiles: HashMap::new(), f: Vec::new() }
    }

    /// Mode of the pictures.
    pub fn mode(&self) -> Mode {
        self.mode
    }

    /// Number of samples of a picture, without those of rough pixels.
    pub fn samples(&self) -> usize {
        self.set.len()
    }

    /// Linear radiance over black, and the automatic exposure in EV. Evaluates, shades and
    /// develops; in adaptive mode it adds samples in rough pixels.
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

/// Pixels of a picture times 2^`ev`, over black.
pub fn exposed(pixels: &[[f32; 3]], ev: f64) -> Vec<[f64; 3]> {
    let factor = libm::exp2(ev);
    pixels.iter().map(|rgb| rgb.map(|value| f64::from(value) * factor)).collect()
}

/// Largest number of samples in memory while a reference is rendered; a sample takes some hundred
/// bytes.
const SAMPLES_AT_ONCE: u32 = 4 << 20;

/// Renders the f64 picture that others are compared with.
#[derive(Debug, Clone, Copy)]
pub struct ReferenceRender<'a> {
    /// Mesh in the picture.
    pub mesh: &'a Mesh,
    /// Scene of the picture.
    pub scene: &'a Scene,
    /// Side of the picture in pixels.
    pub size_px: u32,
    /// Number of rays per pixel.
    pub samples: u16,
}

impl ReferenceRender<'_> {
    /// The same with half as many rays; its difference from this one estimates the error of this
    /// one.
    pub fn halved(self) -> Self {
        Self { samples: self.samples / 2, ..self }
    }

    /// Number of pixel rows rendered together.
    fn band(&self) -> u32 {
        (SAMPLES_AT_ONCE / u32::from(self.samples) / self.size_px).clamp(1, self.size_px)
    }

    /// Number of times that [`ReferenceRender::pictures`] calls `step`.
    pub fn steps(&self) -> u64 {
        self.size_px.div_ceil(self.band()).into()
    }

    /// Linear radiance of each program in f64, rendered in bands so that memory does not grow with
    /// the picture.
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

/// Linear radiance in f64, except for inputs and irradiance, which every evaluator reads as f32.
pub fn reference(set: &SampleSet, program: &Program) -> Vec<[f64; 3]> {
    let layout = set.image().expect("the set was rendered for a picture");
    let irradiance = set.irradiance();
    let f = ReferenceEvaluator::reflectance(program, set);
    let mut pixels = vec![[0.0; 3]; layout.coverage.len()];
    for span in layout.spans() {
        let pixel = &mut pixels[span.pixel as usize];
        for sample in span.radiance_start as usize..span.end as usize {
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
    use brood_mesh::BuiltinMesh;

    use super::super::measure::{difference, programs};
    use super::*;

    #[test]
    fn reference_render_does_not_depend_on_its_bands() {
        let (mesh, scene) = (Mesh::builtin(BuiltinMesh::Knob), Scene::default());
        let programs = programs(5, 2);
        let programs: Vec<&Program> = programs.iter().collect();
        // Bands of 2 rows: 60 x 30000 samples are nearly half of the memory limit.
        let (size_px, samples) = (60, 30_000);
        let reference_render = ReferenceRender { mesh: &mesh, scene: &scene, size_px, samples };
        assert_eq!((reference_render.band(), reference_render.steps()), (2, 30));
        let small = ReferenceRender { size_px: 9, samples: 5, ..reference_render };
        let set = SampleSet::render(&mesh, &scene, 9, Sampling::Fixed(5));
        let whole: Vec<_> = programs.iter().map(|program| reference(&set, program)).collect();
        assert_eq!(small.pictures(&programs, || ()), whole);
    }

    #[test]
    fn reference_equals_the_canonical_picture_up_to_rounding() {
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
            let error = difference(&canonical, &exact, f64::INFINITY).rmse / brightest;
            assert!(error < 1e-2, "{error}");
        }
    }
}
