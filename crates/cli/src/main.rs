//! The `brood` binary: one command line over the server, the worker and the libraries.
//!
//! This file owns the list of commands and the exit codes: 0 success, 1 failure with one line on
//! stderr, 2 bad usage. Each command is implemented in the module of its name.

mod backup;
mod breed;
mod check;
mod compact;
mod compare;
mod dialect;
mod diff;
mod eval;
mod evolve;
mod export;
mod fit;
mod frame;
mod front;
mod gallery;
mod image_file;
mod inspect;
mod light_file;
mod lock;
mod mesh;
mod migrate;
mod model;
mod object_file;
mod palette;
mod place;
mod preset;
mod render;
mod secret;
mod serve;
mod supervisor;
mod token;
mod worker;

use std::process::ExitCode;

use brood_bench::BenchCommand;
use clap::{Parser, Subcommand};

/// musl's own allocator costs a third of the processor time of a brood's pictures.
#[cfg(target_env = "musl")]
#[global_allocator]
static ALLOCATOR: mimalloc::MiMalloc = mimalloc::MiMalloc;

/// Evolves materials by eye, by script and by search. Without a command it runs `serve`.
#[derive(Parser)]
#[command(name = "brood", version = env!("BROOD_VERSION"), args_conflicts_with_subcommands = true)]
struct Cli {
    #[command(subcommand)]
    command: Option<Command>,
    #[command(flatten)]
    serve: serve::ServeArgs,
    /// Print JSON instead of text
    #[arg(long, global = true)]
    json: bool,
}

#[derive(Subcommand)]
enum Command {
    /// Serve the page and the API, with its own worker processes (the default command)
    Serve(serve::ServeArgs),
    /// Render, or search, for a server
    Worker(worker::WorkerArgs),
    /// Create, list and revoke tokens
    #[command(subcommand)]
    Token(token::TokenCommand),
    /// Copy the database into one file
    Backup(backup::BackupArgs),
    /// Check the database, all genomes and the cached pictures for damage
    Check(check::CheckArgs),
    /// Make the database smaller: packs genomes of earlier versions, gives free pages back
    Compact(compact::CompactArgs),
    /// Copy the database of a data directory into PostgreSQL
    Migrate(migrate::MigrateArgs),
    /// Breed a brood without a server
    Breed(breed::BreedArgs),
    /// Print the colours of a picture by regions, for `breed --painting`
    Palette(palette::PaletteArgs),
    /// Print the hashes by which painted genomes name control images
    Image(image_file::ImageArgs),
    /// Render a material into a PNG or EXR file
    Render(render::RenderArgs),
    /// Print the reflectance of a material for pairs of directions
    Eval(eval::EvalArgs),
    /// Search for a material that matches a measured one or pictures
    Fit(fit::FitArgs),
    /// Breed against your own fitness measure: writes genomes to standard output, reads their
    /// errors from standard input
    Evolve(evolve::EvolveArgs),
    /// Write a material for other programs: code, plugins, tables
    Export(export::ExportArgs),
    /// Write a mesh with tangents as glTF, for renderers that use exported materials
    Mesh(mesh::MeshArgs),
    /// Show the contents of a genome and check its physics
    Inspect(inspect::InspectArgs),
    /// List the preset materials, or print one
    Preset(preset::PresetArgs),
    /// List reflectance models, print one, or measure an albedo
    #[command(subcommand)]
    Model(model::ModelCommand),
    /// Compare materials in one scene: pictures, differences and physical measures
    Compare(compare::CompareArgs),
    /// Print the difference of two pictures
    Diff(diff::DiffArgs),
    /// Run benchmarks
    #[command(subcommand)]
    Bench(BenchCommand),
}

fn main() -> ExitCode {
    let cli = Cli::parse();
    let command = cli.command.unwrap_or(Command::Serve(cli.serve));
    let result = match command {
        Command::Serve(args) => serve::run(&args, cli.json),
        Command::Worker(args) => worker::run(args),
        Command::Token(command) => token::run(&command, cli.json),
        Command::Backup(args) => backup::run(&args, cli.json),
        Command::Check(args) => check::run(&args, cli.json),
        Command::Compact(args) => compact::run(&args, cli.json),
        Command::Migrate(args) => migrate::run(&args, cli.json),
        Command::Breed(args) => breed::run(&args, cli.json),
        Command::Palette(args) => palette::run(&args, cli.json),
        Command::Image(args) => image_file::run(&args, cli.json),
        Command::Render(args) => render::run(&args, cli.json),
        Command::Eval(args) => eval::run(&args, cli.json),
        Command::Fit(args) => fit::run(&args, cli.json),
        Command::Evolve(args) => evolve::run(&args),
        Command::Export(args) => export::run(&args, cli.json),
        Command::Mesh(args) => mesh::run(&args, cli.json),
        Command::Inspect(args) => inspect::run(&args, cli.json),
        Command::Preset(args) => preset::run(&args, cli.json),
        Command::Model(command) => model::run(&command, cli.json),
        Command::Compare(args) => compare::run(&args, cli.json),
        Command::Diff(args) => diff::run(&args, cli.json),
        Command::Bench(command) => brood_bench::run(&command, cli.json),
    };
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {}", one_line(&error));
            ExitCode::FAILURE
        }
    }
}

/// The error and its causes in one line; a cause already quoted by the text before is skipped.
fn one_line(error: &anyhow::Error) -> String {
    let mut line = String::new();
    for cause in error.chain() {
        let text = cause.to_string().split_whitespace().collect::<Vec<_>>().join(" ");
        if !line.contains(&text) {
            line += if line.is_empty() { "" } else { ": " };
            line += &text;
        }
    }
    line
}

#[cfg(test)]
mod tests {
    use anyhow::Context;
    use clap::CommandFactory;

    use super::*;

    #[test]
    fn command_line_is_consistent() {
        Cli::command().debug_assert();
    }

    #[test]
    fn serve_is_the_command_when_none_is_given() {
        let cli = Cli::try_parse_from(["brood"]).unwrap();
        assert!(cli.command.is_none());
        assert_eq!(cli.serve.listen.to_string(), "127.0.0.1:7320");
        let cli = Cli::try_parse_from(["brood", "--listen", "127.0.0.1:0"]).unwrap();
        assert_eq!(cli.serve.listen.port(), 0);
    }

    #[test]
    fn cause_is_printed_once_when_the_error_quotes_it() {
        let cause = std::io::Error::other("the disk\nis gone");
        let quoting = anyhow::Error::from(cause).context("write x: the disk is gone");
        assert_eq!(one_line(&quoting), "write x: the disk is gone");
        let plain = Err::<(), _>(std::io::Error::other("why")).context("write x").unwrap_err();
        assert_eq!(one_line(&plain), "write x: why");
    }

    #[test]
    fn json_flag_is_accepted_after_any_command() {
        let cli = Cli::try_parse_from(["brood", "inspect", "x.brood", "--json"]).unwrap();
        assert!(cli.json);
    }
}
