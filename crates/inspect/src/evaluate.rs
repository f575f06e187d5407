//! Evaluation of one program at pairs of directions.

use brood_brdf::DirectionPair;
use brood_eval::{CanonicalEvaluator, Evaluator};
use brood_program::Program;
use brood_scene::SampleSet;
use glam::DVec2;

/// Returns canonical f at one texture position: all red values in the order of the pairs, then all
/// green, then all blue.
pub fn evaluate(program: &Program, pairs: &[DirectionPair], uv: DVec2) -> Vec<f32> {
    let set = SampleSet::from_pairs(pairs, &vec![uv; pairs.len()]);
    let mut f = Vec::new();
    CanonicalEvaluator::default()
        .eval(&[program], &set, &mut f)
        .expect("the CPU runs every program");
    f
}
