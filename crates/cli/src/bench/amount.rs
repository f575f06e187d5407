//! `brood bench amount`: distance between pictures of parents and children, for each amount of
//! mutation and recombination.
//!
//! Children are first draws, as under `curation: off`, so that the operators are measured without
//! redraws.

use std::path::PathBuf;

use anyhow::Result;
use brood_eval::Preview;
use brood_genome::{BirthKey, Dialect, Genome, Output, Variation};
use brood_program::Program;
use clap::Args;
use rayon::prelude::*;

use super::flip::PictureSet;
use super::measure::quantile;
use super::record::{Finding, Findings, Folder};
use crate::chart::{Axis, Plot, Point, ResultTable, Scale, Series};
use crate::{logging, output};

/// Options of `brood bench amount`.
#[derive(Debug, Args)]
pub struct BenchAmountArgs {
    /// Folder for amount.json, amount.csv and amount.svg
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Number of parents, and of pairs of parents
    #[arg(long, value_name = "N", default_value_t = 200, value_parser = clap::value_parser!(u32).range(1..=10_000))]
    count: u32,
    /// Side of the compared pictures in pixels
    #[arg(long, value_name = "N", default_value_t = 48, value_parser = clap::value_parser!(u32).range(16..=256))]
    size: u32,
    /// Seed of the parents and the children
    #[arg(long, default_value_t = 1)]
    seed: u64,
}

const AMOUNTS: [f32; 13] = [0.0, 0.025, 0.05, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0];
/// Saturation of the parents; the page's default.
const SATURATION: f32 = 0.65;

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
    logging::start_offline();
    let folder = Folder::make(args.out.as_deref())?;
    let parents = parents(args)?;
    let bar = output::bar(u64::from(args.count), "breeding and comparing");
    let measured: Vec<[Vec<f64>; 3]> = (0..args.count as usize)
        .into_par_iter()
        .map(|number| {
            let mate = &parents[(number + 1) % parents.len()];
            let found = distances(args, &parents[number], mate, number as u32);
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
        effect(2, "recombination", "the second parent"),
    ];
    let grows = |means: &[f64]| means.is_sorted();
    let falls = |means: &[f64]| means.iter().rev().is_sorted();
    let verdict = |holds: bool| if holds { "at every step" } else { "NOT at every step" };
    let finding = Finding {
        name: "amount",
        note: format!(
            "{} random parents, none black; one child of each at each amount, without redraws; mean FLIP over the object at {} \
             pixels with automatic exposure, from 0 (same) to 1. The mean grows with mutation {}, from the first parent \
             with recombination {}, and falls from the second parent {}",
            args.count,
            args.size,
            verdict(grows(&effects[0].means())),
            verdict(grows(&effects[1].means())),
            verdict(falls(&effects[2].means())),
        ),
        table: table(&effects),
        raw: None,
        chart: chart(&effects, args).svg(),
    };
    folder.add(&finding)?;
    let findings = [finding];
    folder.add_json("amount", &Findings(&findings))?;
    if json { output::print_json(&Findings(&findings)) } else { output::print(&findings[0].text()) }
}

/// Distances of each mutant from its parent, and of each child of two from its first and second
/// parent, by amount.
fn distances(
    args: &BenchAmountArgs,
    parent: &Genome,
    mate: &Genome,
    slot: u32,
) -> Result<[Vec<f64>; 3]> {
    let key = BirthKey { seed: args.seed, slot, attempt: 1 };
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

fn parents(args: &BenchAmountArgs) -> Result<Vec<Genome>> {
    let random = Variation::random(Dialect::default());
    let random = random.with_output(Some(Output::saturation(SATURATION)?));
    let births = (0..).map(|slot| random.birth(BirthKey { seed: args.seed, slot, attempt: 0 }));
    let is_seen = |genome: &Genome| !Preview::of(&Program::lower(genome)).is_black();
    // One extra, so that a single parent has a mate.
    Ok(births.filter(is_seen).take(args.count as usize + 1).collect())
}

fn table(effects: &[Effect]) -> ResultTable {
    let mut table = ResultTable::new(&["knob", "value", "from", "mean", "p10", "median", "p90"]);
    for effect in effects {
        for ((amount, distances), mean) in AMOUNTS.iter().zip(&effect.distances).zip(effect.means())
        {
            let share = |share| quantile(distances.iter().copied(), share);
            table.push([
                effect.name.into(),
                f64::from(*amount).into(),
                effect.from.into(),
                mean.into(),
                share(0.1).into(),
                share(0.5).into(),
                share(0.9).into(),
            ]);
        }
    }
    table
}

fn chart(effects: &[Effect], args: &BenchAmountArgs) -> Plot {
    let series = |effect: &Effect| Series {
        name: format!("{}, from {}", effect.name, effect.from),
        dots: true,
        points: AMOUNTS
            .iter()
            .zip(effect.means())
            .map(|(amount, mean)| Point {
                x: f64::from(*amount),
                y: mean,
                label: String::new(),
                is_default: false,
                is_detached: false,
            })
            .collect(),
    };
    Plot {
        title: "Change of pictures by amount".to_owned(),
        subtitle: format!("{} random parents; first draws, {} pixels", args.count, args.size),
        x: Axis { title: "amount", scale: Scale::Linear },
        y: Axis { title: "mean FLIP over the object", scale: Scale::Linear },
        series: effects.iter().map(series).collect(),
    }
}
