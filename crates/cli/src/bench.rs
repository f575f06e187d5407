//! `brood bench`: measurements of the whole road, as a user meets it.

mod breed;
mod ops;
mod own_server;
mod stress;

use anyhow::Result;
use clap::Subcommand;

/// What is measured.
#[derive(Debug, Subcommand)]
pub enum BenchCommand {
    /// From the request for a brood to the last byte of all its thumbnails, over HTTP
    Breed(breed::BenchBreedArgs),
    /// Scalar operations a second on one core, at every level of vector instructions
    Ops(ops::BenchOpsArgs),
    /// Random programs on directions that break formulas: anything not finite, any bit that differs, the error of f32
    Stress(stress::BenchStressArgs),
}

/// Runs the command.
pub fn run(command: &BenchCommand, json: bool) -> Result<()> {
    match command {
        BenchCommand::Breed(args) => breed::run(args, json),
        BenchCommand::Ops(args) => ops::run(args, json),
        BenchCommand::Stress(args) => stress::run(args, json),
    }
}
