//! Prints nanoseconds per sample of every model relative to a random program, on one thread, and
//! the number of values that differ from the f64 reference: `model_speed [PASSES [MODEL]]`.

use std::hint::black_box;
use std::time::Instant;

use brood_eval::{CanonicalEvaluator, Evaluator, Level, ReferenceEvaluator, model_reflectance};
use brood_genome::{BirthKey, Dialect, Genome, Model, ModelKind, Variation};
use brood_mesh::{BuiltinMesh, Mesh};
use brood_program::Program;
use brood_scene::{SampleSet, Scene};

const PROGRAMS: u32 = 100;

fn main() {
    let passes = std::env::args().nth(1).and_then(|text| text.parse().ok()).unwrap_or(15);
    let only = std::env::args().nth(2).and_then(|text| text.parse().ok());
    let set = SampleSet::render(&Mesh::builtin(BuiltinMesh::Sphere), &Scene::default(), 96, 1);
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build();
    pool.expect("one thread can be started").install(|| report(&set, passes, only));
}

fn report(set: &SampleSet, passes: u32, only: Option<ModelKind>) {
    let random = Variation::random(Dialect::default());
    let programs: Vec<Program> = (0..PROGRAMS)
        .map(|slot| Program::lower(&random.birth(BirthKey { seed: 1, slot, attempt: 0 })))
        .collect();
    let programs: Vec<&Program> = programs.iter().collect();
    let operations: usize = programs.iter().map(|program| program.operations()).sum();
    for level in Level::available() {
        let evaluator = CanonicalEvaluator::with_level(level);
        let of_programs = time(passes, set.len() * programs.len(), || {
            for program in &programs {
                evaluator.eval(&[program], set, &mut Vec::new()).expect("the CPU evaluates");
            }
        });
        println!(
            "{}, {} samples; a random program of {} operations takes {of_programs:.2} ns a sample",
            level.name(),
            set.len(),
            operations / programs.len(),
        );
        println!(
            "model                     ns  times  reference ns  times  f32 unlike reference's"
        );
        for kind in ModelKind::ALL.into_iter().filter(|kind| only.is_none_or(|only| *kind == only))
        {
            let model = Model::new(kind);
            let brdf = model.brdf();
            let program = Genome::of_models(vec![model]).expect("one model is enough");
            let program = Program::lower(&program);
            let mut out = Vec::new();
            let ns = time(passes, set.len(), || {
                evaluator.eval(&[&program], set, &mut out).expect("the CPU evaluates");
                black_box(&out);
            });
            let mut other = Vec::new();
            let reference_ns = time(passes, set.len(), || {
                model_reflectance(&*brdf, set, &mut other);
                black_box(&other);
            });
            ReferenceEvaluator.eval(&[&program], set, &mut other).expect("the CPU evaluates");
            let unlike = out.iter().zip(&other).filter(|(a, b)| a.to_bits() != b.to_bits()).count();
            println!(
                "{:<22} {ns:>6.1} {:>6.2} {reference_ns:>13.1} {:>6.2}  {unlike} of {}",
                kind.name(),
                ns / of_programs,
                reference_ns / of_programs,
                out.len(),
            );
        }
    }
}

/// Returns nanoseconds per sample of the fastest pass.
fn time(passes: u32, samples: usize, mut work: impl FnMut()) -> f64 {
    // Computes everything that is cached at first use.
    work();
    let pass = |_| {
        let started = Instant::now();
        work();
        started.elapsed().as_secs_f64()
    };
    let least = (0..passes).map(pass).fold(f64::INFINITY, f64::min);
    least * 1e9 / samples as f64
}
