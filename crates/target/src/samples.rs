//! Samples of a material: pairs of directions with a reflectance each.

use brood_brdf::{Brdf, DirectionPair};
use brood_eval::{CanonicalEvaluator, EvalError, Evaluator};
use brood_program::Program;
use brood_scene::SampleSet;

/// f of red, green and blue for pairs of directions above the surface.
#[derive(Debug, Clone)]
pub struct Samples {
    pairs: Vec<DirectionPair>,
    values: Vec<[f64; 3]>,
    lower_bounds: Vec<LowerBound>,
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
        Self { pairs, values, lower_bounds: Vec::new() }
    }

    /// Samples a program at these pairs.
    ///
    /// # Errors
    /// Returns [`EvalError`] if the program cannot be evaluated.
    pub fn of_program(program: &Program, pairs: Vec<DirectionPair>) -> Result<Self, EvalError> {
        let (set, mut out) = (SampleSet::from_pairs(&pairs, &[]), Vec::new());
        CanonicalEvaluator::default().eval(&[program], &set, &mut out)?;
        let count = pairs.len();
        let value = |k: usize| [0, 1, 2].map(|channel| f64::from(out[channel * count + k]));
        let values = (0..count).map(value).collect();
        Ok(Self { pairs, values, lower_bounds: Vec::new() })
    }

    /// Samples of these pairs and values.
    ///
    /// # Panics
    /// If there are not as many values as pairs.
    #[must_use]
    pub fn new(pairs: Vec<DirectionPair>, values: Vec<[f64; 3]>) -> Self {
        assert_eq!(pairs.len(), values.len(), "every pair has a value");
        Self { pairs, values, lower_bounds: Vec::new() }
    }

    /// Adds pairs for which only a lower bound of f is known. They are not samples and do not count
    /// in errors.
    #[must_use]
    pub fn with_lower_bounds(self, lower_bounds: Vec<LowerBound>) -> Self {
        Self { lower_bounds, ..self }
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

    /// Number of samples.
    #[must_use]
    pub fn len(&self) -> usize {
        self.pairs.len()
    }

    /// True if there are no samples.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.pairs.is_empty()
    }

    /// Largest f of any channel; 0 if there are no samples.
    #[must_use]
    pub fn largest(&self) -> f64 {
        self.values.as_flattened().iter().fold(0.0, |most, f| most.max(*f))
    }
}
