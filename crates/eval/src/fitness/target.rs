//! Target that programs are fitted to: the value to reach and the weight of each sample, and the
//! loss that compares programs with these values.

use brood_genome::{BirthKey, Operator, Stream};
use brood_scene::SampleSet;

use super::difficulty::difficulty;
use super::loss::Loss;
use crate::lanes::{BLOCK, LANES, QUARTERS, Quarter};
use crate::rounding::round_to_f32;

/// Error of an invalid target.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum TargetError {
    /// The target has no samples.
    #[error("a target needs at least one sample")]
    Empty,
    /// The number of values or weights differs from the number of samples.
    #[error("the target has {found} {what} for {samples} samples")]
    Length {
        /// `values` or `weights`.
        what: &'static str,
        /// Number given.
        found: usize,
        /// Number of samples, which is required.
        samples: usize,
    },
    /// The reflectance, or its product with the weight, is out of range.
    #[error(
        "the value {value} of sample {sample} must be between 0 and 1e17, and times its weight at most 1e17"
    )]
    Value {
        /// Index of the sample.
        sample: usize,
        /// Value given.
        value: f32,
    },
    /// The weight is out of range.
    #[error("the weight {weight} of sample {sample} must be between 0 and 1e8")]
    Weight {
        /// Index of the sample.
        sample: usize,
        /// Weight given.
        weight: f32,
    },
}

/// Largest reflectance, with or without its weight. Together with the largest weight it keeps the
/// squared errors and their sums within f32, unless a program's output stage enlarges f.
const LARGEST_VALUE: f32 = 1e17;
/// Largest weight.
const LARGEST_WEIGHT: f32 = 1e8;

/// Samples, with the value to reach and the weight of each. They are shuffled once, so that the
/// first samples represent all.
///
/// A selection of the best programs stops evaluating a program as soon as its sum of errors exceeds
/// a bound. That happens sooner if samples with large errors come first; these are much the same
/// for all random programs. [`FitnessTarget::hardest_first`] sorts the samples accordingly, except
/// the first tenth: programs may be ranked by it in advance, so it must represent all samples.
#[derive(Debug)]
pub struct FitnessTarget {
    set: SampleSet,
    loss: Loss,
    /// Values to reach of red, green and blue, then their weights. Each row is filled with 0 beyond
    /// the last sample, up to a whole block: 4 quarters of 64 samples.
    rows: [Vec<Quarter>; 6],
}

impl FitnessTarget {
    /// Creates a target. Reflectances are multiplied by their weight, such as cos_i, before they
    /// are compared; a sample of weight 0 has no effect. `seed` determines the shuffled order.
    ///
    /// # Shapes
    /// `reflectance` and `weight` have a row each for red, green and blue, with one number per
    /// sample of `set`.
    ///
    /// # Domain
    /// Reflectances of 0 to 1e17, weights of 0 to 1e8, their products of 0 to 1e17.
    ///
    /// # Error
    /// Values to reach are computed in f64 and rounded to f32 once.
    ///
    /// # Errors
    /// Returns a [`TargetError`] if there are no samples, a row has another length, or a number is
    /// out of its domain.
    pub fn new(
        set: &SampleSet,
        reflectance: [&[f32]; 3],
        weight: [&[f32]; 3],
        loss: Loss,
        seed: u64,
    ) -> Result<Self, TargetError> {
        let samples = set.len();
        if samples == 0 {
            return Err(TargetError::Empty);
        }
        for (what, rows) in [("values", reflectance), ("weights", weight)] {
            if let Some(row) = rows.iter().find(|row| row.len() != samples) {
                return Err(TargetError::Length { what, found: row.len(), samples });
            }
        }
        check(reflectance, weight)?;
        let order = shuffled(samples, seed);
        let value = |channel: usize, k: usize| {
            let weighted = f64::from(reflectance[channel][k]) * f64::from(weight[channel][k]);
            match loss {
                Loss::Logarithmic => round_to_f32(libm::log2(1.0 + weighted)),
                Loss::Squared => round_to_f32(weighted),
            }
        };
        let rows = std::array::from_fn(|row| match row {
            0..3 => blocks(&order, |k| value(row, k)),
            _ => blocks(&order, |k| weight[row - 3][k]),
        });
        Ok(Self { set: set.select(&order), loss, rows })
    }

    /// Sorts the samples by difficulty, hardest first; those of [`FitnessTarget::fair_blocks`] keep
    /// their place.
    ///
    /// The difficulty of a sample is the sum of its errors by 64 random pilot programs, always the
    /// same. Each error is divided by the program's sum over all samples plus the least such sum of
    /// any pilot program. So all programs count about equally; only those with very small sums
    /// count less, down to half. All this takes about 8 ms for 4096 samples on a Zen 3, once per
    /// target.
    #[must_use]
    pub fn hardest_first(self) -> Self {
        let fair = self.samples().min(self.fair_blocks() * BLOCK);
        let difficulty = difficulty(&self.set, self.values(), self.weights(), self.loss);
        let mut order: Vec<u32> = (0..).take(self.samples()).collect();
        order[fair..].sort_by(|a, b| {
            difficulty[*b as usize].total_cmp(&difficulty[*a as usize]).then(a.cmp(b))
        });
        let rows = std::array::from_fn(|row| {
            let values = self.row(row);
            blocks(&order, |k| values[k])
        });
        Self { set: self.set.select(&order), loss: self.loss, rows }
    }

    /// Returns the samples, in the order of evaluation.
    #[must_use]
    pub fn set(&self) -> &SampleSet {
        &self.set
    }

    /// Returns the number of samples.
    #[must_use]
    pub fn samples(&self) -> usize {
        self.set.len()
    }

    /// Returns the number of blocks of 256 samples; the last may not be full.
    #[must_use]
    pub fn blocks(&self) -> usize {
        self.samples().div_ceil(BLOCK)
    }

    /// Returns the number of blocks at the beginning that are left as shuffled, and so represent
    /// all samples, even after [`FitnessTarget::hardest_first`]: a tenth, at least one.
    #[must_use]
    pub fn fair_blocks(&self) -> usize {
        (self.blocks() / 10).max(1)
    }

    /// Returns the loss.
    #[must_use]
    pub fn loss(&self) -> Loss {
        self.loss
    }

    /// Returns the values to reach of red, green and blue, in the order of [`FitnessTarget::set`]:
    /// log2(1 + f* w) or f* w, depending on the loss, with reflectance f* and weight w.
    #[must_use]
    pub fn values(&self) -> [&[f32]; 3] {
        [0, 1, 2].map(|channel| self.row(channel))
    }

    /// Returns the weights of red, green and blue, in the same order.
    #[must_use]
    pub fn weights(&self) -> [&[f32]; 3] {
        [3, 4, 5].map(|row| self.row(row))
    }

    /// Returns a row without its padding: values to reach are rows 0 to 2, weights rows 3 to 5.
    fn row(&self, row: usize) -> &[f32] {
        &bytemuck::cast_slice(&self.rows[row])[..self.samples()]
    }

    /// Returns the values to reach and the weights of the 64 samples of a quarter; `index` counts
    /// quarters from the first sample.
    #[inline(always)]
    pub(crate) fn quarter(&self, index: usize) -> [&Quarter; 6] {
        let [a, b, c, d, e, f] = &self.rows;
        [&a[index], &b[index], &c[index], &d[index], &e[index], &f[index]]
    }
}

/// Checks that all reflectances, weights and products are in range.
fn check(reflectance: [&[f32]; 3], weight: [&[f32]; 3]) -> Result<(), TargetError> {
    for (values, weights) in reflectance.iter().zip(weight) {
        for (sample, (value, weight)) in values.iter().zip(weights).enumerate() {
            if !(0.0..=LARGEST_WEIGHT).contains(weight) {
                return Err(TargetError::Weight { sample, weight: *weight });
            }
            let weighted = f64::from(*value) * f64::from(*weight);
            let in_range = (0.0..=LARGEST_VALUE).contains(value);
            if !in_range || weighted > f64::from(LARGEST_VALUE) {
                return Err(TargetError::Value { sample, value: *value });
            }
        }
    }
    Ok(())
}

/// Returns the indices of the samples in a random order (Fisher-Yates shuffle).
fn shuffled(samples: usize, seed: u64) -> Vec<u32> {
    let count = u32::try_from(samples).expect("a set has fewer than 2^32 samples");
    let mut order: Vec<u32> = (0..count).collect();
    let mut stream = Stream::new(BirthKey { seed, slot: 0, attempt: 0 }, Operator::Shuffle);
    for last in (1..count).rev() {
        order.swap(last as usize, stream.below(last + 1) as usize);
    }
    order
}

/// Returns the `value` of each index of `order`, padded with zeros to the end of the last block.
fn blocks(order: &[u32], value: impl Fn(usize) -> f32) -> Vec<Quarter> {
    let quarters = order.len().div_ceil(BLOCK) * QUARTERS;
    let mut rows = vec![Quarter([0.0; LANES]); quarters];
    let places: &mut [f32] = bytemuck::cast_slice_mut(&mut rows);
    for (place, index) in places.iter_mut().zip(order) {
        *place = value(*index as usize);
    }
    rows
}
