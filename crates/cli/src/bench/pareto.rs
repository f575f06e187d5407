//! Run time against error: each choice of the product swept, with what is gained and what is lost, as a chart.
//!
//! Every default of the product is a point on one of these fronts and is marked there. Errors are against the f64
//! reference or the finest setting; each finding says what bounds the error of that yardstick itself.

mod albedo;
mod backend;
mod lambert;
mod lights;
mod limit;
mod precision;
mod prefix;
mod samples;

use std::path::PathBuf;

use anyhow::Result;
use clap::{Args, ValueEnum};

use super::record::{Finding, Findings, Folder};
use crate::{logging, output};

/// Options of `brood bench pareto`.
#[derive(Debug, Args)]
pub struct BenchParetoArgs {
    /// Folder for pareto.json and a CSV and an SVG of each sweep
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// One scene instead of all sweeps
    #[arg(long, value_name = "NAME")]
    scene: Option<SceneName>,
    /// One sweep instead of all
    #[arg(long, value_name = "NAME", conflicts_with = "scene")]
    sweep: Option<Sweep>,
    /// Small and quick: shows that it works, not what is true
    #[arg(long)]
    short: bool,
    /// Measure the GPU too, also one in software
    #[arg(long)]
    gpu: bool,
    /// Seed of the genomes
    #[arg(long, default_value_t = 1)]
    seed: u64,
}

/// Scenes that stand for themselves.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum SceneName {
    /// The unit sphere with f = 1 / pi, seen in parallel, lit from far away
    LambertSphere,
}

/// What is swept.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Sweep {
    /// Samples a pixel
    Samples,
    /// f32 against f64
    Precision,
    /// Order of the quadrature of the directional albedo
    Albedo,
    /// Effort of the search for the largest directional albedo
    Limit,
    /// Samples by which candidates are ranked
    Prefix,
    /// Samples of lights that have extent
    Lights,
    /// What evaluates
    Backend,
}

/// Runs the command.
pub fn run(args: &BenchParetoArgs, json: bool) -> Result<()> {
    logging::start_offline();
    let folder = Folder::make(args.out.as_deref())?;
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
    let BenchParetoArgs { short, seed, .. } = *args;
    Ok(match sweep {
        Sweep::Samples => samples::measure(short, seed)?,
        Sweep::Precision => vec![precision::measure(short, seed)?],
        Sweep::Albedo => vec![albedo::measure(short, seed)?],
        Sweep::Limit => vec![limit::measure(short, seed)?],
        Sweep::Prefix => vec![prefix::measure(short, seed)?],
        Sweep::Lights => lights::measure(short)?,
        Sweep::Backend => vec![backend::measure(short, seed, args.gpu)?],
    })
}
