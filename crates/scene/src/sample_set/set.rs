//! The set of samples and the inputs computed from them.

use std::ops::Range;
use std::sync::OnceLock;
use std::sync::atomic::{AtomicU64, Ordering};

use brood_brdf::{DirectionPair, Input};
use glam::DVec2;

use super::layout::{ImageLayout, SampleCounts};
use super::values::{Values, round_to_f32};

/// Shading samples as a structure of arrays.
///
/// # Shapes
/// Every array has [`SampleSet::len`] entries. In the set of an image, samples are ordered by
/// pixel; within a pixel, samples of the ray through the pixel's centre come first. Only lit
/// samples on the mesh are stored ([`ImageLayout`]).
#[derive(Debug)]
pub struct SampleSet {
    id: u64,
    pub(super) len: usize,
    /// One per sample; empty in a set picked without directions.
    pub(super) pairs: Vec<DirectionPair>,
    pub(super) uvs: Vec<DVec2>,
    pub(super) irradiance: [Vec<f32>; 3],
    pub(super) image: Option<ImageLayout>,
    pub(super) counts: SampleCounts,
    pub(super) inputs: [OnceLock<Values>; Input::ALL.len()],
}

impl SampleSet {
    /// Makes one sample per direction pair, with irradiance 1 and no image. Empty `uvs` mean zeros.
    ///
    /// # Domain
    /// Finite `uvs`. Pairs below the surface are kept.
    ///
    /// # Panics
    /// If `uvs` is neither empty nor as long as `pairs`.
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

    pub(super) fn new(
        pairs: Vec<DirectionPair>,
        uvs: Vec<DVec2>,
        irradiance: [Vec<f32>; 3],
        image: Option<ImageLayout>,
        counts: SampleCounts,
    ) -> Self {
        // Key of caches only: no computed value depends on it.
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

    /// Returns the id of this set, unique in this process: the key of copies cached on devices.
    #[must_use]
    pub fn id(&self) -> u64 {
        self.id
    }

    /// Number of samples.
    #[must_use]
    pub fn len(&self) -> usize {
        self.len
    }

    /// True if the set has no samples.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len == 0
    }

    /// Returns a program input for every sample. It is computed on first use, in f64 with one
    /// rounding to f32, and cached.
    ///
    /// # Panics
    /// If the set was made by [`SampleSet::pick`] without this input.
    #[must_use]
    pub fn input(&self, input: Input) -> &[f32] {
        self.cached(input)
    }

    /// Returns bounds of all values of an input; both are 0 in an empty set. They are the exact
    /// minimum and maximum unless the set was made by [`SampleSet::pick`].
    ///
    /// # Panics
    /// As [`SampleSet::input`].
    #[must_use]
    pub fn input_range(&self, input: Input) -> (f32, f32) {
        self.cached(input).range()
    }

    pub(super) fn cached(&self, input: Input) -> &Values {
        let cache = &self.inputs[input.index()];
        if cache.get().is_none() {
            assert!(
                self.pairs.len() == self.len,
                "input {input:?} was not picked with these pixels"
            );
            // Not inside `get_or_init`: while a rayon thread waits for this loop it may steal a
            // task that needs the same input, and would deadlock on itself. Computing twice is
            // harmless.
            let values = Values::compute(self.len(), |index| {
                round_to_f32(input.evaluate(&self.pairs[index], self.uvs[index]))
            });
            cache.get_or_init(|| values);
        }
        cache.get().expect("the input has just been computed")
    }

    /// Returns the directions and the texture position of a sample.
    ///
    /// # Panics
    /// If `index` is out of range, or the set was picked without directions.
    #[must_use]
    #[inline]
    pub fn pair(&self, index: usize) -> (DirectionPair, DVec2) {
        (self.pairs[index], self.uvs[index])
    }

    /// Returns the directions of a range of samples.
    ///
    /// # Panics
    /// As [`SampleSet::pair`].
    #[must_use]
    pub fn pairs(&self, range: Range<usize>) -> &[DirectionPair] {
        &self.pairs[range]
    }

    /// Returns the irradiance of each sample in red, green and blue. Reflected radiance is f times
    /// irradiance.
    ///
    /// # Units
    /// Irradiance at normal incidence times cos_i; finite, not negative. 1 in sets made by
    /// [`SampleSet::from_pairs`].
    #[must_use]
    pub fn irradiance(&self) -> [&[f32]; 3] {
        [&self.irradiance[0], &self.irradiance[1], &self.irradiance[2]]
    }

    /// Returns the mapping from samples to pixels; `None` in sets without an image.
    #[must_use]
    pub fn image(&self) -> Option<&ImageLayout> {
        self.image.as_ref()
    }

    /// Returns the numbers of traced rays and of stored, skipped and shadowed samples.
    #[must_use]
    pub fn counts(&self) -> SampleCounts {
        self.counts
    }

    /// Returns an upper bound of the set's memory in bytes, with every input computed.
    #[must_use]
    pub fn bytes(&self) -> usize {
        let per_sample = size_of::<DirectionPair>()
            + size_of::<DVec2>()
            + (self.irradiance.len() + Input::ALL.len()) * size_of::<f32>();
        let layout = self.image.as_ref().map_or(0, ImageLayout::bytes);
        size_of::<Self>() + self.len() * per_sample + layout
    }
}
