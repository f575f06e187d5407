//! The sample set: the one batch type that every evaluator shades.
//!
//! Owns the pairs of directions, what is computed from them at first use, the light that falls on each sample, and the
//! way back from samples to pixels. Knows nothing of programs and colours.

#[cfg(test)]
mod adaptive_tests;
mod cluster;
mod frame;
mod layout;
#[cfg(test)]
mod light_tests;
mod lighting;
mod pick;
mod point;
mod quadrature;
mod render;
mod sampling;
mod select;
mod sequence;
#[cfg(test)]
mod tests;
mod values;
mod view;

use std::ops::Range;
use std::sync::OnceLock;
use std::sync::atomic::{AtomicU64, Ordering};

use brood_brdf::{DirectionPair, Input, InputMask};
use glam::DVec2;

pub use layout::{ImageLayout, PixelRun, PixelSpan, SampleCounts};

pub use sampling::{PixelArea, PixelAreaError, Raster, Sampling, SamplingError};

use crate::{LightAssets, Mesh, Scene};
use values::Values;

/// Shading samples as a structure of arrays.
///
/// # Shapes
/// Every array has [`SampleSet::len`] entries. In sets of an image, samples are in the order of pixels, in a pixel those
/// of the ray through its centre come first, and only lit and covered ones are there ([`ImageLayout`]).
#[derive(Debug)]
pub struct SampleSet {
    id: u64,
    len: usize,
    /// As many as samples; none in a set of pixels that were picked without them.
    pairs: Vec<DirectionPair>,
    uvs: Vec<DVec2>,
    irradiance: [Vec<f32>; 3],
    image: Option<ImageLayout>,
    counts: SampleCounts,
    inputs: [OnceLock<Values>; Input::ALL.len()],
}

impl SampleSet {
    /// The samples of a square picture of `mesh` in `scene`, whose own mesh reference is not looked at.
    ///
    /// # Domain
    /// A scene that [`Scene::validate`] accepts; another one gives a meaningless set. Lights that refer to assets are dark.
    ///
    /// # Panics
    /// Where `size_px` is not in 1..=65535, a fixed number of samples is 0, or the set would have 2^32 samples.
    ///
    /// # Error
    /// The same to the bit for any number of threads.
    #[must_use]
    pub fn render(mesh: &Mesh, scene: &Scene, size_px: u32, sampling: impl Into<Sampling>) -> Self {
        Self::render_area(mesh, scene, size_px, sampling, PixelArea::whole(size_px))
    }

    /// The samples of a part of that picture: those of the whole picture in these pixels, to the bit.
    ///
    /// # Panics
    /// As [`SampleSet::render`], and where the area is empty or not within the picture.
    #[must_use]
    pub fn render_area(
        mesh: &Mesh,
        scene: &Scene,
        size_px: u32,
        sampling: impl Into<Sampling>,
        area: PixelArea,
    ) -> Self {
        let raster = Raster { size_px, sampling: sampling.into(), area };
        Self::render_lit(mesh, scene, &LightAssets::default(), raster)
    }

    /// The same for scenes whose lights refer to assets. A light whose asset is not there is dark ([`LightAssets::check`]
    /// tells).
    ///
    /// # Panics
    /// As [`SampleSet::render_area`].
    #[must_use]
    pub fn render_lit(mesh: &Mesh, scene: &Scene, assets: &LightAssets, raster: Raster) -> Self {
        render::render(mesh, scene, assets, raster)
    }

    /// The samples of some pixels of images that were sampled alike, as an image of one row, part after part. Of the inputs it
    /// has only those asked for, and directions only where `directions` says so; ranges of inputs are those of the whole parts.
    ///
    /// # Panics
    /// Where a part has no image, or its pixels do not ascend or are not in it.
    #[must_use]
    pub fn pick(parts: &[(&Self, &[u32])], inputs: InputMask, directions: bool) -> Self {
        pick::pick(parts, inputs, directions)
    }

    /// One sample per pair of directions with irradiance 1 and no image; no `uvs` at all stand for zeros.
    ///
    /// # Domain
    /// Finite `uvs`. Pairs below the surface are kept.
    ///
    /// # Panics
    /// Where `uvs` is neither empty nor as long as `pairs`.
    #[must_use]
    pub fn from_pairs(pairs: &[DirectionPair], uvs: &[DVec2]) -> Self {
        let count = pairs.len();
        assert!(uvs.is_empty() || uvs.len() == count, "{} uvs for {count} pairs", uvs.len());
        let uvs = if uvs.is_empty() { vec![DVec2::ZERO; count] } else { uvs.to_vec() };
        let counts =
            SampleCounts { covered: count as u64, lit: count as u64, ..SampleCounts::default() };
        let irradiance = [(); 3].map(|()| vec![1.0; count]);
        Self::new(pairs.to_vec(), uvs, irradiance, None, counts)
    }

    fn new(
        pairs: Vec<DirectionPair>,
        uvs: Vec<DVec2>,
        irradiance: [Vec<f32>; 3],
        image: Option<ImageLayout>,
        counts: SampleCounts,
    ) -> Self {
        // An identity for caches alone: no value ever depends on it.
        static NEXT_ID: AtomicU64 = AtomicU64::new(0);
        let id = NEXT_ID.fetch_add(1, Ordering::Relaxed);
        Self {
            id,
            len: pairs.len(),
            pairs,
            uvs,
            irradiance,
            image,
            counts,
            inputs: Default::default(),
        }
    }

    /// A number that no other set of this process has, so that copies on devices can be told apart.
    #[must_use]
    pub fn id(&self) -> u64 {
        self.id
    }

    /// Number of samples.
    #[must_use]
    pub fn len(&self) -> usize {
        self.len
    }

    /// Whether there is no sample.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len == 0
    }

    /// An input for every sample: computed in f64 and rounded once, at first use, then kept.
    ///
    /// # Panics
    /// In a set of picked pixels, for an input that was not picked with them.
    #[must_use]
    pub fn input(&self, input: Input) -> &[f32] {
        self.kept(input)
    }

    /// Between these are all values of an input; both 0 where there is none. In sets that were not picked, the least and the
    /// largest.
    ///
    /// # Panics
    /// As [`SampleSet::input`].
    #[must_use]
    pub fn input_range(&self, input: Input) -> (f32, f32) {
        self.kept(input).range()
    }

    fn kept(&self, input: Input) -> &Values {
        let kept = &self.inputs[input.index()];
        if kept.get().is_none() {
            assert!(self.pairs.len() == self.len, "{input:?} was not picked with these pixels");
            // Not inside `get_or_init`: a thread that waits for its share of this loop may be given a task that asks
            // for the same input, and would wait for itself. Computing twice does no harm.
            let values = Values::compute(self.len(), |index| {
                round_to_f32(input.evaluate(&self.pairs[index], self.uvs[index]))
            });
            kept.get_or_init(|| values);
        }
        kept.get().expect("the input has just been computed")
    }

    /// The directions and the texture position of a sample.
    ///
    /// # Panics
    /// Where there is no such sample, and in a set of pixels that were picked without directions.
    #[must_use]
    #[inline]
    pub fn pair(&self, index: usize) -> (DirectionPair, DVec2) {
        (self.pairs[index], self.uvs[index])
    }

    /// The directions of these samples.
    ///
    /// # Panics
    /// As [`SampleSet::pair`].
    #[must_use]
    pub fn pairs(&self, range: Range<usize>) -> &[DirectionPair] {
        &self.pairs[range]
    }

    /// For red, green and blue: the light per sample, which reflected radiance is f times.
    ///
    /// # Units
    /// Irradiance at normal incidence times cos_i; finite, not negative. 1 in sets of pairs.
    #[must_use]
    pub fn irradiance(&self) -> [&[f32]; 3] {
        [&self.irradiance[0], &self.irradiance[1], &self.irradiance[2]]
    }

    /// The way back to pixels, for sets that a scene made.
    #[must_use]
    pub fn image(&self) -> Option<&ImageLayout> {
        self.image.as_ref()
    }

    /// How much was traced and how much of it is here.
    #[must_use]
    pub fn counts(&self) -> SampleCounts {
        self.counts
    }

    /// Memory that the set takes at most, with every input computed.
    #[must_use]
    pub fn bytes(&self) -> usize {
        let per_sample = size_of::<DirectionPair>()
            + size_of::<DVec2>()
            + (self.irradiance.len() + Input::ALL.len()) * size_of::<f32>();
        let layout = self.image.as_ref().map_or(0, ImageLayout::bytes);
        size_of::<Self>() + self.len() * per_sample + layout
    }
}

/// Rounded to the nearest f32; beyond its range the largest finite one.
fn round_to_f32(value: f64) -> f32 {
    (value as f32).clamp(f32::MIN, f32::MAX)
}
