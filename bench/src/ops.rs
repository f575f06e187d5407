//! `brood bench ops`: scalar operations per second on one core, for random programs on 4096 random
//! direction pairs, translation and output included.
//!
//! A GP operation is one scalar operation of a program on one sample. *Executed* counts the
//! operations left after lowering, *equivalent* those of the genome as written.

use super::measure::{fastest_and_slowest_pass, one_thread};
use super::record::{CommonArgs, Finding, SeedsArgs};
use super::target::random_pairs;
use crate::chart::{Axis, Bar, BarChart, Group, ResultTable, cells};
use anyhow::Result;
use brood_eval::{CanonicalEvaluator, Level};
use brood_genome::{BirthKey, Dialect, Genome, Opcode, Output, Variation};
use brood_program::{Counts, Operation, Program};
use brood_scene::SampleSet;
use clap::Args;

/// Number of samples of a set, as in the benchmarks compared with.
const SAMPLES: usize = 4096;

/// Options of `brood bench ops`.
#[derive(Debug, Args)]
pub struct BenchOpsArgs {
    /// Number of random programs of each mix and seed
    #[arg(long, value_name = "N", default_value_t = 50, value_parser = clap::value_parser!(u32).range(1..=100_000))]
    programs: u32,
    /// Number of passes over all programs; the fastest counts, the slowest is printed as well
    #[arg(long, value_name = "N", default_value_t = 7, value_parser = clap::value_parser!(u32).range(1..=10_000))]
    passes: u32,
    #[command(flatten)]
    seeds: SeedsArgs,
    #[command(flatten)]
    common: CommonArgs,
}

/// Rates of the programs of one mix with one instruction set.
#[derive(Debug)]
struct Row {
    mix: &'static str,
    level: &'static str,
    executed_per_second: f64,
    slowest_executed_per_second: f64,
    equivalent_per_second: f64,
    operations_per_program: f64,
    /// Share of the executed operations that are not sums, differences or products.
    function_share: f64,
    programs_per_second: f64,
}

/// Opcodes that the instructions of random programs are limited to.
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
    let folder = args.common.start()?;
    let of_seed = |seed| Ok(vec![of_seed(args, seed)?]);
    let finding = args.seeds.measure(args.common.seed, false, of_seed)?.remove(0);
    folder.finish_table(&finding, json)
}

fn of_seed(args: &BenchOpsArgs, seed: u64) -> Result<Finding> {
    let set = SampleSet::from_pairs(&random_pairs(seed, SAMPLES), &[]);
    let pool = one_thread()?;
    let mut rows = Vec::new();
    for mix in MIXES {
        let genomes: Vec<Genome> =
            (0..args.programs).map(|slot| genome(&mix, seed, slot)).collect();
        for level in Level::available() {
            rows.push(pool.install(|| measure(&mix, level, &genomes, &set, args.passes))?);
        }
    }
    Ok(Finding {
        name: "ops",
        note: format!("one thread, {SAMPLES} samples, {} programs of each mix", args.programs),
        table: table(&rows),
        raw: None,
        chart: chart(&rows, args.programs).into(),
    })
}

fn table(rows: &[Row]) -> ResultTable {
    rows.iter()
        .map(|row| {
            cells! {
                mix: row.mix,
                level: row.level,
                executed_per_second: row.executed_per_second,
                slowest_executed_per_second: row.slowest_executed_per_second,
                equivalent_per_second: row.equivalent_per_second,
                operations_per_program: row.operations_per_program,
                function_share: row.function_share,
                programs_per_second: row.programs_per_second,
            }
        })
        .collect()
}

fn chart(rows: &[Row], programs: u32) -> BarChart {
    let levels = Level::available();
    let bar = |row: &Row| Bar {
        series: levels.iter().position(|level| level.name() == row.level).unwrap_or(0),
        value: row.executed_per_second / 1e9,
        suffix: format!(" G/s, {}", row.level),
        ..Bar::default()
    };
    let group = |mix: &Mix| Group {
        name: mix.name.to_owned(),
        bars: rows.iter().filter(|row| row.mix == mix.name).map(bar).collect(),
    };
    BarChart::new(
        "Scalar operations per second on one core",
        format!(
            "{programs} random programs of each mix on {SAMPLES} samples, executed operations, translation and output included"
        ),
        Axis::linear("10^9 operations per second"),
        MIXES.iter().map(group),
    )
}

/// Random genome of 100 instructions of the mix.
fn genome(mix: &Mix, seed: u64, slot: u32) -> Genome {
    let long = Dialect { length: 1024, ..Dialect::default() };
    let drawn = Variation::random(long).birth(BirthKey { seed, slot, attempt: 0 });
    let of_mix = drawn.instructions().iter().filter(|i| mix.opcodes.contains(&i.opcode()));
    let instructions: Vec<_> = of_mix.take(100).copied().collect();
    let length = u16::try_from(instructions.len()).expect("at most 100");
    let dialect = Dialect { length, ..Dialect::default() };
    let constants = Box::new(*drawn.constants());
    Genome::new(dialect, instructions, constants, Output::IDENTITY)
        .expect("instructions come from a genome of the same dialect")
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
    let plain = [Operation::Add, Operation::Sub, Operation::Mul];
    let steps = programs.iter().flat_map(Program::steps);
    let functions = steps.filter(|step| !plain.contains(&step.operation)).count();
    let equivalent: u32 = genomes.iter().map(|genome| Counts::of(genome).scalar_operations).sum();
    let evaluator = CanonicalEvaluator::with_level(level);
    let all: Vec<&Program> = programs.iter().collect();
    let (fastest, slowest) = fastest_and_slowest_pass(&evaluator, &all, set, passes)?;
    let per_second = |operations: f64, seconds: f64| operations * set.len() as f64 / seconds;
    Ok(Row {
        mix: mix.name,
        level: level.name(),
        executed_per_second: per_second(executed as f64, fastest),
        slowest_executed_per_second: per_second(executed as f64, slowest),
        equivalent_per_second: per_second(f64::from(equivalent), fastest),
        operations_per_program: executed as f64 / programs.len() as f64,
        function_share: functions as f64 / executed.max(1) as f64,
        programs_per_second: programs.len() as f64 / fastest,
    })
}
