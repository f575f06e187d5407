//! The set of samples and the inputs computed from them.

use std::ops::Range;
use std::sync::OnceLock;
use std::sync::atomic::{AtomicU64, Ordering};

use brood_brdf::{DirectionPair, Input, LightInput, Lighting};
use glam::DVec2;

use super::layout::{ImageLayout, SampleCounts};
use super::seen_point::{Footprint, SeenPoint};
use super::values::{Values, round_to_f32};

/// Shading samples as a structure of arrays.
///
/// # Shapes
/// Every array has [`SampleSet::len`] entries. In the set of an image, samples are ordered by
/// pixel; within a pixel, samples of the ray through the pixel's centre come first. Only lit
/// samples on the mesh are stored ([`ImageLayout`]). In a set of points for painted materials a
/// sample is a surface point, lit or not, with its share of the pixel as irradiance.
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
    pub(super) lighting: Option<Lighting>,
    /// Surface point of each sample, if they are kept.
    pub(super) seen: Vec<SeenPoint>,
    /// Changes of the texture position over each sample's part of a pixel, if it is a point.
    pub(super) footprints: Vec<Footprint>,
}

impl SampleSet {
    /// Makes one sample per direction pair, with irradiance 1 and no image. Empty `uvs` mean zeros.
    /// For painted materials, each sample is a point that one white light at wi reaches.
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
        let lighting = Some(Lighting { lights: 1, has_shadows: false });
        Self { lighting, ..Self::new(pairs.to_vec(), uvs, irradiance, None, counts) }
    }

    /// Returns a set of points in these lights, for painted materials. `columns` has the inputs of
    /// painted materials that are not those of one white light at wi, with the value of each
    /// sample.
    ///
    /// # Domain
    /// Finite values within the range of the machine.
    ///
    /// # Panics
    /// If a column has another length than the set.
    #[must_use]
    pub fn with_lights(
        mut self,
        lighting: Lighting,
        columns: impl IntoIterator<Item = (Input, Vec<f32>)>,
    ) -> Self {
        self.lighting = Some(lighting);
        self.put_columns(columns);
        self
    }

    /// Returns a copy with further inputs of painted materials: the value of each sample, in place
    /// of what the set has. The copy has an id of its own.
    ///
    /// # Domain
    /// Finite values within the range of the machine.
    ///
    /// # Panics
    /// If a column has another length than the set.
    #[must_use]
    pub fn with_columns(&self, columns: impl IntoIterator<Item = (Input, Vec<f32>)>) -> Self {
        let (pairs, uvs) = (self.pairs.clone(), self.uvs.clone());
        let new = Self::new(pairs, uvs, self.irradiance.clone(), self.image.clone(), self.counts);
        let (len, inputs, lighting) = (self.len, self.inputs.clone(), self.lighting);
        let footprints = self.footprints.clone();
        let mut copy = Self { len, inputs, lighting, footprints, ..new };
        copy.put_columns(columns);
        copy
    }

    fn put_columns(&mut self, columns: impl IntoIterator<Item = (Input, Vec<f32>)>) {
        for (input, values) in columns {
            assert_eq!(values.len(), self.len, "one value of {input:?} for each sample");
            let column = OnceLock::from(Values::compute(values.len(), |index| values[index]));
            self.inputs[input.index()] = column;
        }
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
            inputs: [const { OnceLock::new() }; Input::ALL.len()],
            lighting: None,
            seen: Vec::new(),
            footprints: Vec::new(),
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

    /// Returns the lights that painted materials are lowered for, if the samples are points; `None`
    /// if they are samples of light.
    #[must_use]
    pub fn lighting(&self) -> Option<Lighting> {
        self.lighting
    }

    /// Returns the numbers of traced rays and of stored, skipped and shadowed samples.
    #[must_use]
    pub fn counts(&self) -> SampleCounts {
        self.counts
    }

    /// Returns the number of inputs that programs may read on this set: of BRDFs, or also of
    /// painted materials and their lights.
    fn columns(&self) -> usize {
        match self.lighting {
            None => Input::SYMMETRIC,
            Some(Lighting { lights, .. }) => {
                Input::ALL.len()
                    - (Input::LIGHTS - lights) * LightInput::ALL.len()
                    - Input::of_glass().count()
                    - Input::IMAGES.as_flattened().len()
            }
        }
    }

    /// Returns an upper bound of the set's memory in bytes, with every input computed.
    #[must_use]
    pub fn bytes(&self) -> usize {
        let per_sample = size_of::<DirectionPair>()
            + size_of::<DVec2>()
            + (self.irradiance.len() + self.columns()) * size_of::<f32>();
        let layout = self.image.as_ref().map_or(0, ImageLayout::bytes);
        let seen = size_of_val(self.seen.as_slice()) + size_of_val(self.footprints.as_slice());
        size_of::<Self>() + self.len() * per_sample + layout + seen
    }
}
