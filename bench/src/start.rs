//! `brood bench start`: measures the first brood of lineages of each start, and their brood after
//! some generations with random parents.
//!
//! Saturation, curation `diverse` and the environment are those of the page.

use anyhow::Result;
use brood_eval::{diverse_brood, energy_limit, express_brood};
use brood_genome::preset::PRESETS;
use brood_genome::{BirthKey, Dialect, Genome, Operator, Output, Start, Stream, Variation};
use brood_mesh::BuiltinMesh;
use brood_program::{BroodRequest, Child, Program};
use brood_protocol::Backend;
use brood_scene::{MeshRef, Scene};
use brood_worker::Renderer;
use clap::Args;
use serde::Serialize;
use serde_json::json;

use super::flip::PictureSet;
use crate::{logging, output};

/// Options of `brood bench start`.
#[derive(Debug, Args)]
pub struct BenchStartArgs {
    /// Number of lineages of each start
    #[arg(long, value_name = "N", default_value_t = 20, value_parser = clap::value_parser!(u32).range(1..=1000))]
    count: u32,
    /// Number of generations after the first brood
    #[arg(long, value_name = "N", default_value_t = 3, value_parser = clap::value_parser!(u32).range(1..=100))]
    generations: u32,
    /// Amount of mutation, 0 to 1
    #[arg(long, value_name = "X", default_value_t = 0.3)]
    mutation: f32,
    /// Side of the pictures in pixels
    #[arg(long, value_name = "N", default_value_t = 64, value_parser = clap::value_parser!(u32).range(16..=256))]
    size: u32,
    /// Seed of the first lineage
    #[arg(long, default_value_t = 1)]
    seed: u64,
}

/// Number of children of a brood.
const CHILDREN: u32 = 20;
/// Saturation of random programs and models on the page.
const SATURATION: f32 = 0.65;
/// Largest albedo that counts as within the limit; its search reports a bound up to this above 1.
const TOLERATED: f64 = 1.001;

/// Content of first broods.
#[derive(Debug, Clone, Copy, PartialEq)]
enum First {
    /// Random children of a start.
    Random(Start),
    /// Isotropic homogeneous believable programs, with which the page begins.
    Even,
    /// Presets, without repetition.
    Presets,
}

/// Shares and spread of the broods of one start in one generation.
#[derive(Debug, Serialize)]
struct Figures {
    start: &'static str,
    generation: u32,
    /// Share of individuals with a largest albedo above 1, as rendered.
    above_1: f64,
    /// Share of pictures of which more than half of the object is black.
    dark: f64,
    /// Mean over the broods of the mean FLIP of all pairs of pictures.
    spread: f64,
}

/// Runs the command.
pub fn run(args: &BenchStartArgs, json: bool) -> Result<()> {
    logging::start_offline();
    let firsts = [
        First::Even,
        First::Random(Start::Believable),
        First::Random(Start::Models),
        First::Presets,
        First::Random(Start::Wild),
    ];
    let bar = output::bar(firsts.len() as u64 * u64::from(args.count), "lineages");
    let light = json!({"kind": "environment", "image": "studio"});
    let mesh = BuiltinMesh::Ball;
    let scene = Scene {
        mesh: MeshRef::Builtin(mesh),
        lights: vec![serde_json::from_value(light)?],
        ..Scene::default()
    };
    let renderer = Renderer::new(Backend::Cpu);
    let mut all = Vec::new();
    for first in firsts {
        let mut found = [Sums::default(), Sums::default()];
        for index in 0..u64::from(args.count) {
            let seed = args.seed.wrapping_add(1000 * index);
            let broods = lineage(args, first, seed);
            for (sums, brood) in found.iter_mut().zip(&broods) {
                let programs: Vec<&Program> = brood.iter().map(|child| &child.program).collect();
                let pictures = PictureSet::on(&renderer, (&scene, mesh), &programs, args.size)?;
                sums.add(brood, &pictures);
            }
            bar.inc(1);
        }
        for (generation, sums) in [0, args.generations].into_iter().zip(found) {
            all.push(sums.figures(first.name(), generation, args.count));
        }
    }
    bar.finish_and_clear();
    if json {
        return output::print_json(&all);
    }
    let mut text = format!(
        "{} lineages of each start, broods of {CHILDREN}, mutation {}, curation diverse, a random child as the parent; ball \
         under the environment studio, {} pixels. above 1: individuals with a largest albedo above {TOLERATED}, as rendered; \
         dark: pictures of which more than half of the object is black; spread: mean FLIP between the pictures of a brood\n\
         start             generation  above 1     dark  spread\n",
        args.count, args.mutation, args.size
    );
    for f in &all {
        text += &format!(
            "{:<16}  {:>10}  {:>5.1} %  {:>4.1} %  {:>6.3}\n",
            f.start,
            f.generation,
            100.0 * f.above_1,
            100.0 * f.dark,
            f.spread
        );
    }
    output::print(&text)
}

impl First {
    fn name(self) -> &'static str {
        match self {
            Self::Random(start) => start.name(),
            Self::Even => "believable, even",
            Self::Presets => "presets",
        }
    }

    fn start(self) -> Start {
        match self {
            Self::Random(start) => start,
            Self::Even => Start::Believable,
            Self::Presets => Start::Wild,
        }
    }

    /// First brood.
    fn brood(self, seed: u64) -> Vec<Genome> {
        match self {
            Self::Random(start) => {
                let random = Variation::random(start.dialect()).with_start(start);
                let variation = match start {
                    Start::Believable | Start::Painted => random,
                    Start::Models | Start::Wild => {
                        random.with_output(Output::saturation(SATURATION).ok())
                    }
                };
                genomes(bred(variation, seed))
            }
            Self::Even => {
                let dialect = Start::Believable.dialect();
                let even = Dialect { isotropic: true, homogeneous: true, ..dialect };
                genomes(bred(Variation::random(even).with_start(Start::Believable), seed))
            }
            Self::Presets => {
                let presets = PRESETS.iter().map(|preset| preset.genome());
                let length = Dialect::default().length;
                let padded =
                    presets.filter(|genome| fits(genome.dialect()) && !genome.is_painted());
                let padded = padded.filter_map(|genome| genome.clone().padded(length).ok());
                padded.take(CHILDREN as usize).collect()
            }
        }
    }
}

/// True if the page puts a preset of this dialect into a new lineage.
fn fits(own: &Dialect) -> bool {
    own.is_compatible(&Dialect { length: own.length, ..Dialect::default() })
}

/// First brood and the one after all generations, as rendered.
fn lineage(args: &BenchStartArgs, first: First, seed: u64) -> [Vec<Child>; 2] {
    let mut stream = Stream::new(BirthKey { seed, slot: 0, attempt: 0 }, Operator::Shuffle);
    let mut brood = first.brood(seed);
    let begun = express_brood(children(&brood));
    let mut last = Vec::new();
    for generation in 1..=u64::from(args.generations) {
        let parent = brood[stream.below(brood.len() as u32) as usize].clone();
        let variation = Variation::mutate(&parent, args.mutation).with_start(first.start());
        last = bred(variation, seed + generation);
        brood = genomes(last.clone());
    }
    [begun, express_brood(last)]
}

fn bred(variation: Variation<'_>, seed: u64) -> Vec<Child> {
    diverse_brood(&BroodRequest { variation, count: CHILDREN, seed, distinct: true })
}

fn genomes(brood: Vec<Child>) -> Vec<Genome> {
    brood.into_iter().map(|child| child.genome).collect()
}

/// Children with the programs of these genomes.
fn children(genomes: &[Genome]) -> Vec<Child> {
    let child = |(slot, genome): (u32, &Genome)| {
        let program = Program::lower(genome);
        Child {
            slot,
            hash: genome.hash(),
            program_hash: program.hash(),
            live_instructions: 0,
            attempts: 1,
            twin: false,
            genome: genome.clone(),
            program,
        }
    };
    (0..).zip(genomes).map(child).collect()
}

/// Counts over the broods of one start.
#[derive(Default)]
struct Sums {
    individuals: usize,
    above: usize,
    dark: usize,
    spread: f64,
}

impl Sums {
    fn add(&mut self, brood: &[Child], pictures: &PictureSet) {
        self.individuals += brood.len();
        let above = |child: &&Child| energy_limit(&child.program).albedo > TOLERATED;
        self.above += brood.iter().filter(above).count();
        self.dark += (0..pictures.len()).filter(|one| pictures.black(*one) > 0.5).count();
        self.spread += pictures.spread();
    }

    fn figures(self, start: &'static str, generation: u32, lineages: u32) -> Figures {
        let share = |count: usize| count as f64 / self.individuals as f64;
        Figures {
            start,
            generation,
            above_1: share(self.above),
            dark: share(self.dark),
            spread: self.spread / f64::from(lineages),
        }
    }
}
