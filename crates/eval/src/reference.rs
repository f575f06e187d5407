//! The reference evaluator: the same operations and clamps in f64. It serves only to measure error.

use brood_program::{Meaning, Program, execute_layered};
use brood_scene::SampleSet;
use glam::DVec3;
use rayon::prelude::*;

use crate::evaluator::{EvalResult, Evaluator, Lowered};
use crate::layer::Layers;
use crate::rounding::round_to_f32;

/// Evaluates in f64 on the CPU, sample by sample.
#[derive(Debug, Clone, Copy, Default)]
pub struct ReferenceEvaluator;

impl ReferenceEvaluator {
    /// Returns the reflectance of one program on each sample, in full precision.
    ///
    /// # Shapes
    /// One (red, green, blue) per sample.
    #[must_use]
    pub fn reflectance(program: &Program, set: &SampleSet) -> Vec<[f64; 3]> {
        debug_assert!(!matches!(program.meaning(), Meaning::Style(_)), "styles are lowered first");
        let mask = program.inputs();
        let inputs: Vec<(usize, &[f32])> =
            mask.iter().map(|input| (input.index(), set.input(input))).collect();
        let layers = Layers::of(program);
        let sample = |index: usize| {
            let value = |input: brood_brdf::Input| {
                let column = inputs.iter().find(|(other, _)| *other == input.index());
                f64::from(column.expect("the mask names every input read").1[index])
            };
            let add = |squares: [f64; 3]| match &layers {
                Some(layers) => (DVec3::from(squares) + layers.f(&set.pair(index).0)).to_array(),
                None => squares,
            };
            execute_layered(program, value, |constant| constant.reference, add)
        };
        (0..set.len()).into_par_iter().map(sample).collect()
    }
}

impl Evaluator for ReferenceEvaluator {
    fn name(&self) -> &str {
        "reference"
    }

    fn is_exact(&self) -> bool {
        false
    }

    fn eval(&self, programs: &[&Program], set: &SampleSet, out: &mut Vec<f32>) -> EvalResult {
        out.clear();
        let lowered = Lowered::of(programs, set)?;
        for program in &*lowered.programs() {
            let f = Self::reflectance(program, set);
            for channel in 0..3 {
                out.extend(f.iter().map(|rgb| round_to_f32(rgb[channel])));
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reference_evaluator_is_within_the_tolerance_table() {
        crate::conformance::check(&ReferenceEvaluator);
    }
}
