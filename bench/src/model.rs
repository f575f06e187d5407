//! `brood bench model`: times reflectance models on one core, next to random programs of the same
//! run, measures the error of blocks of samples against the f64 reference, and checks models at
//! hard parameters and directions.

use std::time::Instant;

use anyhow::Result;
use brood_brdf::{Block, Brdf, DirectionPair, PreparedModel};
use brood_eval::conformance::{hard_samples, wild_model};
use brood_eval::{CanonicalEvaluator, Level, model_error};
use brood_genome::{Genome, Model, ModelKind};
use brood_program::Program;
use brood_scene::SampleSet;
use clap::Args;

use super::measure::{fastest_and_slowest_pass, one_thread, programs};
use super::record::{CommonArgs, Finding, SeedsArgs};
use super::target::random_pairs;
use crate::chart::{Axis, Bar, BarChart, Group, ResultTable, cells};
use crate::output;

/// Number of samples of a set, as in the benchmarks of programs.
const SAMPLES: usize = 4096;
/// Number of random programs that models are compared with.
const PROGRAMS: u32 = 100;
/// Number of samples of the stress test of each model.
const HARD_SAMPLES: usize = 2000;

/// Options of `brood bench model`.
#[derive(Debug, Args)]
pub struct BenchModelArgs {
    /// Number of random models of each kind and seed in the stress test
    #[arg(long, value_name = "N", default_value_t = 50, value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    models: u32,
    /// Number of passes; the fastest counts, the slowest is printed as well
    #[arg(long, value_name = "N", default_value_t = 5, value_parser = clap::value_parser!(u32).range(1..=10_000))]
    passes: u32,
    #[command(flatten)]
    seeds: SeedsArgs,
    #[command(flatten)]
    common: CommonArgs,
}

/// Results of one kind of model.
struct Row {
    kind: ModelKind,
    /// Nanoseconds per sample in blocks, fastest pass.
    ns: f64,
    slowest_ns: f64,
    /// Nanoseconds per sample of the scalar f64 reference.
    reference_ns: f64,
    /// Microseconds to prepare the model.
    prepare_us: f64,
    stress: Stress,
}

/// Results of random models of a kind on hard samples.
#[derive(Default)]
struct Stress {
    values: u64,
    not_finite: u64,
    negative: u64,
    /// Pairs whose bits change when light and eye are swapped, for models that claim to be
    /// reciprocal.
    not_reciprocal: u64,
    /// Largest relative difference from the reference.
    error: f64,
}

/// Runs the command.
pub fn run(args: &BenchModelArgs, json: bool) -> Result<()> {
    let folder = args.common.start()?;
    let of_seed = |seed| Ok(vec![of_seed(args, seed)?]);
    let finding = args.seeds.measure(args.common.seed, false, of_seed)?.remove(0);
    folder.finish_table(&finding, json)
}

fn of_seed(args: &BenchModelArgs, seed: u64) -> Result<Finding> {
    let set = SampleSet::from_pairs(&random_pairs(seed, SAMPLES), &[]);
    let pool = one_thread()?;
    let programs = programs(seed, PROGRAMS);
    let programs: Vec<&Program> = programs.iter().collect();
    let (of_programs, _) = pool.install(|| time(&programs, &set, args.passes))?;
    let bar = output::bar(ModelKind::ALL.len() as u64, "models");
    let mut rows = Vec::new();
    for kind in ModelKind::ALL {
        let model = Model::new(kind);
        let started = Instant::now();
        let prepared = model.prepare();
        let prepare_us = started.elapsed().as_secs_f64() * 1e6;
        let reference_ns = time_reference(&prepared, &set, args.passes);
        let program = Program::lower(&Genome::of_models(vec![model])?);
        let (ns, slowest_ns) = pool.install(|| time(&[&program], &set, args.passes))?;
        let stress = stress(kind, args.models, seed);
        rows.push(Row { kind, ns, slowest_ns, reference_ns, prepare_us, stress });
        bar.inc(1);
    }
    bar.finish_and_clear();
    Ok(Finding {
        name: "model",
        note: format!("one thread, {SAMPLES} samples, preparation included"),
        table: table(&rows, of_programs),
        raw: None,
        chart: chart(&rows).into(),
    })
}

/// Nanoseconds per program and sample of the fastest and the slowest pass.
fn time(programs: &[&Program], set: &SampleSet, passes: u32) -> Result<(f64, f64)> {
    let evaluator = CanonicalEvaluator::default();
    let (fastest, slowest) = fastest_and_slowest_pass(&evaluator, programs, set, passes)?;
    let samples = (programs.len() * set.len()) as f64;
    Ok((fastest * 1e9 / samples, slowest * 1e9 / samples))
}

/// Nanoseconds per sample of the scalar f64 reference, fastest pass.
fn time_reference(model: &PreparedModel, set: &SampleSet, passes: u32) -> f64 {
    let pass = |_| {
        let started = Instant::now();
        for pair in set.pairs(0..set.len()) {
            std::hint::black_box(model.f(pair));
        }
        started.elapsed().as_secs_f64()
    };
    (0..passes).map(pass).fold(f64::INFINITY, f64::min) * 1e9 / set.len() as f64
}

/// Evaluates random models of one kind on hard samples, in blocks.
fn stress(kind: ModelKind, models: u32, seed: u64) -> Stress {
    let mut found = Stress::default();
    for slot in 0..u64::from(models) {
        // Other models and samples than those of the next seeds.
        let seed = seed.wrapping_mul(1 << 20).wrapping_add(slot);
        let model = wild_model(kind, seed);
        let prepared = model.prepare();
        let reciprocal = prepared.claims().reciprocal;
        let set = hard_samples(seed, HARD_SAMPLES);
        let pairs = set.pairs(0..set.len());
        let swapped: Vec<DirectionPair> = pairs.iter().map(DirectionPair::swapped).collect();
        for (f, back) in values(&prepared, pairs).into_iter().zip(values(&prepared, &swapped)) {
            found.values += 1;
            found.not_finite += u64::from(!f.is_finite());
            found.negative += u64::from(f < 0.0);
            found.not_reciprocal += u64::from(reciprocal && f.to_bits() != back.to_bits());
        }
        found.error = found.error.max(model_error(&model, &set, Level::best()));
    }
    found
}

/// f of each pair, grouped by block and channel.
fn values(model: &PreparedModel, pairs: &[DirectionPair]) -> Vec<f64> {
    let (level, mut block) = (Level::best(), Block::<64>::new());
    let mut values = Vec::with_capacity(3 * pairs.len());
    for pairs in pairs.chunks(64) {
        block.fill(level, pairs);
        for row in model.f_block(level, &block) {
            values.extend_from_slice(&row[..pairs.len()]);
        }
    }
    values
}

fn table(rows: &[Row], of_programs: f64) -> ResultTable {
    rows.iter()
        .map(|row| {
            cells! {
                model: row.kind.name(),
                ns_per_sample: row.ns,
                slowest_ns_per_sample: row.slowest_ns,
                times_a_random_program: row.ns / of_programs,
                reference_ns_per_sample: row.reference_ns,
                largest_relative_error: row.stress.error,
                prepare_us: row.prepare_us,
                stress_values: row.stress.values,
                not_finite: row.stress.not_finite,
                negative: row.stress.negative,
                not_reciprocal: row.stress.not_reciprocal,
            }
        })
        .collect()
}

fn chart(rows: &[Row]) -> BarChart {
    let group = |row: &Row| Group {
        name: row.kind.name().to_owned(),
        bars: vec![Bar { value: row.ns, suffix: " ns".to_owned(), ..Bar::default() }],
    };
    BarChart::new(
        "Reflectance models: time per sample on one core",
        format!("defaults, {SAMPLES} samples, f64, preparation included"),
        Axis::linear("nanoseconds per sample"),
        rows.iter().map(group),
    )
}
