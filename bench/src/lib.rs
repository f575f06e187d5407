//! `brood bench`: benchmarks of the server, the evaluators and the searches, as a user meets them.
//!
//! [`run`] runs one benchmark. It starts the current binary again as `brood bench` and as
//! `brood serve`, so only the binary `brood` can call it. The public modules are shared with the
//! other commands of that binary.
//!
//! ```
//! use brood_bench::chart::{Axis, Plot, Point, Series};
//!
//! let points = [(1.0, 0.1), (4.0, 0.03)].map(|(x, y)| Point { x, y, ..Point::default() });
//! let plot = Plot {
//!     title: "Error of a picture".to_owned(),
//!     subtitle: "one sphere".to_owned(),
//!     x: Axis::log("time, ms"),
//!     y: Axis::log("RMSE"),
//!     series: vec![Series::dotted("adaptive", points.into_iter())],
//! };
//! assert!(plot.svg().starts_with("<svg"));
//! ```

mod all;
mod amount;
mod api;
mod breed;
mod brood;
pub mod budget;
pub mod chart;
mod chart_file;
mod consumer;
mod derivative;
mod export;
mod fit;
mod fitness;
mod flip;
mod frame;
pub mod genome_file;
mod inverse;
pub mod logging;
pub mod material_file;
mod measure;
mod model;
mod ops;
pub mod output;
mod own_server;
pub mod painting_file;
mod pareto;
mod picture;
mod published;
mod record;
mod skip;
mod start;
mod stress;
mod style;
mod target;
mod throughput;

use anyhow::Result;
pub use brood::steer_word;
use clap::Subcommand;

/// Subcommands of `brood bench`.
#[derive(Debug, Subcommand)]
pub enum BenchCommand {
    /// Run every benchmark and write all results, with a description of the machine, into one
    /// folder
    All(all::BenchAllArgs),
    /// Measure how far pictures change at each amount of mutation and recombination, with a chart
    Amount(amount::BenchAmountArgs),
    /// Time from the request for a brood to the last byte of all its thumbnails, over HTTP
    Breed(breed::BenchBreedArgs),
    /// Count the useful pictures of a brood under each kind of curation
    Brood(brood::BenchBroodArgs),
    /// Draw series of points, as a JSON file gives them, as a chart
    Chart(chart_file::BenchChartArgs),
    /// Write materials in an export format with values of f, for a test by the program that reads
    /// the format
    Consumer(consumer::BenchConsumerArgs),
    /// Time the normal equations of a program's constants, in forward and reverse mode, against
    /// plain evaluation
    Derivative(derivative::BenchDerivativeArgs),
    /// Write a page that runs exported programs in a browser and compares their bits with the
    /// canonical ones
    Export(export::BenchExportArgs),
    /// Fit measured materials within time budgets and compare the errors with published fits
    Fit(fit::BenchFitArgs),
    /// Count genomes scored against a target per second, lowering included
    Fitness(fitness::BenchFitnessArgs),
    /// Time new materials on a known scene, in memory: lowering, evaluation, film, PNG
    Frame(frame::BenchFrameArgs),
    /// Recover known kinds of material from one picture, from random starts
    Inverse(inverse::BenchInverseArgs),
    /// Time the reflectance models and check them at hard parameters and directions
    Model(model::BenchModelArgs),
    /// Count scalar operations per second on one core, at every instruction set level
    Ops(ops::BenchOpsArgs),
    /// Sweep each quality setting and chart run time against error
    Pareto(pareto::BenchParetoArgs),
    /// Time each optimisation that skips work, with it and without it
    Skip(skip::BenchSkipArgs),
    /// Measure the first broods of lineages by their start, and those after some generations
    Start(start::BenchStartArgs),
    /// Run random programs on extreme directions: non-finite results, differing bits, error of f32
    Stress(stress::BenchStressArgs),
    /// Time painted materials on new and known scenes, in memory, with their errors
    Style(style::BenchStyleArgs),
    /// Count broods per second of many clients at running servers, with workers that sleep
    Throughput(throughput::BenchThroughputArgs),
}

/// Runs the command.
///
/// # Errors
/// Returns the error of the benchmark.
pub fn run(command: &BenchCommand, json: bool) -> Result<()> {
    match command {
        BenchCommand::All(args) => all::run(args, json),
        BenchCommand::Amount(args) => amount::run(args, json),
        BenchCommand::Breed(args) => breed::run(args, json),
        BenchCommand::Brood(args) => brood::run(args, json),
        BenchCommand::Chart(args) => chart_file::run(args, json),
        BenchCommand::Consumer(args) => consumer::run(args, json),
        BenchCommand::Derivative(args) => derivative::run(args, json),
        BenchCommand::Export(args) => export::run(args, json),
        BenchCommand::Fit(args) => fit::run(args, json),
        BenchCommand::Fitness(args) => fitness::run(args, json),
        BenchCommand::Frame(args) => frame::run(args, json),
        BenchCommand::Inverse(args) => inverse::run(args, json),
        BenchCommand::Model(args) => model::run(args, json),
        BenchCommand::Ops(args) => ops::run(args, json),
        BenchCommand::Pareto(args) => pareto::run(args, json),
        BenchCommand::Skip(args) => skip::run(args, json),
        BenchCommand::Start(args) => start::run(args, json),
        BenchCommand::Stress(args) => stress::run(args, json),
        BenchCommand::Style(args) => style::run(args, json),
        BenchCommand::Throughput(args) => throughput::run(args, json),
    }
}
