//! Comparison with the canonical values, bit by bit. The expected values are computed sample by
//! sample with [`execute_layered`], which defines them.

use brood_program::{Program, execute_layered};
use brood_scene::SampleSet;

use super::cases::sample_sets;
use crate::evaluator::Evaluator;
use crate::layer::Layers;

/// Checks every bit over programs of all dialects and every sample set.
pub(super) fn check_bits(evaluator: &dyn Evaluator, programs: &[Program]) {
    let batch: Vec<&Program> = programs.iter().collect();
    for set in sample_sets() {
        let mut out = Vec::new();
        evaluator.eval(&batch, &set, &mut out).expect("the batch is evaluated");
        for (index, program) in programs.iter().enumerate() {
            let of_program = &out[index * 3 * set.len()..(index + 1) * 3 * set.len()];
            if let Some((sample, got, expected)) = first_difference(program, &set, of_program) {
                panic!(
                    "{}: program {index} of {} operations, sample {sample} of {}: \
                     {got:?}, expected {expected:?}\n{program:#?}",
                    evaluator.name(),
                    program.operations(),
                    set.len(),
                );
            }
        }
    }
}

/// Returns the first sample on which the output of an evaluator for one program differs in any bit
/// from the canonical value, with both values.
#[must_use]
pub fn first_difference(
    program: &Program,
    set: &SampleSet,
    f: &[f32],
) -> Option<(usize, [f32; 3], [f32; 3])> {
    let layers = Layers::of(program);
    (0..set.len()).find_map(|sample| {
        let expected = canonical(program, layers.as_ref(), set, sample);
        let got = [0, 1, 2].map(|channel| f[channel * set.len() + sample]);
        (got.map(f32::to_bits) != expected.map(f32::to_bits)).then_some((sample, got, expected))
    })
}

/// Returns the canonical f of one sample.
pub(super) fn canonical(
    program: &Program,
    layers: Option<&Layers>,
    set: &SampleSet,
    sample: usize,
) -> [f32; 3] {
    let add = |squares: [f32; 3]| match layers {
        Some(layers) => {
            let added = layers.rounded(&set.pair(sample).0);
            [0, 1, 2].map(|channel| squares[channel] + added[channel])
        }
        None => squares,
    };
    let inputs = |input| set.input(input)[sample];
    execute_layered(program, inputs, |constant| constant.canonical, add)
}
