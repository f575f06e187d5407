//! Visible difference between pictures of one object: mean FLIP and Delta E_ITP over the object.

use anyhow::Result;
use brood_eval::{Developed, decode_srgb};
use brood_genome::oklab::Oklab;
use brood_inspect::LinearImage;
use brood_mesh::BuiltinMesh;
use brood_program::Program;
use brood_protocol::{Backend, Frame, MeshSource, PictureFormat};
use brood_scene::{Sampling, Scene};
use brood_worker::Renderer;

use super::measure::quantile;

/// Luminance of a display's white in cd/m2, for Delta E_ITP.
const WHITE: f64 = 100.0;
/// Codes of channels below this count as black, as in previews.
const BLACK: u8 = 20;

/// Pictures of programs on the sphere of the default scene, ready for comparison.
pub struct PictureSet {
    /// 8-bit RGB over black, because FLIP compares opaque pictures.
    images: Vec<Vec<u8>>,
    size_px: u32,
    /// Share of the picture covered by the object.
    covered: f64,
    /// Indices of the pixels that the object covers.
    object: Vec<usize>,
}

impl PictureSet {
    /// Renders the programs at `size_px` pixels a side and automatic exposure.
    ///
    /// # Errors
    /// Returns the errors of the renderer.
    pub fn of(programs: &[&Program], size_px: u32) -> Result<Self> {
        let renderer = Renderer::new(Backend::Cpu);
        let on = (&Scene::default(), BuiltinMesh::Sphere);
        Self::on(&renderer, on, programs, size_px)
    }

    /// Renders the programs on a built-in mesh in a scene.
    ///
    /// # Errors
    /// Returns the errors of the renderer.
    pub fn on(
        renderer: &Renderer,
        (scene, mesh): (&Scene, BuiltinMesh),
        programs: &[&Program],
        size_px: u32,
    ) -> Result<Self> {
        let how = (PictureFormat::Png, Backend::Cpu);
        let frame = Frame::new(scene, MeshSource::Builtin, size_px, Sampling::Adaptive, how);
        let mesh = renderer.builtin(mesh);
        let pictures = renderer.develop(&frame, &mesh, programs)?;
        let object: Vec<usize> = pictures.first().map_or(Vec::new(), |picture| {
            let pixels = picture.rgba.chunks(4).enumerate();
            pixels.filter(|(_, pixel)| pixel[3] > 0).map(|(at, _)| at).collect()
        });
        Ok(Self {
            images: pictures.iter().map(over_black).collect(),
            size_px,
            covered: object.len() as f64 / f64::from(size_px * size_px),
            object,
        })
    }

    /// Number of pictures.
    pub fn len(&self) -> usize {
        self.images.len()
    }

    /// Share of the object that is black in a picture: no channel reaches [`BLACK`].
    pub fn black(&self, picture: usize) -> f64 {
        let pixels = self.images[picture].chunks(3);
        let black = pixels.filter(|pixel| pixel.iter().all(|code| *code < BLACK)).count();
        // Pixels outside the object are black too.
        let outside = 1.0 - self.covered;
        let share = black as f64 / f64::from(self.size_px * self.size_px);
        ((share - outside) / self.covered).max(0.0)
    }

    /// Mean FLIP over all pairs of pictures; 0 if there is only one.
    pub fn spread(&self) -> f64 {
        let pairs = (0..self.len()).flat_map(|one| (0..one).map(move |other| (one, other)));
        let all: Vec<f64> = pairs.map(|(one, other)| self.flip(one, other)).collect();
        all.iter().sum::<f64>() / all.len().max(1) as f64
    }

    /// Mean FLIP over the object between two pictures, 0 to 1.
    pub fn flip(&self, one: usize, other: usize) -> f64 {
        let size = (self.size_px, self.size_px);
        brood_inspect::flip(size, &self.images[one], &self.images[other]) / self.covered
    }

    /// Mean Delta E_ITP over the object between two pictures on a display.
    pub fn itp(&self, one: usize, other: usize) -> f64 {
        self.linear(one).itp(&self.linear(other), WHITE) / self.covered
    }

    /// Mean difference in codes of 255 over the object and the channels.
    pub fn codes(&self, one: usize, other: usize) -> f64 {
        let pixels = |picture: usize| self.images[picture].as_chunks::<3>().0;
        let (one, other) = (pixels(one), pixels(other));
        let apart = |at: &usize| {
            let pairs = one[*at].iter().zip(&other[*at]);
            pairs.map(|(a, b)| f64::from(a.abs_diff(*b))).sum::<f64>() / 3.0
        };
        self.object.iter().map(apart).sum::<f64>() / self.object.len().max(1) as f64
    }

    /// Range of lightness in Oklab over the object, from the 5 % to the 95 % quantile.
    pub fn lightness_range(&self, picture: usize) -> f64 {
        let pixels = self.images[picture].as_chunks::<3>().0;
        let lightness = self.object.iter().map(|at| Oklab::of_codes(pixels[*at]).lightness);
        let lightness: Vec<f64> = lightness.collect();
        quantile(&lightness, 0.95) - quantile(&lightness, 0.05)
    }

    fn linear(&self, picture: usize) -> LinearImage {
        let linear = |rgb: &[u8; 3]| rgb.map(|code| decode_srgb(f64::from(code) / 255.0));
        let pixels = self.images[picture].as_chunks::<3>().0;
        LinearImage::new(self.size_px, self.size_px, pixels.iter().map(linear).collect())
    }
}

fn over_black(picture: &Developed) -> Vec<u8> {
    let over = |pixel: &[u8]| {
        let alpha = u16::from(pixel[3]);
        [0, 1, 2].map(|channel| (u16::from(pixel[channel]) * alpha / 255) as u8)
    };
    picture.rgba.chunks(4).flat_map(over).collect()
}
