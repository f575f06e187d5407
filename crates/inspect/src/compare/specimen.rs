//! Material of a comparison, independent of its origin.

use brood_brdf::{Brdf, DirectionPair};
use brood_eval::{CanonicalEvaluator, Evaluator, model_reflectance};
use brood_genome::Genome;
use brood_program::Program;
use brood_scene::SampleSet;

/// Bred or measured material.
#[derive(Clone, Copy)]
pub enum Specimen<'a> {
    /// Genome with its expressed program.
    Bred(&'a Genome, &'a Program),
    /// Measured material.
    Measured(&'a dyn Brdf),
}

impl Specimen<'_> {
    /// Evaluates f for the samples of `set`.
    ///
    /// # Shapes
    /// `out` is resized to `3 * set.len()`: all red values in the order of the samples, then all
    /// green, then all blue.
    pub fn shade(&self, set: &SampleSet, out: &mut Vec<f32>) {
        match self {
            Self::Measured(brdf) => model_reflectance(*brdf, set, out),
            Self::Bred(_, program) => CanonicalEvaluator::default()
                .eval(&[*program], set, out)
                .expect("the CPU runs every program"),
        }
    }

    /// Returns f of direction pairs at texture position 0.
    pub(super) fn f(&self, pairs: &[DirectionPair]) -> Vec<[f64; 3]> {
        let mut out = Vec::new();
        self.shade(&SampleSet::from_pairs(pairs, &[]), &mut out);
        let channel = |channel: usize, index: usize| f64::from(out[channel * pairs.len() + index]);
        (0..pairs.len()).map(|index| [0, 1, 2].map(|c| channel(c, index))).collect()
    }
}
