//! `brood bench pareto`: sweeps each quality setting and charts run time against error.
//!
//! Every default is marked as a point on one of these fronts. Errors are against the f64 reference
//! or the finest setting; each finding states the error of that reference.

mod albedo;
mod backend;
mod environment;
mod highlight;
mod lambert;
mod lights;
mod limit;
mod precision;
mod prefix;
mod rays;
mod samples;

use std::path::PathBuf;

use anyhow::Result;
use clap::{Args, ValueEnum};

use super::record::{CommonArgs, Finding, Findings, SeedsArgs};
use crate::output;

/// Options of `brood bench pareto`.
#[derive(Debug, Args)]
pub struct BenchParetoArgs {
    /// Run this scene instead of the sweeps
    #[arg(long, value_name = "NAME")]
    scene: Option<SceneName>,
    /// Run only this sweep
    #[arg(long, value_name = "NAME", conflicts_with = "scene")]
    sweep: Option<Sweep>,
    /// Folder with published fits of measured metals in tables/, for the sweep `rays`, and a mesh
    /// in meshes/, for the sweep `highlight`
    #[arg(long, value_name = "DIR")]
    data: Option<PathBuf>,
    /// Small, quick run that only shows that everything works
    #[arg(long)]
    short: bool,
    /// Measure the GPU too, even a software adapter
    #[arg(long)]
    gpu: bool,
    #[command(flatten)]
    seeds: SeedsArgs,
    #[command(flatten)]
    common: CommonArgs,
}

/// Scenes with a run of their own.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum SceneName {
    /// Unit sphere with f = 1 / pi, orthographic view, distant light
    LambertSphere,
}

/// Swept settings.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Sweep {
    /// Samples per pixel
    Samples,
    /// Every fixed number of rays per pixel
    Rays,
    /// Adaptive sampling of materials with narrow highlights
    Highlight,
    /// f32 against f64
    Precision,
    /// Order of the quadrature of the directional albedo
    Albedo,
    /// Effort of the search for the largest directional albedo
    Limit,
    /// Number of samples that rank candidates
    Prefix,
    /// Samples of lights with an extent
    Lights,
    /// Light from environments, prefiltered and sampled
    Environment,
    /// Evaluators: instruction sets, the f64 reference and the GPU
    Backend,
}

/// Runs the command.
pub fn run(args: &BenchParetoArgs, json: bool) -> Result<()> {
    let folder = args.common.start()?;
    if args.scene == Some(SceneName::LambertSphere) {
        return lambert::run(args.short, &folder, json);
    }
    let sweeps = match args.sweep {
        Some(sweep) => vec![sweep],
        None => Sweep::value_variants().to_vec(),
    };
    let mut findings = Vec::new();
    for sweep in sweeps {
        for finding in measure(sweep, args)? {
            folder.add(&finding)?;
            if !json {
                output::print(&finding.text())?;
            }
            findings.push(finding);
        }
    }
    folder.add_json("pareto", &Findings(&findings))?;
    if json { output::print_json(&Findings(&findings)) } else { Ok(()) }
}

fn measure(sweep: Sweep, args: &BenchParetoArgs) -> Result<Vec<Finding>> {
    let (short, data, first) = (args.short, args.data.as_deref(), args.common.seed);
    let of_each =
        |measure: &dyn Fn(u64) -> Result<Vec<Finding>>| args.seeds.measure(first, short, measure);
    Ok(match sweep {
        Sweep::Samples => of_each(&|seed| samples::measure(short, seed))?,
        Sweep::Precision => of_each(&|seed| Ok(vec![precision::measure(short, seed)?]))?,
        Sweep::Albedo => of_each(&|seed| Ok(vec![albedo::measure(short, seed)?]))?,
        Sweep::Prefix => of_each(&|seed| Ok(vec![prefix::measure(short, seed)?]))?,
        Sweep::Backend => of_each(&|seed| Ok(vec![backend::measure(short, seed, args.gpu)?]))?,
        Sweep::Rays => vec![rays::measure(short, &args.seeds.list(first, short), data)?],
        Sweep::Limit => vec![limit::measure(short, &args.seeds.list(first, short))?],
        // These draw nothing at random.
        Sweep::Highlight => vec![highlight::measure(short, data)?],
        Sweep::Lights => lights::measure(short)?,
        Sweep::Environment => environment::measure(short)?,
    })
}
