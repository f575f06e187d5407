//! Unused inputs: computing only the inputs that programs read, against all inputs of the dialect.

use std::collections::BTreeSet;

use anyhow::Result;
use brood_brdf::{DirectionPair, Input, InputMask};
use brood_genome::{Dialect, InitialValue};
use brood_mesh::{BuiltinMesh, Mesh};
use brood_program::Program;
use brood_scene::{SampleSet, Scene};
use glam::DVec2;

use super::{Saving, Workload};
use crate::measure::programs;
use crate::picture::Mode;

/// Children of a brood, which share a sample set.
const BROOD: usize = 20;

/// Measures unused inputs, for single materials and for broods.
pub fn measure(workload: &Workload) -> Result<Vec<Saving>> {
    let mesh = Mesh::builtin(BuiltinMesh::Sphere);
    let set = Mode::default().set(&mesh, &Scene::default(), workload.size_px);
    let (pairs, uvs): (Vec<DirectionPair>, Vec<DVec2>) =
        (0..set.len()).map(|index| set.pair(index)).unzip();
    let programs = programs(workload.seed, workload.genomes);
    let each: Vec<InputMask> = programs.iter().map(Program::inputs).collect();
    let broods: Vec<InputMask> = each
        .chunks_exact(BROOD.min(each.len()))
        .map(|brood| brood.iter().fold(InputMask::EMPTY, |all, mask| all.union(*mask)))
        .collect();
    let all = dialect_inputs();
    let fill = |input| (input, fill_ms(input, &pairs, &uvs, workload.repeats));
    let of_input: Vec<(Input, f64)> = all.iter().map(fill).collect();
    let ms = |mask: &InputMask| -> f64 {
        of_input.iter().filter(|(input, _)| mask.contains(*input)).map(|(_, ms)| ms).sum()
    };
    let saving = |name: &str, masks: &[InputMask]| Saving {
        name: name.to_owned(),
        counted: "inputs, of all sets",
        without: (all.len() * masks.len()) as u64,
        with: masks.iter().map(|mask| mask.len() as u64).sum(),
        timed: "computing the inputs, mean of the sets",
        without_ms: ms(&all),
        with_ms: masks.iter().map(ms).sum::<f64>() / masks.len() as f64,
        percent_same: 100.0,
    };
    Ok(vec![
        saving("unused inputs, one material", &each),
        saving("unused inputs, a brood of 20", &broods),
    ])
}

/// Inputs that the registers of the default dialect start with.
fn dialect_inputs() -> InputMask {
    let dialect = Dialect::default();
    let places = (0..dialect.registers).flat_map(|r| (0..4).map(move |c| (r, c)));
    let inputs =
        places.filter_map(|(register, component)| match dialect.initial(register, component) {
            InitialValue::Input(input) => Some(input),
            InitialValue::Zero | InitialValue::One => None,
        });
    inputs.collect::<BTreeSet<Input>>().into_iter().collect()
}

/// Fastest time to compute an input, each time on a new set because a set caches its inputs.
fn fill_ms(input: Input, pairs: &[DirectionPair], uvs: &[DVec2], repeats: u32) -> f64 {
    let one = |_| {
        let set = SampleSet::from_pairs(pairs, uvs);
        let start = std::time::Instant::now();
        std::hint::black_box(set.input(input));
        start.elapsed().as_secs_f64() * 1e3
    };
    (0..repeats.max(2)).map(one).fold(f64::INFINITY, f64::min)
}
