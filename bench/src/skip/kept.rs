//! Caches between pictures: sample sets with their inputs, and translated programs.

use anyhow::Result;
use brood_eval::{CanonicalEvaluator, Evaluator, shade};
use brood_mesh::{BuiltinMesh, Mesh};
use brood_program::Program;
use brood_protocol::Backend;
use brood_scene::Scene;
use brood_worker::Renderer;

use super::{Saving, Workload};
use crate::measure::{fastest_ms, fastest_of_each_ms, genomes, programs};
use crate::picture::{self, Mode};

/// Children of a brood, which share a sample set.
const BROOD: u32 = 20;

/// Measures the cache of sample sets and that of programs.
pub fn measure(workload: &Workload) -> Result<Vec<Saving>> {
    let mut savings = sample_sets(workload)?;
    savings.extend(translations(workload)?);
    Ok(savings)
}

/// Times a brood with a new sample set and with a cached one.
fn sample_sets(workload: &Workload) -> Result<Vec<Saving>> {
    let mesh = Mesh::builtin(BuiltinMesh::Sphere);
    let scene = Scene::default();
    let brood = programs(workload.seed, BROOD);
    let mode = Mode::default();
    let kept = mode.set(&mesh, &scene, workload.size_px);
    let pictures = |set: &_, programs: &[Program]| {
        let mut f = Vec::new();
        for program in programs {
            picture::canonical(set, program, &mut f)?;
        }
        anyhow::Ok(())
    };
    pictures(&kept, &brood)?;
    let saving = |name: &str, programs: &[Program]| {
        let [with_ms, without_ms] = fastest_of_each_ms(
            workload.repeats.min(5),
            [&mut || pictures(&kept, programs), &mut || {
                pictures(&mode.set(&mesh, &scene, workload.size_px), programs)
            }],
        )?;
        anyhow::Ok(Saving {
            name: name.to_owned(),
            counted: "rays for the next picture",
            without: kept.counts().rays,
            with: 0,
            timed: "evaluation and shading, rays and inputs if they are not kept",
            without_ms,
            with_ms,
            percent_same: 100.0,
        })
    };
    Ok(vec![
        saving("sample sets kept, one material", &brood[..1])?,
        saving("sample sets kept, a brood of 20", &brood)?,
    ])
}

/// Times evaluation on 4096 samples with the program from the cache, with the words parsed, and
/// with the genome lowered.
fn translations(workload: &Workload) -> Result<Vec<Saving>> {
    let set = brood_eval::conformance::hard_samples(workload.seed, 4096);
    let genomes = genomes(workload.seed, workload.genomes);
    let words: Vec<Vec<u32>> = genomes.iter().map(|g| Program::lower(g).to_words()).collect();
    let renderer = Renderer::new(Backend::Cpu);
    let evaluator = CanonicalEvaluator::default();
    let evaluate = |program: &Program, f: &mut Vec<f32>| evaluator.eval(&[program], &set, f);
    let kept = |f: &mut Vec<f32>| -> Result<()> {
        words.iter().try_for_each(|words| Ok(evaluate(&*renderer.program(words)?, f)?))
    };
    let (mut a, mut b, mut c) = (Vec::new(), Vec::new(), Vec::new());
    // Fills the inputs and the renderer's cache.
    kept(&mut a)?;
    let [kept_ms, read_ms, lowered_ms] = fastest_of_each_ms(
        workload.repeats,
        [
            &mut || kept(&mut a),
            &mut || words.iter().try_for_each(|w| Ok(evaluate(&Program::from_words(w)?, &mut b)?)),
            &mut || genomes.iter().try_for_each(|g| Ok(evaluate(&Program::lower(g), &mut c)?)),
        ],
    )?;
    let saving = |name: &str, without_ms| Saving {
        name: name.to_owned(),
        counted: "translations",
        without: genomes.len() as u64,
        with: 0,
        timed: "evaluation of all genomes on 4096 samples, translation included",
        without_ms,
        with_ms: kept_ms,
        percent_same: 100.0,
    };
    Ok(vec![
        saving("programs kept, words read again", read_ms),
        saving("programs kept, genomes lowered again", lowered_ms),
    ])
}

/// Time of evaluation, shading and PNG of one picture in milliseconds; also used by the twins.
pub fn picture_ms(workload: &Workload, programs: &[Program]) -> Result<f64> {
    let mesh = Mesh::builtin(BuiltinMesh::Sphere);
    let set = Mode::default().set(&mesh, &Scene::default(), workload.size_px);
    let evaluator = CanonicalEvaluator::default();
    let mut f = Vec::new();
    let mut run = || {
        for program in programs {
            evaluator.eval(&[program], &set, &mut f)?;
            let image = shade(&set, &f);
            let developed = brood_eval::develop(&image, brood_scene::Exposure::Auto);
            let (width, height) = (developed.width, developed.height);
            std::hint::black_box(brood_eval::encode_png(width, height, &developed.rgba));
        }
        Ok(())
    };
    run()?;
    Ok(fastest_ms(workload.repeats.min(3), run)?.0 / programs.len() as f64)
}
