//! Samples of a material: pairs of directions with a reflectance each, and means over several
//! pairs.

use brood_brdf::{Brdf, DirectionPair};
use brood_eval::{CanonicalEvaluator, EvalError, Evaluator};
use brood_program::Program;
use brood_scene::SampleSet;

use crate::LightMeans;

/// f of red, green and blue for pairs of directions above the surface, and means of f cos_i over
/// several pairs.
#[derive(Debug, Clone, Default)]
pub struct Samples {
    pairs: Vec<DirectionPair>,
    values: Vec<[f64; 3]>,
    lower_bounds: Vec<LowerBound>,
    means: LightMeans,
    is_of_pictures: bool,
    expected: Vec<(DirectionPair, [f64; 3])>,
}

/// A pair for which only a lower bound of f is known, in some channels.
#[derive(Debug, Clone, Copy)]
pub struct LowerBound {
    /// Pair of directions.
    pub pair: DirectionPair,
    /// Bound, or f, of red, green and blue.
    pub f: [f64; 3],
    /// True for channels whose f is known.
    pub is_known: [bool; 3],
}

impl Samples {
    /// Samples a material at these pairs. The value is the mean of f and of f with light and eye
    /// exchanged, the best that a reciprocal material can match; negative values become 0.
    ///
    /// # Domain
    /// Pairs above the surface.
    #[must_use]
    pub fn of(brdf: &dyn Brdf, pairs: Vec<DirectionPair>) -> Self {
        let value = |pair: &DirectionPair| {
            (0.5 * (brdf.f(pair) + brdf.f(&pair.swapped()))).to_array().map(|f| f.max(0.0))
        };
        let values = pairs.iter().map(value).collect();
        Self::new(pairs, values)
    }

    /// Samples a program at these pairs.
    ///
    /// # Errors
    /// Returns [`EvalError`] if the program cannot be evaluated.
    pub fn of_program(program: &Program, pairs: Vec<DirectionPair>) -> Result<Self, EvalError> {
        let values = f_of_program(program, &pairs)?;
        Ok(Self::new(pairs, values))
    }

    /// Samples of these pairs and values.
    ///
    /// # Panics
    /// If there are not as many values as pairs.
    #[must_use]
    pub fn new(pairs: Vec<DirectionPair>, values: Vec<[f64; 3]>) -> Self {
        assert_eq!(pairs.len(), values.len(), "every pair has a value");
        Self { pairs, values, ..Self::default() }
    }

    /// Adds pairs for which only a lower bound of f is known. They are not samples and do not count
    /// in errors.
    #[must_use]
    pub fn with_lower_bounds(self, lower_bounds: Vec<LowerBound>) -> Self {
        Self { lower_bounds, ..self }
    }

    /// Adds means over several pairs. They count in errors, but are not among the pairs.
    #[must_use]
    pub fn with_means(self, means: LightMeans) -> Self {
        Self { means, ..self }
    }

    /// Marks the samples as pixels of pictures, which show f for a part of all pairs.
    #[must_use]
    pub fn of_pictures(self) -> Self {
        Self { is_of_pictures: true, ..self }
    }

    /// True if the samples are pixels of pictures.
    #[must_use]
    pub fn are_of_pictures(&self) -> bool {
        self.is_of_pictures
    }

    /// Adds f as it is expected at pairs that were not measured. They are not samples and do not
    /// count in errors.
    #[must_use]
    pub fn with_expected(self, expected: Vec<(DirectionPair, [f64; 3])>) -> Self {
        Self { expected, ..self }
    }

    /// f as it is expected at pairs that were not measured.
    #[must_use]
    pub fn expected(&self) -> &[(DirectionPair, [f64; 3])] {
        &self.expected
    }

    /// Means of f cos_i over several pairs.
    #[must_use]
    pub fn means(&self) -> &LightMeans {
        &self.means
    }

    /// Samples of the same pixels with means only where light reaches the centre of a pixel from
    /// several directions. The other means become pairs with the f that they would have if it was
    /// the same within the pixel.
    #[must_use]
    pub fn at_centres(&self) -> Self {
        let (mut own, means) = (self.clone(), self.means());
        let centres = means.values().iter().filter_map(|value| Some((value.centre?, value)));
        for ((pair, f), value) in centres {
            if value.is_sample() {
                own.pairs.push(pair);
                own.values.push(f);
            } else {
                own.lower_bounds.push(LowerBound { pair, f, is_known: value.is_known });
            }
        }
        let has_several = |at: &usize| means.values()[*at].centre.is_none();
        own.means = means.select((0..means.len()).filter(has_several));
        own
    }

    /// Observations: f cos_i of each pair, then the means of which all channels are known, as
    /// compared by the metrics.
    #[must_use]
    pub fn observed(&self) -> Vec<[f64; 3]> {
        let mut all = self.weighted();
        let known = self.means.values().iter().filter(|value| value.is_sample());
        all.extend(known.map(|value| value.mean));
        all
    }

    /// Observations as they would be of a program, in the order of [`Samples::observed`].
    ///
    /// # Errors
    /// Returns [`EvalError`] if the program cannot be evaluated.
    pub fn observed_of(&self, program: &Program) -> Result<Vec<[f64; 3]>, EvalError> {
        let mut all = Self::of_program(program, self.pairs.clone())?.weighted();
        if !self.means.is_empty() {
            let means = self.means.of(&f_of_program(program, self.means.pairs())?);
            let known = means.into_iter().zip(self.means.values());
            all.extend(known.filter(|(_, value)| value.is_sample()).map(|(mean, _)| mean));
        }
        Ok(all)
    }

    /// Number of observations: pairs, and means of which all channels are known.
    #[must_use]
    pub fn observations(&self) -> usize {
        self.pairs.len() + self.means.samples()
    }

    /// Pairs for which only a lower bound of f is known.
    #[must_use]
    pub fn lower_bounds(&self) -> &[LowerBound] {
        &self.lower_bounds
    }

    /// Pairs of directions.
    #[must_use]
    pub fn pairs(&self) -> &[DirectionPair] {
        &self.pairs
    }

    /// f of each pair.
    #[must_use]
    pub fn values(&self) -> &[[f64; 3]] {
        &self.values
    }

    /// f cos_i of each pair, as compared by the metrics.
    #[must_use]
    pub fn weighted(&self) -> Vec<[f64; 3]> {
        let both = self.pairs.iter().zip(&self.values);
        both.map(|(pair, value)| value.map(|f| f * pair.cos_i())).collect()
    }

    /// Number of pairs.
    #[must_use]
    pub fn len(&self) -> usize {
        self.pairs.len()
    }

    /// True if there are no pairs.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.pairs.is_empty()
    }

    /// Largest f and mean of any channel, without expected ones; 0 if there are neither.
    #[must_use]
    pub fn largest(&self) -> f64 {
        let means = self.means.values().iter().flat_map(|value| value.mean);
        self.values.as_flattened().iter().copied().chain(means).fold(0.0, f64::max)
    }
}

/// f of a program at pairs of directions.
fn f_of_program(program: &Program, pairs: &[DirectionPair]) -> Result<Vec<[f64; 3]>, EvalError> {
    let (set, mut out) = (SampleSet::from_pairs(pairs, &[]), Vec::new());
    CanonicalEvaluator::default().eval(&[program], &set, &mut out)?;
    let count = pairs.len();
    let value = |k: usize| [0, 1, 2].map(|channel| f64::from(out[channel * count + k]));
    Ok((0..count).map(value).collect())
}
