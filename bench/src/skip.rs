//! `brood bench skip`: saving of each optimisation that skips work: the same work with it and
//! without it, in one run.
//!
//! Counts show the amount of work saved, times the effect. Pictures that are served from a cache
//! over HTTP are covered by `bench breed`.

mod fitness;
mod input;
mod kept;
mod lowering;
mod twin;
mod unlit;
mod unlowered;

use anyhow::Result;
use clap::Args;

use super::measure::one_thread;
use super::record::{CommonArgs, Finding, SeedsArgs};
use crate::chart::{Axis, Bar, BarChart, Group, ResultTable, cells};
use crate::output;

/// Options of `brood bench skip`.
#[derive(Debug, Args)]
pub struct BenchSkipArgs {
    /// Small, quick run that only shows that everything works
    #[arg(long)]
    short: bool,
    #[command(flatten)]
    seeds: SeedsArgs,
    #[command(flatten)]
    common: CommonArgs,
}

/// Amount of work of the benchmark.
#[derive(Debug, Clone, Copy)]
struct Workload {
    seed: u64,
    genomes: u32,
    size_px: u32,
    repeats: u32,
}

/// Measures one or more optimisations.
type Measurement = fn(&Workload) -> Result<Vec<Saving>>;

/// Result of one optimisation.
#[derive(Debug)]
struct Saving {
    /// Work that is skipped.
    name: String,
    /// Unit of the counts.
    counted: &'static str,
    /// Count without the optimisation.
    without: u64,
    /// Count with it.
    with: u64,
    /// Work that is timed.
    timed: &'static str,
    /// Time without the optimisation.
    without_ms: f64,
    /// Time with it.
    with_ms: f64,
    /// Share of the result that is as without it.
    percent_same: f64,
}

impl Saving {
    /// Share of the work left, in percent.
    fn percent_left(&self) -> f64 {
        100.0 * self.with as f64 / self.without.max(1) as f64
    }

    fn times_faster(&self) -> f64 {
        self.without_ms / self.with_ms
    }
}

/// Runs the command.
pub fn run(args: &BenchSkipArgs, json: bool) -> Result<()> {
    let folder = args.common.start()?;
    let of_seed = |seed| Ok(vec![of_seed(seed, args.short)?]);
    let finding = args.seeds.measure(args.common.seed, args.short, of_seed)?.remove(0);
    folder.finish(finding, json)
}

fn of_seed(seed: u64, is_short: bool) -> Result<Finding> {
    let workload = if is_short {
        Workload { seed, genomes: 10, size_px: 32, repeats: 1 }
    } else {
        Workload { seed, genomes: 50, size_px: 256, repeats: 3 }
    };
    let parts: [Measurement; 6] = [
        lowering::measure,
        input::measure,
        unlit::measure,
        kept::measure,
        fitness::measure,
        twin::measure,
    ];
    let bar = output::bar(parts.len() as u64, "skipping");
    let pool = one_thread()?;
    let mut savings = Vec::new();
    for part in parts {
        savings.extend(pool.install(|| part(&workload))?);
        bar.inc(1);
    }
    bar.finish_and_clear();
    Ok(Finding {
        name: "skip",
        note: format!(
            "one thread, random genomes of the default dialect, pictures of {size} x {size}; with and without alternating, \
             the fastest of {repeats}",
            size = workload.size_px,
            repeats = workload.repeats
        ),
        table: table(&savings),
        raw: None,
        chart: chart(&savings).into(),
    })
}

fn table(savings: &[Saving]) -> ResultTable {
    savings
        .iter()
        .map(|saving| {
            cells! {
                skipped: saving.name.as_str(),
                counted: saving.counted,
                without: saving.without,
                with: saving.with,
                timed: saving.timed,
                without_ms: saving.without_ms,
                with_ms: saving.with_ms,
                percent_same: saving.percent_same,
                percent_left: saving.percent_left(),
                times_faster: saving.times_faster(),
            }
        })
        .collect()
}

fn chart(savings: &[Saving]) -> BarChart {
    let group = |saving: &Saving| {
        let suffix = " x".to_owned();
        let bar = Bar { value: saving.times_faster(), suffix, ..Bar::default() };
        Group { name: saving.name.clone(), bars: vec![bar] }
    };
    let subtitle = "time without over time with it, same run, one thread".to_owned();
    let axis = Axis::log("times faster");
    BarChart::new("Speed-up by skipping work", subtitle, axis, savings.iter().map(group))
}
