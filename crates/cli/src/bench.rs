//! `brood bench`: measurements of the whole road, as a user meets it.

mod breed;
mod own_server;

use anyhow::Result;
use clap::Subcommand;

/// What is measured.
#[derive(Debug, Subcommand)]
pub enum BenchCommand {
    /// From the request for a brood to the last byte of all its thumbnails, over HTTP
    Breed(breed::BenchBreedArgs),
}

/// Runs the command.
pub fn run(command: &BenchCommand, json: bool) -> Result<()> {
    match command {
        BenchCommand::Breed(args) => breed::run(args, json),
    }
}
