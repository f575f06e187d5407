//! `brood bench frame`: times new materials on a known scene, in memory, with all the steps of a
//! worker: lowering, evaluation, shading, film and PNG.

use std::time::Instant;

use anyhow::{Context, Result, ensure};
use brood_genome::{BirthKey, Dialect, Genome, Variation};
use brood_light::BuiltinEnvironment;
use brood_mesh::BuiltinMesh;
use brood_program::Program;
use brood_protocol::{Backend, Frame, MeshSource, PictureFormat};
use brood_scene::{MeshRef, Sampling, Scene};
use brood_worker::Renderer;
use clap::Args;
use serde::Serialize;
use serde_json::json;

use super::measure::{median, quantile};
use super::record::CommonArgs;
use crate::output;

/// Options of `brood bench frame`.
#[derive(Debug, Args)]
pub struct BenchFrameArgs {
    /// Number of materials, one picture each
    #[arg(long, value_name = "N", default_value_t = 20, value_parser = clap::value_parser!(u32).range(1..=1000))]
    programs: u32,
    /// Side of a picture in pixels; 128 and 256 by default
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(16..=1024))]
    size: Option<u32>,
    /// Number of runs, each with other materials
    #[arg(long, value_name = "N", default_value_t = 200, value_parser = clap::value_parser!(u32).range(1..=100_000))]
    repeats: u32,
    /// Samples per pixel: `adaptive` or a number; both `adaptive` and 1 by default
    #[arg(long, value_name = "N")]
    samples: Option<Sampling>,
    /// Built-in environment instead of the default point light
    #[arg(long, value_name = "NAME", value_parser = environment)]
    environment: Option<BuiltinEnvironment>,
    /// Built-in mesh
    #[arg(long, value_name = "NAME", default_value = "sphere", value_parser = mesh)]
    mesh: BuiltinMesh,
    /// Random models instead of random programs
    #[arg(long)]
    models: bool,
    /// Inputs of programs; by default `any` under the point light, `even` in an environment
    #[arg(long)]
    surface: Option<Surface>,
    #[command(flatten)]
    common: CommonArgs,
}

/// Inputs that random programs may read.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
enum Surface {
    /// Isotropic and homogeneous, as most models: environments are tabulated
    Even,
    /// Isotropic, with u and v
    Textured,
    /// All inputs
    Any,
}

impl BenchFrameArgs {
    /// Returns new materials.
    fn genomes(&self, seed: u64) -> Vec<Genome> {
        let default = if self.environment.is_some() { Surface::Even } else { Surface::Any };
        let surface = self.surface.unwrap_or(default);
        let length = if self.models { 0 } else { Dialect::default().length };
        let isotropic = surface != Surface::Any;
        let homogeneous = surface == Surface::Even;
        let dialect = Dialect { isotropic, homogeneous, length, ..Dialect::default() };
        let random = Variation::random(dialect);
        (0..self.programs).map(|slot| random.birth(BirthKey { seed, slot, attempt: 0 })).collect()
    }
}

fn environment(name: &str) -> Result<BuiltinEnvironment, String> {
    let names = BuiltinEnvironment::ALL.map(BuiltinEnvironment::name).join(", ");
    BuiltinEnvironment::from_name(name).ok_or_else(|| format!("must be one of {names}"))
}

fn mesh(name: &str) -> Result<BuiltinMesh, String> {
    let names = BuiltinMesh::ALL.map(BuiltinMesh::name).join(", ");
    BuiltinMesh::from_name(name).ok_or_else(|| format!("must be one of {names}"))
}

/// Times of all pictures at one size and sampling.
#[derive(Debug, Serialize)]
struct Row {
    size_px: u32,
    samples: Sampling,
    programs: u32,
    threads: usize,
    /// First materials, which make the sample set and the light of the view.
    first_ms: f64,
    /// Further materials.
    total_ms: Figures,
    /// Part of the total spent on lowering.
    lower_ms: Figures,
}

#[derive(Debug, Serialize)]
struct Figures {
    min: f64,
    median: f64,
    p99: f64,
}

/// Runs the command.
pub fn run(args: &BenchFrameArgs, json: bool) -> Result<()> {
    let folder = args.common.start()?;
    let renderer = Renderer::new(Backend::Cpu);
    let sizes = args.size.map_or(vec![128, 256], |size| vec![size]);
    let both = vec![Sampling::Adaptive, Sampling::Fixed(1)];
    let samplings = args.samples.map_or(both, |samples| vec![samples]);
    let mut rows = Vec::new();
    for size_px in sizes {
        for samples in &samplings {
            rows.push(measure(args, &renderer, size_px, *samples)?);
        }
    }
    folder.add_json("frame", &rows)?;
    if json {
        // A single row is printed as an object instead of a list, for scripts that ask for one.
        return match &rows[..] {
            [row] => output::print_json(&serde_json::to_value(row)?),
            rows => output::print_json(&serde_json::to_value(rows)?),
        };
    }
    let line = |row: &Row| {
        let Figures { min, median, p99 } = &row.total_ms;
        format!(
            "{} new materials at {} px, samples {:<8}, {} threads: min {min:.2} ms  median {median:.2} ms  p99 {p99:.2} ms  \
             (lowering {:.2} ms)  first {:.0} ms\n",
            row.programs,
            row.size_px,
            row.samples.to_string(),
            row.threads,
            row.lower_ms.median,
            row.first_ms
        )
    };
    output::print(&rows.iter().map(line).collect::<String>())
}

/// Times the materials at one size and sampling.
fn measure(
    args: &BenchFrameArgs,
    renderer: &Renderer,
    size_px: u32,
    samples: Sampling,
) -> Result<Row> {
    let mesh = renderer.builtin(args.mesh);
    let how = (PictureFormat::Png, Backend::Cpu);
    let mut scene = Scene { mesh: MeshRef::Builtin(args.mesh), ..Scene::default() };
    if let Some(environment) = args.environment {
        let light = json!({"kind": "environment", "image": environment.name()});
        scene.lights = vec![serde_json::from_value(light)?];
    }
    let frame = Frame::new(&scene, MeshSource::Builtin, size_px, samples, how);
    let (mut total, mut lowering) = (Vec::new(), Vec::new());
    let mut first_ms = 0.0;
    for round in 0..=args.repeats {
        let genomes = args.genomes(args.common.seed.wrapping_add(round.into()));
        let start = Instant::now();
        let programs: Vec<Program> = genomes.iter().map(Program::lower).collect();
        let lowered = start.elapsed().as_secs_f64() * 1e3;
        let all: Vec<&Program> = programs.iter().collect();
        let pictures = renderer.render(&frame, &mesh, &all).context("render")?;
        let elapsed = start.elapsed().as_secs_f64() * 1e3;
        ensure!(pictures.len() == all.len(), "expected one picture per material");
        if round == 0 {
            first_ms = elapsed;
        } else {
            total.push(elapsed);
            lowering.push(lowered);
        }
    }
    Ok(Row {
        size_px,
        samples,
        programs: args.programs,
        threads: rayon::current_num_threads(),
        first_ms,
        total_ms: figures(&total),
        lower_ms: figures(&lowering),
    })
}

fn figures(ms: &[f64]) -> Figures {
    Figures { min: quantile(ms, 0.0), median: median(ms), p99: quantile(ms, 0.99) }
}
