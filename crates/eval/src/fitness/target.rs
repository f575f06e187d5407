//! What programs are compared with: values for each sample, and how they are compared.

use brood_genome::{BirthKey, Operator, Stream};
use brood_scene::SampleSet;

use super::difficulty::difficulty;
use crate::canonical::{BLOCK, LANES, Quarter};

/// How a reflectance and its target are compared.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Loss {
    /// log2(1 + f w) - log2(1 + f* w): ln 2 times the root of its mean square is E_log.
    Logarithmic,
    /// f w - f* w.
    Squared,
}

/// Why something is no target.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum TargetError {
    /// There is nothing to compare.
    #[error("a target needs at least one sample")]
    Empty,
    /// Values or weights are not as many as samples.
    #[error("{found} {what} for {samples} samples")]
    Length {
        /// `values` or `weights`.
        what: &'static str,
        /// How many there are.
        found: usize,
        /// How many there should be.
        samples: usize,
    },
    /// A value that is no reflectance.
    #[error("the value {value} of sample {sample} is not a finite number of 0 to 1e17")]
    Value {
        /// Where it is.
        sample: usize,
        /// What it is.
        value: f32,
    },
    /// A weight that cannot be multiplied by.
    #[error("the weight {weight} of sample {sample} is not a finite number of 0 to 1e8")]
    Weight {
        /// Where it is.
        sample: usize,
        /// What it is.
        weight: f32,
    },
}

/// Beyond these, squares and sums of what programs of the plain output stage make would leave f32.
const LARGEST_VALUE: f32 = 1e17;
const LARGEST_WEIGHT: f32 = 1e8;

/// Samples, the reflectance wanted on each, and weights; shuffled once, so that the first samples are a fair part of all.
///
/// A selection ends the evaluation of a program as soon as its sum passes a bound, and that is the sooner the larger the
/// errors that come first. [`FitnessTarget::hardest_first`] puts them there: which samples random programs miss most is
/// much the same for all of them. The first tenth stays a fair part, by which programs are ranked.
#[derive(Debug)]
pub struct FitnessTarget {
    set: SampleSet,
    loss: Loss,
    /// For red, green and blue in whole blocks: values to reach, then weights; 0 beyond the last sample.
    rows: [Vec<Quarter>; 6],
}

impl FitnessTarget {
    /// A target of reflectances.
    ///
    /// # Shapes
    /// `reflectance` and `weight` for red, green and blue, one number for each sample of `set`. A weight is what the
    /// reflectance counts times, such as cos_i; a sample of weight 0 counts nothing.
    ///
    /// # Domain
    /// Reflectances of 0 to 1e17, weights of 0 to 1e8, their products of 0 to 1e17.
    ///
    /// # Error
    /// Values to reach are computed in f64 and rounded once.
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
                Loss::Logarithmic => nearest(libm::log2(1.0 + weighted)),
                Loss::Squared => nearest(weighted),
            }
        };
        let rows = std::array::from_fn(|row| match row {
            0..3 => blocks(&order, |k| value(row, k)),
            _ => blocks(&order, |k| weight[row - 3][k]),
        });
        Ok(Self { set: set.select(&order), loss, rows })
    }

    /// The same samples in another order: after the [`FitnessTarget::fair_blocks`] those first that a pilot misses most.
    ///
    /// The pilot are 64 random programs, always the same. What one of them misses by is divided by its sum over all
    /// samples plus the least of these sums, so that each has the same say but those that could be selected more.
    /// It takes about 8 ms for 4096 samples on a Zen 3, once for a target: inputs, lowering and evaluation of the pilot.
    #[must_use]
    pub fn hardest_first(self) -> Self {
        let fair = self.samples().min(self.fair_blocks() * BLOCK);
        let difficulty = difficulty(&self);
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

    /// The samples, in the order in which they are evaluated.
    #[must_use]
    pub fn set(&self) -> &SampleSet {
        &self.set
    }

    /// How many there are.
    #[must_use]
    pub fn samples(&self) -> usize {
        self.set.len()
    }

    /// Blocks of 256 samples, the last perhaps not full.
    #[must_use]
    pub fn blocks(&self) -> usize {
        self.samples().div_ceil(BLOCK)
    }

    /// Blocks at the beginning whose samples are a fair part of all, whatever the order of the others: a tenth, at least
    /// one.
    #[must_use]
    pub fn fair_blocks(&self) -> usize {
        (self.blocks() / 10).max(1)
    }

    /// How values are compared.
    #[must_use]
    pub fn loss(&self) -> Loss {
        self.loss
    }

    /// For red, green and blue the values to reach: log2(1 + f* w) or f* w, in the order of [`FitnessTarget::set`].
    #[must_use]
    pub fn values(&self) -> [&[f32]; 3] {
        [0, 1, 2].map(|channel| self.row(channel))
    }

    /// For red, green and blue the weights, in the same order.
    #[must_use]
    pub fn weights(&self) -> [&[f32]; 3] {
        [3, 4, 5].map(|row| self.row(row))
    }

    fn row(&self, row: usize) -> &[f32] {
        &bytemuck::cast_slice(&self.rows[row])[..self.samples()]
    }

    /// Values and weights of one quarter, counted from the first sample.
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

/// The indices in a random order (Fisher and Yates).
fn shuffled(samples: usize, seed: u64) -> Vec<u32> {
    let count = u32::try_from(samples).expect("a set has fewer than 2^32 samples");
    let mut order: Vec<u32> = (0..count).collect();
    let mut stream = Stream::new(BirthKey { seed, slot: 0, attempt: 0 }, Operator::Shuffle);
    for last in (1..count).rev() {
        order.swap(last as usize, stream.below(last + 1) as usize);
    }
    order
}

/// Values in this order, and zeros to the end of the last block.
fn blocks(order: &[u32], value: impl Fn(usize) -> f32) -> Vec<Quarter> {
    let quarters = order.len().div_ceil(BLOCK) * (BLOCK / LANES);
    let mut rows = vec![Quarter([0.0; LANES]); quarters];
    let places: &mut [f32] = bytemuck::cast_slice_mut(&mut rows);
    for (place, index) in places.iter_mut().zip(order) {
        *place = value(*index as usize);
    }
    rows
}

#[expect(clippy::cast_possible_truncation, reason = "rounded to the nearest f32")]
fn nearest(value: f64) -> f32 {
    value as f32
}
