//! `brood bench derivative`: times the normal equations of a program's constants, in forward and
//! reverse mode, against plain evaluation of the same programs.

use anyhow::Result;
use brood_eval::{
    CanonicalEvaluator, Direction, FitnessEvaluator, FitnessTarget, normal_equations,
};
use brood_program::Program;
use clap::Args;
use serde::Serialize;

use super::measure::{fastest_of_each_ms, one_thread, programs};
use super::record::CommonArgs;
use super::target;
use crate::output;

/// Most programs measured per group; more only take longer.
const PER_GROUP: usize = 20;
/// Largest number of constants of each group; the last group is open.
const GROUPS: [usize; 8] = [1, 2, 4, 8, 16, 32, 64, usize::MAX];

/// Options of `brood bench derivative`.
#[derive(Debug, Args)]
pub struct BenchDerivativeArgs {
    /// Number of random genomes; at most 20 of each group of constant counts are measured
    #[arg(long, value_name = "N", default_value_t = 2000, value_parser = clap::value_parser!(u32).range(1..=100_000))]
    genomes: u32,
    /// Number of samples of the target
    #[arg(long, value_name = "N", default_value_t = 4096, value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    samples: u32,
    /// Number of runs; the fastest counts
    #[arg(long, value_name = "N", default_value_t = 15, value_parser = clap::value_parser!(u32).range(1..=10_000))]
    repeats: u32,
    #[command(flatten)]
    common: CommonArgs,
}

/// One group of programs; times are microseconds per program, the fastest run, on one thread.
#[derive(Debug, Serialize)]
struct Row {
    constants_min: usize,
    constants_max: usize,
    programs: usize,
    mean_constants: f64,
    mean_operations: f64,
    /// Sum of squares without derivatives.
    plain_us: f64,
    forward_us: f64,
    reverse_us: f64,
    /// Choice of [`Direction::faster`], if it is the same for the whole group.
    chosen: Option<&'static str>,
}

/// Runs the command.
pub fn run(args: &BenchDerivativeArgs, json: bool) -> Result<()> {
    let folder = args.common.start()?;
    let population = programs(args.common.seed, args.genomes);
    // Another seed, so that the target is not in the population.
    let wanted = programs(args.common.seed.wrapping_add(1), 1).remove(0);
    let target = target::of(&wanted, args.samples as usize, args.common.seed)?;
    let (pool, mut rows, mut least) = (one_thread()?, Vec::new(), 1);
    let bar = output::bar(GROUPS.len() as u64, "groups");
    for most in GROUPS {
        let has = |program: &&Program| (least..=most).contains(&program.constants().len());
        let group: Vec<&Program> = population.iter().filter(has).take(PER_GROUP).collect();
        if !group.is_empty() {
            rows.push(pool.install(|| row(&group, &target, args.repeats))?);
        }
        least = most.saturating_add(1);
        bar.inc(1);
    }
    bar.finish_and_clear();
    let head = format!(
        "normal equations against {} samples, one thread, us per program, fastest of {}\n\
         constants  programs  operations     plain   forward   reverse  chosen\n",
        args.samples, args.repeats,
    );
    let line = |row: &Row| {
        let constants = format!("{}-{}", row.constants_min, row.constants_max);
        let Row { programs, mean_operations, plain_us, forward_us, reverse_us, .. } = row;
        let chosen = row.chosen.unwrap_or("either");
        format!(
            "{constants:>9} {programs:9} {mean_operations:11.1} {plain_us:9.1} {forward_us:9.1} {reverse_us:9.1}  {chosen}\n"
        )
    };
    folder.finish_rows("derivative", &rows, (&head, line), json)
}

/// Measures one group of programs.
fn row(group: &[&Program], target: &FitnessTarget, repeats: u32) -> Result<Row> {
    let evaluator = CanonicalEvaluator::default();
    let derive = |direction| {
        for program in group {
            std::hint::black_box(normal_equations(program, target, direction));
        }
        Ok(())
    };
    let ms = fastest_of_each_ms(
        repeats,
        [
            &mut || Ok(evaluator.sums(group, target).map(drop)?),
            &mut || derive(Direction::Forward),
            &mut || derive(Direction::Reverse),
        ],
    )?;
    let [plain_us, forward_us, reverse_us] = ms.map(|ms| 1e3 * ms / group.len() as f64);
    let mean = |of: fn(&Program) -> usize| {
        group.iter().map(|program| of(program)).sum::<usize>() as f64 / group.len() as f64
    };
    let constants = || group.iter().map(|program| program.constants().len());
    let (constants_min, constants_max) =
        (constants().min().unwrap_or(0), constants().max().unwrap_or(0));
    let name = |constants| match Direction::faster(constants) {
        Direction::Forward => "forward",
        Direction::Reverse => "reverse",
    };
    let chosen = name(constants_min);
    Ok(Row {
        constants_min,
        constants_max,
        programs: group.len(),
        mean_constants: mean(|program| program.constants().len()),
        mean_operations: mean(Program::operations),
        plain_us,
        forward_us,
        reverse_us,
        chosen: (chosen == name(constants_max)).then_some(chosen),
    })
}
