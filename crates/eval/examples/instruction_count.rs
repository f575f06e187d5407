//! Fixed workloads for an instruction counter: `instruction_count evaluate|lower|picture|breed`.
//!
//! The workload runs inside [`measured`] and nothing else does, so a counter that is switched on
//! and off by that function does not count the preparation. One thread, one instruction set (AVX2,
//! which counters that emulate the processor support), fixed seeds: the same build gives nearly the
//! same count on every machine.

use std::hint::black_box;
use std::process::ExitCode;

use brood_eval::{CanonicalEvaluator, Evaluator, Level, develop, encode_png, shade};
use brood_genome::{BirthKey, Dialect, Genome, Variation};
use brood_mesh::{BuiltinMesh, Mesh};
use brood_program::{BroodRequest, Program, make_brood};
use brood_scene::{Exposure, SampleSet, Scene};

const SEED: u64 = 3;
/// Exit code if this machine does not have the instruction set.
const NO_LEVEL: u8 = 77;

fn main() -> ExitCode {
    let work = std::env::args().nth(1).unwrap_or_default();
    let Some(level) = Level::available().into_iter().find(|level| level.name() == "avx2") else {
        eprintln!("instruction_count: this machine has no AVX2");
        return ExitCode::from(NO_LEVEL);
    };
    let evaluator = CanonicalEvaluator::with_level(level);
    let prepared: Box<dyn FnMut() + Send> = match work.as_str() {
        "evaluate" => evaluate(evaluator),
        "lower" => lower(),
        "picture" => picture(evaluator),
        "breed" => breed(),
        _ => {
            eprintln!("usage: instruction_count evaluate|lower|picture|breed");
            return ExitCode::from(2);
        }
    };
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build();
    let pool = pool.expect("one thread can be started");
    // Runs on the thread of the pool, so that tasks of the workload run below `measured` as well.
    pool.install(move || measured(prepared));
    ExitCode::SUCCESS
}

/// Everything below this is counted. Contains no closure, whose name a counter would match as well.
#[inline(never)]
fn measured(mut work: Box<dyn FnMut() + Send>) {
    work();
}

/// Evaluates 20 programs on a 64 x 64 sphere.
fn evaluate(evaluator: CanonicalEvaluator) -> Box<dyn FnMut() + Send> {
    let set = sphere(64);
    let programs: Vec<Program> = genomes(20).iter().map(Program::lower).collect();
    let mut out = Vec::new();
    let mut run = move || {
        let batch: Vec<&Program> = programs.iter().collect();
        evaluator.eval(&batch, &set, &mut out).expect("the CPU evaluates");
        black_box(&out);
    };
    // The first run also computes the inputs of the set.
    run();
    Box::new(run)
}

/// Lowers 100 genomes.
fn lower() -> Box<dyn FnMut() + Send> {
    let genomes = genomes(100);
    Box::new(move || {
        for genome in &genomes {
            black_box(Program::lower(genome));
        }
    })
}

/// Renders a picture of 128 x 128 from reflectance to PNG.
fn picture(evaluator: CanonicalEvaluator) -> Box<dyn FnMut() + Send> {
    let set = sphere(128);
    let program = Program::lower(&genomes(1)[0]);
    let mut f = Vec::new();
    evaluator.eval(&[&program], &set, &mut f).expect("the CPU evaluates");
    Box::new(move || {
        let picture = develop(&shade(&set, &f), Exposure::Auto);
        black_box(encode_png(picture.width, picture.height, &picture.rgba));
    })
}

/// Breeds 20 distinct children of one parent.
fn breed() -> Box<dyn FnMut() + Send> {
    let parents = genomes(1);
    Box::new(move || {
        let variation = Variation::mutate(&parents[0], 0.3);
        black_box(make_brood(&BroodRequest { variation, count: 20, seed: SEED, distinct: true }));
    })
}

fn genomes(count: u32) -> Vec<Genome> {
    let random = Variation::random(Dialect::default());
    (0..count).map(|slot| random.birth(BirthKey { seed: SEED, slot, attempt: 0 })).collect()
}

fn sphere(size_px: u32) -> SampleSet {
    SampleSet::render(&Mesh::builtin(BuiltinMesh::Sphere), &Scene::default(), size_px, 1)
}
