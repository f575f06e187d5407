//! `brood bench fitness`: genomes scored per second against a target, from lowering to selection.

use std::time::Instant;

use anyhow::{Result, ensure};
use brood_eval::{CanonicalEvaluator, CanonicalPopulation, Ranked, Screening, select_best};
use brood_genome::Genome;
use brood_program::{Counts, Program};
use clap::Args;
use rayon::prelude::*;
use serde::Serialize;

use super::measure::{self, genomes, median};
use super::record::CommonArgs;
use super::target;
use crate::output;

/// Number of programs selected from a population.
const SELECTED: usize = 20;
/// Share of a population that passes a race.
const RACE_SHARE: f64 = 0.05;

/// Options of `brood bench fitness`.
#[derive(Debug, Args)]
pub struct BenchFitnessArgs {
    /// Number of random genomes in a population
    #[arg(long, value_name = "N", default_value_t = 2000, value_parser = clap::value_parser!(u32).range(20..=100_000))]
    population: u32,
    /// Number of populations, each with other genomes and another target
    #[arg(long, value_name = "N", default_value_t = 10, value_parser = clap::value_parser!(u32).range(1..=1000))]
    rounds: u32,
    /// Number of samples of the target
    #[arg(long, value_name = "N", default_value_t = 4096, value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    samples: u32,
    #[command(flatten)]
    common: CommonArgs,
}

/// Rates and times under one screening: medians over the populations; of the shares selected, the
/// least.
#[derive(Debug, Default, Serialize)]
struct Row {
    screening: &'static str,
    threads: usize,
    genomes_per_second: f64,
    /// Rate without lowering.
    programs_per_second: f64,
    /// Wall-clock microseconds per genome with all threads busy: genome to program.
    lowering_us: f64,
    /// Microseconds per genome to translate programs into instructions for these samples, timed
    /// separately.
    translation_us: f64,
    /// Microseconds per genome for evaluation, sums and selection.
    evaluation_us: f64,
    /// Share of the blocks of 256 samples that were evaluated.
    blocks_evaluated_share: f64,
    /// Scalar operations of the unlowered genomes on all samples, per second.
    equivalent_operations_per_second: f64,
    executed_operations_per_second: f64,
    /// Share of the 20 best programs of the full evaluation that were selected.
    selected_share: f64,
}

/// Times and counts of one population under one screening.
#[derive(Debug, Default, Clone, Copy)]
struct RoundResult {
    /// Time of lowering, translation, evaluation and selection.
    seconds: f64,
    lowering_seconds: f64,
    translation_seconds: f64,
    /// Share of the blocks that were evaluated.
    evaluated: f64,
    /// Scalar operations of the unlowered genomes, on all samples.
    written: f64,
    /// Scalar operations executed, estimated.
    executed: f64,
    /// Share of the selection of the full evaluation that was selected.
    same: f64,
}

/// Runs the command.
pub fn run(args: &BenchFitnessArgs, json: bool) -> Result<()> {
    let folder = args.common.start()?;
    let screenings = [
        ("none", Screening::None),
        ("exact", Screening::Exact),
        ("race", Screening::Race { share: RACE_SHARE }),
    ];
    let bar = output::bar(u64::from(args.rounds), "populations");
    let mut rounds = [(); 3].map(|()| Vec::new());
    for round in 0..args.rounds {
        let seed = args.common.seed.wrapping_add(round.into());
        let genomes = genomes(seed, args.population);
        let mut all = Vec::new();
        for (rounds, (_, screening)) in rounds.iter_mut().zip(screenings) {
            let (result, best) = measure(args, seed, &genomes, screening, &all)?;
            rounds.push(result);
            if all.is_empty() {
                all = best;
            }
        }
        bar.inc(1);
    }
    bar.finish_and_clear();
    let rows: Vec<Row> = screenings
        .iter()
        .zip(&rounds)
        .map(|((name, _), rounds)| row(name, args.population, rounds))
        .collect();
    ensure!(rows[1].selected_share >= 1.0, "exact screening changed a selection");
    let line = |row: &Row| {
        format!(
            "{:<6} {:9.0} genomes/s  ({:9.0} without lowering)  {:5.1} us lowering {:5.1} translation {:5.1} evaluation  \
             {:4.0} % of blocks  {:6.1} G equivalent  {:5.1} G executed operations/s  {:3.0} % of the best {SELECTED}\n",
            row.screening,
            row.genomes_per_second,
            row.programs_per_second,
            row.lowering_us,
            row.translation_us,
            row.evaluation_us,
            100.0 * row.blocks_evaluated_share,
            row.equivalent_operations_per_second / 1e9,
            row.executed_operations_per_second / 1e9,
            100.0 * row.selected_share,
        )
    };
    let head = format!(
        "{} rounds of {} random genomes against {} samples, {} threads; medians\n",
        args.rounds,
        args.population,
        args.samples,
        rayon::current_num_threads()
    );
    folder.finish_rows("fitness", &rows, (&head, line), json)
}

/// Measures one population under one screening. `all` is the selection of the full evaluation,
/// empty while that is measured.
fn measure(
    args: &BenchFitnessArgs,
    seed: u64,
    genomes: &[Genome],
    screening: Screening,
    all: &[Ranked],
) -> Result<(RoundResult, Vec<Ranked>)> {
    let reference = measure::programs(seed ^ 0x5eed, 1).remove(0);
    let target = target::of(&reference, args.samples as usize, seed)?;
    let evaluator = CanonicalEvaluator::default();
    // Inputs belong to the target: another population computes them before the clock starts.
    let others = measure::programs(seed.wrapping_add(7), 50);
    let others: Vec<&Program> = others.iter().collect();
    select_best(&evaluator, &others, &target, 1, Screening::None)?;
    let start = Instant::now();
    let programs: Vec<Program> = genomes.par_iter().map(Program::lower).collect();
    let lowering_seconds = start.elapsed().as_secs_f64();
    let population: Vec<&Program> = programs.iter().collect();
    let selected = select_best(&evaluator, &population, &target, SELECTED, screening)?;
    let seconds = start.elapsed().as_secs_f64();
    let start = Instant::now();
    let translated = CanonicalPopulation::new(&population, &target, evaluator.level());
    let translation_seconds = start.elapsed().as_secs_f64();
    drop(translated);
    let samples = f64::from(args.samples);
    let written: u64 =
        genomes.iter().map(|genome| u64::from(Counts::of(genome).scalar_operations)).sum();
    let evaluated = selected.blocks_evaluated as f64 / selected.blocks as f64;
    let live: usize = programs.iter().map(Program::operations).sum();
    let same = selected.best.iter().filter(|one| all.contains(one)).count();
    let found = RoundResult {
        seconds,
        lowering_seconds,
        translation_seconds,
        evaluated,
        written: written as f64 * samples,
        // A program that is aborted early counts as one of mean length.
        executed: live as f64 * samples * evaluated,
        same: if all.is_empty() { 1.0 } else { same as f64 / all.len() as f64 },
    };
    Ok((found, selected.best))
}

fn row(screening: &'static str, population: u32, rounds: &[RoundResult]) -> Row {
    let count = f64::from(population);
    let of = |value: &dyn Fn(&RoundResult) -> f64| median(rounds.iter().map(value));
    Row {
        screening,
        threads: rayon::current_num_threads(),
        genomes_per_second: of(&|r| count / r.seconds),
        programs_per_second: of(&|r| count / (r.seconds - r.lowering_seconds)),
        lowering_us: of(&|r| 1e6 * r.lowering_seconds / count),
        translation_us: of(&|r| 1e6 * r.translation_seconds / count),
        evaluation_us: of(&|r| {
            1e6 * (r.seconds - r.lowering_seconds - r.translation_seconds) / count
        }),
        blocks_evaluated_share: of(&|r| r.evaluated),
        equivalent_operations_per_second: of(&|r| r.written / r.seconds),
        executed_operations_per_second: of(&|r| r.executed / r.seconds),
        selected_share: rounds.iter().map(|r| r.same).fold(1.0, f64::min),
    }
}
