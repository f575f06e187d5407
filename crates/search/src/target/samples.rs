//! Pairs of directions with a reflectance each.

use brood_brdf::{Brdf, DirectionPair};
use brood_eval::{CanonicalEvaluator, EvalError, Evaluator};
use brood_program::Program;
use brood_scene::SampleSet;

/// f of red, green and blue for pairs of directions above the surface.
#[derive(Debug, Clone)]
pub struct Samples {
    pairs: Vec<DirectionPair>,
    values: Vec<[f64; 3]>,
    /// Where nothing is known but that f is not below a value.
    least: Vec<(DirectionPair, [f64; 3])>,
}

impl Samples {
    /// Of a material at these pairs, averaged over the exchange of light and eye, which is what a reciprocal material can
    /// be of one that is not; what is below 0 is 0.
    ///
    /// # Domain
    /// Pairs above the surface.
    #[must_use]
    pub fn of(brdf: &dyn Brdf, pairs: Vec<DirectionPair>) -> Self {
        let value = |pair: &DirectionPair| {
            (0.5 * (brdf.f(pair) + brdf.f(&pair.swapped()))).to_array().map(|f| f.max(0.0))
        };
        let values = pairs.iter().map(value).collect();
        Self { pairs, values, least: Vec::new() }
    }

    /// What a program makes of these pairs.
    pub fn of_program(program: &Program, pairs: Vec<DirectionPair>) -> Result<Self, EvalError> {
        let (set, mut out) = (SampleSet::from_pairs(&pairs, &[]), Vec::new());
        CanonicalEvaluator::default().eval(&[program], &set, &mut out)?;
        let count = pairs.len();
        let value = |k: usize| [0, 1, 2].map(|channel| f64::from(out[channel * count + k]));
        let values = (0..count).map(value).collect();
        Ok(Self { pairs, values, least: Vec::new() })
    }

    /// Takes pairs and values as they are.
    ///
    /// # Panics
    /// Where there are not as many values as pairs.
    #[must_use]
    pub fn new(pairs: Vec<DirectionPair>, values: Vec<[f64; 3]>) -> Self {
        assert_eq!(pairs.len(), values.len(), "every pair has a value");
        Self { pairs, values, least: Vec::new() }
    }

    /// The same, with pairs of which nothing is known but that f is not below a value: they are no samples, and no error is told of
    /// them.
    #[must_use]
    pub fn with_least(self, least: Vec<(DirectionPair, [f64; 3])>) -> Self {
        Self { least, ..self }
    }

    /// The pairs of which nothing is known but that f is not below a value.
    #[must_use]
    pub fn least(&self) -> &[(DirectionPair, [f64; 3])] {
        &self.least
    }

    /// The pairs.
    #[must_use]
    pub fn pairs(&self) -> &[DirectionPair] {
        &self.pairs
    }

    /// f of each pair.
    #[must_use]
    pub fn values(&self) -> &[[f64; 3]] {
        &self.values
    }

    /// f cos_i of each pair, which metrics compare.
    #[must_use]
    pub fn weighted(&self) -> Vec<[f64; 3]> {
        let both = self.pairs.iter().zip(&self.values);
        both.map(|(pair, value)| value.map(|f| f * pair.cos_i())).collect()
    }

    /// How many there are.
    #[must_use]
    pub fn len(&self) -> usize {
        self.pairs.len()
    }

    /// Whether there is none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.pairs.is_empty()
    }

    /// The largest f of any channel; 0 where there is none.
    #[must_use]
    pub fn largest(&self) -> f64 {
        self.values.as_flattened().iter().fold(0.0, |most, f| most.max(*f))
    }
}
