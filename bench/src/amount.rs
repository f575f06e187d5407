//! `brood bench amount`: distance between pictures of parents and children, for each amount of
//! mutation and recombination.
//!
//! Children are first draws, as under `curation: off`, so that the operators are measured without
//! redraws.

use anyhow::Result;
use brood_genome::{BirthKey, Genome, Variation};
use brood_program::Program;
use clap::Args;
use rayon::prelude::*;

use super::flip::PictureSet;
use super::measure::{quantile, visible_genomes};
use super::record::{CommonArgs, Finding, SeedsArgs};
use crate::chart::{Axis, Plot, Point, ResultTable, Series, cells};
use crate::output;

/// Options of `brood bench amount`.
#[derive(Debug, Args)]
pub struct BenchAmountArgs {
    /// Number of parents, and of pairs of parents, of each seed
    #[arg(long, value_name = "N", default_value_t = 100, value_parser = clap::value_parser!(u32).range(1..=10_000))]
    count: u32,
    /// Side of the compared pictures in pixels
    #[arg(long, value_name = "N", default_value_t = 48, value_parser = clap::value_parser!(u32).range(16..=256))]
    size: u32,
    #[command(flatten)]
    seeds: SeedsArgs,
    #[command(flatten)]
    common: CommonArgs,
}

/// Amounts of mutation and of recombination.
const AMOUNTS: [f32; 13] = [0.0, 0.025, 0.05, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0];

/// Name of the parent that children approach with the amount of recombination.
const SECOND_PARENT: &str = "the second parent";

/// Distances of the children from one parent, for each amount.
struct Effect {
    name: &'static str,
    /// Parent that the distances are measured from.
    from: &'static str,
    /// By amount, then by child.
    distances: Vec<Vec<f64>>,
}

impl Effect {
    fn means(&self) -> Vec<f64> {
        let mean = |values: &Vec<f64>| values.iter().sum::<f64>() / values.len() as f64;
        self.distances.iter().map(mean).collect()
    }
}

/// Runs the command.
pub fn run(args: &BenchAmountArgs, json: bool) -> Result<()> {
    let folder = args.common.start()?;
    let of_seed = |seed| Ok(vec![of_seed(args, seed)?]);
    let finding = args.seeds.measure(args.common.seed, false, of_seed)?.remove(0);
    folder.finish(finding, json)
}

fn of_seed(args: &BenchAmountArgs, seed: u64) -> Result<Finding> {
    // One extra, so that a single parent has a mate.
    let parents: Vec<Genome> = visible_genomes(seed)?.take(args.count as usize + 1).collect();
    let bar = output::bar(u64::from(args.count), "breeding and comparing");
    let measured: Vec<[Vec<f64>; 3]> = (0..args.count as usize)
        .into_par_iter()
        .map(|number| {
            let mate = &parents[(number + 1) % parents.len()];
            let found = distances(args, [&parents[number], mate], seed, number as u32);
            bar.inc(1);
            found
        })
        .collect::<Result<_>>()?;
    bar.finish_and_clear();
    let effect = |kind: usize, name, from| Effect {
        name,
        from,
        distances: (0..AMOUNTS.len())
            .map(|amount| measured.iter().map(|of| of[kind][amount]).collect())
            .collect(),
    };
    let effects = [
        effect(0, "mutation", "the parent"),
        effect(1, "recombination", "the first parent"),
        effect(2, "recombination", SECOND_PARENT),
    ];
    Ok(Finding {
        name: "amount",
        note: format!(
            "{} random parents, none black; one child of each at each amount, without redraws; mean FLIP over the object at {} \
             pixels with automatic exposure, from 0 (same) to 1. A larger amount should increase the \
             mean from the parent and from the first parent, and decrease that from the second; `against` is 1 where it does not",
            args.count, args.size,
        ),
        table: table(&effects),
        raw: None,
        chart: chart(&effects, args).into(),
    })
}

/// Distances of each mutant from its parent, and of each child of two from its first and second
/// parent, by amount.
fn distances(
    args: &BenchAmountArgs,
    [parent, mate]: [&Genome; 2],
    seed: u64,
    slot: u32,
) -> Result<[Vec<f64>; 3]> {
    let key = BirthKey { seed, slot, attempt: 1 };
    let mutant = |amount: &f32| Variation::mutate(parent, *amount).birth(key);
    let child = |amount: &f32| Variation::crossover(parent, mate, *amount, 0.0).birth(key);
    let genomes = [parent.clone(), mate.clone()];
    let genomes =
        genomes.into_iter().chain(AMOUNTS.iter().map(mutant)).chain(AMOUNTS.iter().map(child));
    let programs: Vec<Program> = genomes.map(|genome| Program::lower(&genome)).collect();
    let pictures = PictureSet::of(&programs.iter().collect::<Vec<_>>(), args.size)?;
    let count = AMOUNTS.len();
    let from = |origin: usize, first: usize| -> Vec<f64> {
        (first..first + count).map(|one| pictures.flip(origin, one)).collect()
    };
    Ok([from(0, 2), from(0, 2 + count), from(1, 2 + count)])
}

fn table(effects: &[Effect]) -> ResultTable {
    let mut table = ResultTable::default();
    for effect in effects {
        let means = effect.means();
        for (index, (amount, distances)) in AMOUNTS.iter().zip(&effect.distances).enumerate() {
            let share = |share| quantile(distances, share);
            let (before, mean) = (means[index.saturating_sub(1)], means[index]);
            let against = if effect.from == SECOND_PARENT { mean > before } else { mean < before };
            table.push(cells! {
                knob: effect.name,
                value: f64::from(*amount),
                from: effect.from,
                mean: mean,
                against: u32::from(against),
                p10: share(0.1),
                median: share(0.5),
                p90: share(0.9),
            });
        }
    }
    table
}

fn chart(effects: &[Effect], args: &BenchAmountArgs) -> Plot {
    let series = |effect: &Effect| {
        let point = |(amount, y): (&f32, f64)| Point { x: (*amount).into(), y, ..Point::default() };
        let points = AMOUNTS.iter().zip(effect.means()).map(point);
        Series::dotted(&format!("{}, from {}", effect.name, effect.from), points)
    };
    Plot {
        title: "Change of pictures by amount".to_owned(),
        subtitle: format!("{} random parents; first draws, {} pixels", args.count, args.size),
        x: Axis::linear("amount"),
        y: Axis::linear("mean FLIP over the object"),
        series: effects.iter().map(series).collect(),
    }
}
