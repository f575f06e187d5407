//! Target of a fit: values and weights of each sample, and the loss that compares them.

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
    /// The number of values or weights is not that of samples.
    #[error("the target has {found} {what} for {samples} samples")]
    Length {
        /// `values` or `weights`.
        what: &'static str,
        /// Number given.
        found: usize,
        /// Number of samples, which is required.
        samples: usize,
    },
    /// The value is not a valid reflectance.
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

/// Largest value and weight: beyond them squares and sums of programs with a plain output stage
/// exceed f32.
const LARGEST_VALUE: f32 = 1e17;
const LARGEST_WEIGHT: f32 = 1e8;

/// Samples, the target reflectance of each, and weights; shuffled once, so that the first samples
/// represent all.
///
/// A selection ends the evaluation of a program as soon as its sum exceeds a bound, which happens
/// sooner if large errors come first. [`FitnessTarget::hardest_first`] sorts the samples for that:
/// the samples with large errors are much the same for all random programs. The first tenth stays
/// representative, because programs are ranked by it.
#[derive(Debug)]
pub struct FitnessTarget {
    set: SampleSet,
    loss: Loss,
    /// Values to reach, then weights, each for red, green and blue in whole blocks; 0 beyond the
    /// last sample.
    rows: [Vec<Quarter>; 6],
}

impl FitnessTarget {
    /// Creates a target.
    ///
    /// # Shapes
    /// `reflectance` and `weight` for red, green and blue, one number per sample of `set`.
    /// Reflectances are multiplied by their weight, such as cos_i, before the comparison; a sample
    /// of weight 0 has no effect.
    ///
    /// # Domain
    /// Reflectances of 0 to 1e17, weights of 0 to 1e8, their products of 0 to 1e17.
    ///
    /// # Error
    /// Values to reach are computed in f64 and rounded once.
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

    /// Sorts the samples after the [`FitnessTarget::fair_blocks`] by difficulty, hardest first.
    ///
    /// The difficulty is measured with a pilot of 64 random programs, always the same. The error of
    /// a pilot program on a sample is divided by the sum over all samples plus the least of these
    /// sums, so that programs count equally, except that those with the smallest errors count less.
    /// This takes about 8 ms for 4096 samples on a Zen 3, once per target: inputs, lowering and
    /// evaluation of the pilot.
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

    /// Returns the number of blocks at the beginning whose samples represent all, in any order of
    /// the others: a tenth, at least one.
    #[must_use]
    pub fn fair_blocks(&self) -> usize {
        (self.blocks() / 10).max(1)
    }

    /// Returns the loss.
    #[must_use]
    pub fn loss(&self) -> Loss {
        self.loss
    }

    /// Returns the values to reach of red, green and blue: log2(1 + f* w) or f* w, in the order of
    /// [`FitnessTarget::set`].
    #[must_use]
    pub fn values(&self) -> [&[f32]; 3] {
        [0, 1, 2].map(|channel| self.row(channel))
    }

    /// Returns the weights of red, green and blue, in the same order.
    #[must_use]
    pub fn weights(&self) -> [&[f32]; 3] {
        [3, 4, 5].map(|row| self.row(row))
    }

    fn row(&self, row: usize) -> &[f32] {
        &bytemuck::cast_slice(&self.rows[row])[..self.samples()]
    }

    /// Returns values and weights of one quarter, counted from the first sample.
    #[inline(always)]
    pub(crate) fn quarter(&self, index: usize) -> [&Quarter; 6] {
        let [a, b, c, d, e, f] = &self.rows;
        [&a[index], &b[index], &c[index], &d[index], &e[index], &f[index]]
    }
}

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

/// Returns the indices in a random order (Fisher and Yates).
fn shuffled(samples: usize, seed: u64) -> Vec<u32> {
    let count = u32::try_from(samples).expect("a set has fewer than 2^32 samples");
    let mut order: Vec<u32> = (0..count).collect();
    let mut stream = Stream::new(BirthKey { seed, slot: 0, attempt: 0 }, Operator::Shuffle);
    for last in (1..count).rev() {
        order.swap(last as usize, stream.below(last + 1) as usize);
    }
    order
}

/// Returns the values in this order, padded with zeros to the end of the last block.
fn blocks(order: &[u32], value: impl Fn(usize) -> f32) -> Vec<Quarter> {
    let quarters = order.len().div_ceil(BLOCK) * QUARTERS;
    let mut rows = vec![Quarter([0.0; LANES]); quarters];
    let places: &mut [f32] = bytemuck::cast_slice_mut(&mut rows);
    for (place, index) in places.iter_mut().zip(order) {
        *place = value(*index as usize);
    }
    rows
}
