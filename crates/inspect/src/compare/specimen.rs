//! A material that is compared: where it is from does not matter any more.

use brood_brdf::{Brdf, DirectionPair};
use brood_eval::{CanonicalEvaluator, Evaluator, model_reflectance};
use brood_genome::Genome;
use brood_program::Program;
use brood_scene::SampleSet;

/// A material: bred, or measured.
#[derive(Clone, Copy)]
pub enum Specimen<'a> {
    /// A genome, and the program that it is seen as.
    Bred(&'a Genome, &'a Program),
    /// What was measured of a surface.
    Measured(&'a dyn Brdf),
}

impl Specimen<'_> {
    /// The reflectance of samples. `out` is made `3 * set.len()` long: red, green, blue, in each the samples in order.
    pub fn shade(&self, set: &SampleSet, out: &mut Vec<f32>) {
        match self {
            Self::Measured(brdf) => model_reflectance(*brdf, set, out),
            Self::Bred(_, program) => CanonicalEvaluator::default()
                .eval(&[*program], set, out)
                .expect("the CPU runs every program"),
        }
    }

    /// f of some pairs, at texture position 0.
    pub(super) fn f(&self, pairs: &[DirectionPair]) -> Vec<[f64; 3]> {
        let mut out = Vec::new();
        self.shade(&SampleSet::from_pairs(pairs, &[]), &mut out);
        let channel = |channel: usize, index: usize| f64::from(out[channel * pairs.len() + index]);
        (0..pairs.len()).map(|index| [0, 1, 2].map(|c| channel(c, index))).collect()
    }
}
