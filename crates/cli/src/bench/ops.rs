//! Scalar operations a second on one core: random programs on 4096 samples, translation and output included.
//!
//! A GP operation is one scalar operation of a program on one sample. *Executed* counts what runs after lowering,
//! *equivalent* what the genome as written would take.

use std::time::Instant;

use anyhow::{Context, Result};
use brood_eval::conformance::hard_samples;
use brood_eval::{CanonicalEvaluator, Evaluator, Level};
use brood_genome::{BirthKey, Dialect, Genome, Opcode, Output, Variation};
use brood_program::{Counts, Program};
use brood_scene::SampleSet;
use clap::Args;
use serde::Serialize;

use crate::logging;

/// Samples of a set, as peers are measured.
const SAMPLES: usize = 4096;

/// Options of `brood bench ops`.
#[derive(Debug, Args)]
pub struct BenchOpsArgs {
    /// Random programs of each mix
    #[arg(long, value_name = "N", default_value_t = 200, value_parser = clap::value_parser!(u32).range(1..=100_000))]
    programs: u32,
    /// Passes over all programs; the fastest counts, the slowest is shown beside it
    #[arg(long, value_name = "N", default_value_t = 7, value_parser = clap::value_parser!(u32).range(1..=10_000))]
    passes: u32,
    /// Seed of the programs
    #[arg(long, default_value_t = 1)]
    seed: u64,
}

#[derive(Debug, Serialize)]
struct Row {
    mix: &'static str,
    level: &'static str,
    executed_per_second: f64,
    slowest_executed_per_second: f64,
    equivalent_per_second: f64,
    operations_per_program: f64,
    programs_per_second: f64,
}

struct Mix {
    name: &'static str,
    opcodes: &'static [Opcode],
}

const MIXES: [Mix; 3] = [
    Mix { name: "add sub mul", opcodes: &[Opcode::Add, Opcode::Sub, Opcode::Mul] },
    Mix {
        name: "add sub mul sin ex2",
        opcodes: &[Opcode::Add, Opcode::Sub, Opcode::Mul, Opcode::Sin, Opcode::Ex2],
    },
    Mix { name: "paper's opcodes", opcodes: Opcode::ALL.split_at(Opcode::PAPER).0 },
];

/// Runs the command.
pub fn run(args: &BenchOpsArgs, json: bool) -> Result<()> {
    logging::start_offline();
    let set = hard_samples(args.seed, SAMPLES);
    let one_thread = rayon::ThreadPoolBuilder::new().num_threads(1).build();
    let one_thread = one_thread.context("make a pool of one thread")?;
    let mut rows = Vec::new();
    for mix in MIXES {
        let genomes: Vec<Genome> =
            (0..args.programs).map(|slot| genome(&mix, args.seed, slot)).collect();
        for level in Level::available() {
            rows.push(one_thread.install(|| measure(&mix, level, &genomes, &set, args.passes))?);
        }
    }
    if json {
        println!("{}", serde_json::to_string_pretty(&rows)?);
        return Ok(());
    }
    println!(
        "one thread, {SAMPLES} samples, {} programs; executed operations a second",
        args.programs
    );
    for row in rows {
        println!(
            "{:<20} {:<8} {:6.2} G  (slowest pass {:6.2} G)  equivalent {:7.2} G  {:5.1} operations  {:7.0} programs a second",
            row.mix,
            row.level,
            row.executed_per_second / 1e9,
            row.slowest_executed_per_second / 1e9,
            row.equivalent_per_second / 1e9,
            row.operations_per_program,
            row.programs_per_second,
        );
    }
    Ok(())
}

/// A random genome of 100 instructions of the mix.
fn genome(mix: &Mix, seed: u64, slot: u32) -> Genome {
    let long = Dialect { length: 1024, ..Dialect::default() };
    let drawn = Variation::random(long).birth(BirthKey { seed, slot, attempt: 0 });
    let of_mix = drawn.instructions().iter().filter(|i| mix.opcodes.contains(&i.opcode()));
    let instructions: Vec<_> = of_mix.take(100).copied().collect();
    let length = u16::try_from(instructions.len()).expect("at most 100");
    let dialect = Dialect { length, ..Dialect::default() };
    let constants = Box::new(*drawn.constants());
    Genome::new(dialect, instructions, constants, Output::IDENTITY)
        .expect("a part of a genome of the same dialect")
}

fn measure(
    mix: &Mix,
    level: Level,
    genomes: &[Genome],
    set: &SampleSet,
    passes: u32,
) -> Result<Row> {
    let programs: Vec<Program> = genomes.iter().map(Program::lower).collect();
    let executed: usize = programs.iter().map(Program::operations).sum();
    let equivalent: u32 = genomes.iter().map(|genome| Counts::of(genome).scalar_operations).sum();
    let evaluator = CanonicalEvaluator::with_level(level);
    let mut out = Vec::new();
    let mut times = Vec::new();
    // The first pass fills the inputs and is not counted.
    for pass in 0..=passes {
        let started = Instant::now();
        for program in &programs {
            evaluator.eval(&[program], set, &mut out)?;
        }
        if pass > 0 {
            times.push(started.elapsed().as_secs_f64());
        }
    }
    let fastest = times.iter().copied().fold(f64::INFINITY, f64::min);
    let slowest = times.iter().copied().fold(0.0, f64::max);
    let per_second = |operations: f64, seconds: f64| operations * set.len() as f64 / seconds;
    Ok(Row {
        mix: mix.name,
        level: level.name(),
        executed_per_second: per_second(executed as f64, fastest),
        slowest_executed_per_second: per_second(executed as f64, slowest),
        equivalent_per_second: per_second(f64::from(equivalent), fastest),
        operations_per_program: executed as f64 / programs.len() as f64,
        programs_per_second: programs.len() as f64 / fastest,
    })
}
