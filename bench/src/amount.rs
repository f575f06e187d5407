//! `brood bench amount`: distance between pictures of parents and children, for each amount of
//! mutation, by kind of parent, and of recombination.
//!
//! Children are first draws, as under `curation: off`, so that the operators are measured without
//! redraws.

use anyhow::{Context, Result};
use brood_genome::{
    BirthKey, Dialect, Genome, MutationScale, Output, Start, Variation, named_enum,
};
use brood_inspect::OTHER_LIGHT_DEG;
use brood_mesh::BuiltinMesh;
use brood_program::Program;
use brood_protocol::Backend;
use brood_scene::Scene;
use brood_worker::Renderer;
use clap::Args;
use rayon::prelude::*;

use super::flip::PictureSet;
use super::measure::{SATURATION, is_visible, quantile, visible_genomes};
use super::record::{CommonArgs, Finding, SeedsArgs};
use crate::chart::{Axis, Plot, Point, ResultTable, Series, cells};
use crate::output;

/// Options of `brood bench amount`.
#[derive(Debug, Args)]
pub struct BenchAmountArgs {
    /// Number of parents of each kind, and of pairs of parents, of each seed
    #[arg(long, value_name = "N", default_value_t = 100, value_parser = clap::value_parser!(u32).range(1..=10_000))]
    count: u32,
    /// Side of the compared pictures in pixels
    #[arg(long, value_name = "N", default_value_t = 48, value_parser = clap::value_parser!(u32).range(16..=256))]
    size: u32,
    /// Take the amounts as amounts of the operators, from which the visible amount is calibrated
    #[arg(long)]
    operators: bool,
    /// Measure only this kind of parents: wild, believable, models, layers, program and layer,
    /// or painted
    #[arg(long, value_name = "KIND", value_parser = parent_kind)]
    kind: Option<Kind>,
    #[command(flatten)]
    seeds: SeedsArgs,
    #[command(flatten)]
    common: CommonArgs,
}

/// Parses a kind of parents.
///
/// # Errors
/// A list of the kinds.
pub(crate) fn parent_kind(text: &str) -> Result<Kind, String> {
    let known = || Kind::ALL.map(Kind::name).join(", ");
    Kind::from_name(text).ok_or_else(|| format!("must be one of {}", known()))
}

/// Amounts of mutation and of recombination.
const AMOUNTS: [f32; 14] =
    [0.0, 0.01, 0.02, 0.05, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0];

/// Name of the parent that children approach with the amount of recombination.
const SECOND_PARENT: &str = "the second parent";

named_enum! {
    /// Kind of parents.
    #[derive(Debug, Clone, Copy, PartialEq, Eq)]
    pub enum Kind {
        /// Random programs.
        Wild => "wild",
        /// Programs like measured materials.
        Believable => "believable",
        /// Single models.
        Models => "models",
        /// Three models in layers.
        Layers => "layers",
        /// Random programs with a model as a layer.
        Layered => "program and layer",
        /// Painted materials.
        Painted => "painted",
    }
}

/// Mean FLIP and Delta E_ITP over the object between two pictures, under two lights.
#[derive(Debug, Clone, Copy, Default)]
struct Distance {
    flip: f64,
    itp: f64,
}

/// Distances of the children from one parent, for each amount.
struct Effect {
    kind: Kind,
    name: &'static str,
    /// Parent that the distances are measured from.
    from: &'static str,
    /// By amount, then by child.
    distances: Vec<Vec<Distance>>,
    /// Mean distance of two parents of the kind.
    unrelated: Distance,
}

/// Distances of one parent, or pair of parents.
struct Measured {
    /// By amount, for each effect.
    effects: Vec<Vec<Distance>>,
    /// Distance of parent and mate.
    unrelated: Distance,
}

impl Effect {
    fn means(&self) -> Vec<Distance> {
        self.distances.iter().map(|values| mean(values)).collect()
    }
}

fn mean(values: &[Distance]) -> Distance {
    let mean = |part: fn(&Distance) -> f64| {
        values.iter().map(part).sum::<f64>() / values.len().max(1) as f64
    };
    Distance { flip: mean(|one| one.flip), itp: mean(|one| one.itp) }
}

impl Kind {
    /// Start of the lineages that have such parents.
    pub(crate) fn start(self) -> Start {
        match self {
            Self::Wild | Self::Layered => Start::Wild,
            Self::Believable => Start::Believable,
            Self::Models | Self::Layers => Start::Models,
            Self::Painted => Start::Painted,
        }
    }

    /// Parents, without black ones.
    pub(crate) fn parents(self, seed: u64, count: usize) -> Result<Vec<Genome>> {
        let output = Some(Output::saturation(SATURATION)?);
        let models = || {
            let random = Variation::random(Start::Models.dialect()).with_output(output);
            (0..).map(move |slot| random.birth(BirthKey { seed, slot, attempt: 0 }))
        };
        match self {
            Self::Wild => Ok(visible_genomes(seed)?.take(count).collect()),
            Self::Believable | Self::Painted => {
                let start = self.start();
                let random = Variation::random(start.dialect()).with_start(start);
                let births = (0..).map(|slot| random.birth(BirthKey { seed, slot, attempt: 0 }));
                Ok(births.filter(is_visible).take(count).collect())
            }
            Self::Models => Ok(models().filter(is_visible).take(count).collect()),
            Self::Layers => {
                let mut visible = models().filter(is_visible);
                let mut layered = Vec::with_capacity(count);
                for _ in 0..count {
                    let layers = visible.by_ref().take(3).map(|one| one.layers()[0].clone());
                    layered.push(with_layers(None, layers.collect())?);
                }
                Ok(layered)
            }
            Self::Layered => {
                let layers = models().filter(is_visible).map(|one| vec![one.layers()[0].clone()]);
                let pairs = visible_genomes(seed)?.zip(layers).take(count);
                pairs.map(|(program, layers)| with_layers(Some(&program), layers)).collect()
            }
        }
    }
}

/// Genome of a program, if one is given, and layers.
fn with_layers(program: Option<&Genome>, layers: Vec<brood_genome::Model>) -> Result<Genome> {
    let Some(program) = program else {
        return Genome::of_models(layers).context("put models into layers");
    };
    let (dialect, output): (Dialect, Output) = (*program.dialect(), *program.output());
    let instructions = program.instructions().to_vec();
    let constants = Box::new(*program.constants());
    Genome::layered(dialect, instructions, constants, output, layers)
        .context("put a model onto a program")
}

/// Runs the command.
pub fn run(args: &BenchAmountArgs, json: bool) -> Result<()> {
    let folder = args.common.start()?;
    let of_seed = |seed| Ok(vec![of_seed(args, seed)?]);
    let finding = args.seeds.measure(args.common.seed, false, of_seed)?.remove(0);
    folder.finish(finding, json)
}

fn of_seed(args: &BenchAmountArgs, seed: u64) -> Result<Finding> {
    let kinds = args.kind.map_or(Kind::ALL.to_vec(), |kind| vec![kind]);
    let bar = output::bar(kinds.len() as u64 * u64::from(args.count), "breeding and comparing");
    let mut effects = Vec::new();
    for kind in kinds {
        // One extra, so that a single parent has a mate.
        let parents = kind.parents(seed, args.count as usize + 1)?;
        let measured: Vec<Measured> = (0..args.count as usize)
            .into_par_iter()
            .map(|number| {
                let mate = &parents[(number + 1) % parents.len()];
                let key = BirthKey { seed, slot: number as u32, attempt: 1 };
                let found = distances(args, kind, [&parents[number], mate], key);
                bar.inc(1);
                found
            })
            .collect::<Result<_>>()?;
        let unrelated: Vec<Distance> = measured.iter().map(|one| one.unrelated).collect();
        let names = [
            ("mutation", "the parent"),
            ("recombination", "the first parent"),
            ("recombination", SECOND_PARENT),
        ];
        for (index, (name, from)) in names.into_iter().enumerate().take(kind.effects()) {
            let of_amount = |amount: usize| {
                measured.iter().map(|one| one.effects[index][amount]).collect::<Vec<_>>()
            };
            let distances = (0..AMOUNTS.len()).map(of_amount).collect();
            effects.push(Effect { kind, name, from, distances, unrelated: mean(&unrelated) });
        }
    }
    bar.finish_and_clear();
    let amounts = if args.operators { "amounts of the operators" } else { "visible amounts" };
    Ok(Finding {
        name: "amount",
        note: format!(
            "{} random parents of each kind, none black; one child of each at each amount, without \
             redraws; {amounts} of mutation; mean FLIP (0 same, 1 opposite) and Delta E_ITP (1 just \
             visible) over the object at {} pixels with automatic exposure, mean of the default \
             light and one {OTHER_LIGHT_DEG} degrees on; `unrelated` is the mean between two \
             parents. A larger amount should increase the mean from the parent and from the first \
             parent, and decrease that from the second; `against` is 1 where it does not",
            args.count, args.size,
        ),
        table: table(&effects),
        raw: None,
        chart: chart(&effects, args).into(),
    })
}

impl Kind {
    /// Number of measured effects: recombination is measured for random programs.
    fn effects(self) -> usize {
        if self == Self::Wild { 3 } else { 1 }
    }
}

/// Distances of each mutant from its parent, and of each child of two from its first and second
/// parent, by amount.
fn distances(
    args: &BenchAmountArgs,
    kind: Kind,
    [parent, mate]: [&Genome; 2],
    key: BirthKey,
) -> Result<Measured> {
    let scale = if args.operators { MutationScale::Operators } else { MutationScale::Visible };
    let mutant = |amount: &f32| {
        Variation::mutate(parent, *amount).with_start(kind.start()).with_scale(scale).birth(key)
    };
    let child = |amount: &f32| Variation::crossover(parent, mate, *amount, 0.0).birth(key);
    let mut genomes = vec![parent.clone(), mate.clone()];
    genomes.extend(AMOUNTS.iter().map(mutant));
    if kind.effects() > 1 {
        genomes.extend(AMOUNTS.iter().map(child));
    }
    let programs: Vec<Program> = genomes.iter().map(Program::lower).collect();
    let programs: Vec<&Program> = programs.iter().collect();
    let renderer = Renderer::new(Backend::Cpu);
    let default = Scene::default();
    let other = default.with_light_deg(default.light_deg + OTHER_LIGHT_DEG);
    let mut lights = Vec::new();
    for scene in [&default, &other] {
        lights.push(PictureSet::on(&renderer, (scene, BuiltinMesh::Sphere), &programs, args.size)?);
    }
    let between = |one: usize, other: usize| {
        let of =
            |set: &PictureSet| Distance { flip: set.flip(one, other), itp: set.itp(one, other) };
        mean(&lights.iter().map(of).collect::<Vec<_>>())
    };
    let count = AMOUNTS.len();
    let origins = [(0, 2), (0, 2 + count), (1, 2 + count)];
    let from = |(origin, first): (usize, usize)| -> Vec<Distance> {
        (first..first + count).map(|one| between(origin, one)).collect()
    };
    let effects = origins.into_iter().take(kind.effects()).map(from).collect();
    Ok(Measured { effects, unrelated: between(0, 1) })
}

fn table(effects: &[Effect]) -> ResultTable {
    let mut table = ResultTable::default();
    for effect in effects {
        let means = effect.means();
        for (index, (amount, distances)) in AMOUNTS.iter().zip(&effect.distances).enumerate() {
            let share = |share| quantile(distances.iter().map(|one| one.flip), share);
            let (before, mean) = (means[index.saturating_sub(1)], means[index]);
            let is_against = if effect.from == SECOND_PARENT {
                mean.flip > before.flip
            } else {
                mean.flip < before.flip || mean.itp < before.itp
            };
            table.push(cells! {
                kind: effect.kind.name(),
                knob: effect.name,
                value: f64::from(*amount),
                from: effect.from,
                mean: mean.flip,
                against: u32::from(is_against),
                p10: share(0.1),
                median: share(0.5),
                p90: share(0.9),
                itp: mean.itp,
                unrelated: effect.unrelated.flip,
                unrelated_itp: effect.unrelated.itp,
            });
        }
    }
    table
}

fn chart(effects: &[Effect], args: &BenchAmountArgs) -> Plot {
    let series = |effect: &Effect| {
        let point = |(amount, y): (&f32, Distance)| Point {
            x: (*amount).into(),
            y: y.flip,
            ..Point::default()
        };
        let points = AMOUNTS.iter().zip(effect.means()).map(point);
        let name = match effect.name {
            "mutation" => format!("mutation, {}", effect.kind.name()),
            name => format!("{name}, from {}", effect.from),
        };
        Series::dotted(&name, points)
    };
    Plot {
        title: "Change of pictures by amount".to_owned(),
        subtitle: format!("{} random parents; first draws, {} pixels", args.count, args.size),
        x: Axis::linear("amount"),
        y: Axis::linear("mean FLIP over the object"),
        series: effects.iter().map(series).collect(),
    }
}
