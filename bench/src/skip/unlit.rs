//! Unlit and uncovered samples: evaluating only lit and visible samples, against one sample per
//! pixel.

use anyhow::Result;
use brood_brdf::DirectionPair;
use brood_eval::{CanonicalEvaluator, Evaluator};
use brood_mesh::{BuiltinMesh, Mesh};
use brood_program::Program;
use brood_scene::{SampleSet, Sampling, Scene};
use glam::DVec2;

use super::{Saving, Workload};
use crate::measure::{fastest_ms, programs};

/// Number of positions on the light orbit.
const ANGLES: u32 = 12;
/// Number of evaluated materials.
const MATERIALS: u32 = 10;

/// Measures the samples that are not evaluated, over the light orbit.
pub fn measure(workload: &Workload) -> Result<Vec<Saving>> {
    let mesh = Mesh::builtin(BuiltinMesh::Sphere);
    let programs = programs(workload.seed, MATERIALS);
    let pixels = workload.size_px as usize * workload.size_px as usize;
    let (mut lit, mut lit_ms) = (0, 0.0);
    let mut full: Option<SampleSet> = None;
    for step in 0..ANGLES {
        let degrees = 360.0 * f64::from(step) / f64::from(ANGLES);
        let scene = Scene::default().with_light_deg(degrees);
        let set = SampleSet::render(&mesh, &scene, workload.size_px, Sampling::Fixed(1));
        lit += set.len() as u64;
        lit_ms += time(&set, &programs, workload.repeats)?;
        if full.as_ref().is_none_or(|kept| kept.len() < set.len()) {
            full = Some(set);
        }
    }
    // Lit samples are repeated up to one per pixel; the time depends only on their number.
    let fullest = full.expect("there is at least one angle");
    let (pairs, uvs): (Vec<DirectionPair>, Vec<DVec2>) =
        (0..fullest.len()).map(|index| fullest.pair(index)).cycle().take(pixels).unzip();
    let all = SampleSet::from_pairs(&pairs, &uvs);
    let all_ms = time(&all, &programs, workload.repeats)?;
    Ok(vec![Saving {
        name: "unlit, uncovered samples".to_owned(),
        counted: "samples over 12 positions of the light",
        without: u64::from(ANGLES) * pixels as u64,
        with: lit,
        timed: "evaluation of a material over 12 positions of the light",
        without_ms: f64::from(ANGLES) * all_ms / f64::from(MATERIALS),
        with_ms: lit_ms / f64::from(MATERIALS),
        percent_same: 100.0,
    }])
}

/// Milliseconds of the fastest evaluation of all programs.
fn time(set: &SampleSet, programs: &[Program], repeats: u32) -> Result<f64> {
    let evaluator = CanonicalEvaluator::default();
    let mut f = Vec::new();
    let mut run = || {
        for program in programs {
            evaluator.eval(&[program], set, &mut f)?;
        }
        Ok(())
    };
    run()?;
    Ok(fastest_ms(repeats, run)?.0)
}
