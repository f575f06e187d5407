//! `brood bench`: measurements of the whole road, as a user meets it.

mod all;
mod amount;
mod breed;
mod brood;
mod derivative;
mod export;
mod fit;
mod fitness;
mod flip;
mod frame;
mod inverse;
mod measure;
mod model;
mod ops;
mod own_server;
mod pareto;
mod picture;
mod record;
mod skip;
mod stress;
mod target;

use anyhow::Result;
use clap::Subcommand;

/// What is measured.
#[derive(Debug, Subcommand)]
pub enum BenchCommand {
    /// Every benchmark in turn, into one folder with the machine it ran on
    All(all::BenchAllArgs),
    /// What the amounts of mutation and recombination do to pictures, with a chart
    Amount(amount::BenchAmountArgs),
    /// From the request for a brood to the last byte of all its thumbnails, over HTTP
    Breed(breed::BenchBreedArgs),
    /// How many frames of a brood are worth looking at, with each kind of curation
    Brood(brood::BenchBroodArgs),
    /// Normal equations of constants, forwards and backwards, beside plain evaluation
    Derivative(derivative::BenchDerivativeArgs),
    /// A page that holds exported programs, run by a browser, against the bits they must have
    Export(export::BenchExportArgs),
    /// Fits of measured materials after some seconds, beside published ones
    Fit(fit::BenchFitArgs),
    /// Genomes a second against a target, everything included
    Fitness(fitness::BenchFitnessArgs),
    /// New materials on a known scene, in memory: lowered, evaluated, developed, encoded
    Frame(frame::BenchFrameArgs),
    /// Known kinds of material recovered from one picture, from random starts
    Inverse(inverse::BenchInverseArgs),
    /// Models of reflectance: time a sample, and what breaks on hard parameters and directions
    Model(model::BenchModelArgs),
    /// Scalar operations a second on one core, at every level of vector instructions
    Ops(ops::BenchOpsArgs),
    /// Run time against error: each choice of the product swept, with charts
    Pareto(pareto::BenchParetoArgs),
    /// What each kind of skipping is worth, measured with it and without
    Skip(skip::BenchSkipArgs),
    /// Random programs on directions that break formulas: anything not finite, any bit that differs, the error of f32
    Stress(stress::BenchStressArgs),
}

/// Runs the command.
pub fn run(command: &BenchCommand, json: bool) -> Result<()> {
    match command {
        BenchCommand::All(args) => all::run(args, json),
        BenchCommand::Amount(args) => amount::run(args, json),
        BenchCommand::Breed(args) => breed::run(args, json),
        BenchCommand::Brood(args) => brood::run(args, json),
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
        BenchCommand::Stress(args) => stress::run(args, json),
    }
}
