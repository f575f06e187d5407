//! `brood evolve`: breeds genomes against a fitness measure of another program. Each line of
//! standard output contains genomes to evaluate, each line of standard input their errors.
//!
//! Owns the line protocol and the files; breeding is done by the search crate.

use std::io::{self, BufRead, Read};
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail, ensure};
use brood_bench::{genome_file, logging, output};
use brood_genome::{Dialect, Genome};
use brood_program::Program;
use brood_search::{AskOptions, AskTell, Evaluated};
use brood_target::Strategy;
use clap::Args;
use serde::Deserialize;
use serde_json::{Value, json};

use crate::dialect::DialectWords;
use crate::front;

/// Largest length of an input line.
const LINE_BYTES: u64 = 1 << 20;
/// Largest size of a state file.
const STATE_BYTES: u64 = 256 << 20;

/// Options of `brood evolve`.
#[derive(Debug, Args)]
pub struct EvolveArgs {
    /// Genome to start from; may be given several times. By default the search starts from random
    /// genomes
    #[arg(long = "start", value_name = "GENOME")]
    pub start: Vec<PathBuf>,
    /// Dialect of random genomes, for example 'smooth registers 7'; by default that of searches
    #[arg(long, value_name = "WORDS", conflicts_with = "start")]
    pub dialect: Option<DialectWords>,
    /// Seed: equal seeds and errors give equal genomes
    #[arg(long, value_name = "S", default_value_t = 1)]
    pub seed: u64,
    /// Number of genomes per line of output
    #[arg(long, value_name = "N", default_value_t = 20, value_parser = clap::value_parser!(u32).range(1..=4096))]
    pub count: u32,
    /// Number of genomes kept to breed from
    #[arg(long, value_name = "N", default_value_t = 64, value_parser = clap::value_parser!(u16).range(2..=4096))]
    pub kept: u16,
    /// File of the search's state: resumes from it if it exists, and writes it after every line of
    /// input
    #[arg(long, value_name = "FILE")]
    pub state: Option<PathBuf>,
    /// Folder for best.brood and the front of error against operations, written at the end
    #[arg(short, long, value_name = "DIR")]
    pub output: Option<PathBuf>,
}

/// Line of input.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Answer {
    /// Errors of the genomes of the last line of output; null if a genome is useless.
    #[serde(default)]
    errors: Option<Vec<Option<f64>>>,
    /// Ends the search.
    #[serde(default)]
    end: bool,
}

/// Runs the command.
pub fn run(args: &EvolveArgs) -> Result<()> {
    logging::start_offline();
    let start: Vec<Genome> =
        args.start.iter().map(|path| genome_file::read_brdf(path)).collect::<Result<_>>()?;
    if let Some(other) = start.iter().find(|one| !one.dialect().is_compatible(start[0].dialect())) {
        bail!(
            "the starting genomes must have one dialect, got {} and {}",
            start[0].dialect(),
            other.dialect()
        );
    }
    ensure!(
        start.len() <= args.count as usize,
        "--count {} is below the number of --start genomes, {}",
        args.count,
        start.len()
    );
    let dialect: Dialect = args.dialect.map_or(Strategy::DIALECT, |words| words.0);
    let kept = usize::from(args.kept);
    let options = AskOptions { dialect, start, seed: args.seed, count: args.count, kept };
    let mut search = begin(options, args.state.as_deref())?;
    let mut input = io::stdin().lock();
    loop {
        output::print(&format!("{}\n", question(&search)))?;
        let Some(answer) = read(&mut input)? else { break };
        if answer.end {
            break;
        }
        let errors = answer
            .errors
            .context("a line of input must be {\"errors\": [...]} or {\"end\": true}")?;
        let errors: Vec<f64> = errors.iter().map(|error| error.unwrap_or(f64::INFINITY)).collect();
        search.tell(&errors)?;
        if let Some(state) = &args.state {
            output::write_file(state, &search.checkpoint())?;
        }
    }
    if let Some(folder) = &args.output {
        write(folder, &search)?;
    }
    output::print(&format!("{}\n", ending(&search)))
}

/// Starts a search, or resumes it from its state file.
fn begin(options: AskOptions, state: Option<&Path>) -> Result<AskTell> {
    match state {
        Some(path) if path.exists() => {
            let bytes = output::read_file(path, STATE_BYTES)?;
            AskTell::resume(options, &bytes).with_context(|| path.display().to_string())
        }
        _ => Ok(AskTell::new(options)),
    }
}

/// Reads the next non-empty line; `None` at the end of input.
fn read(input: &mut impl BufRead) -> Result<Option<Answer>> {
    loop {
        let mut line = String::new();
        let count = input.take(LINE_BYTES).read_line(&mut line).context("read standard input")?;
        if count == 0 {
            return Ok(None);
        }
        ensure!(
            (count as u64) < LINE_BYTES,
            "a line of input must be shorter than {LINE_BYTES} bytes"
        );
        if !line.trim().is_empty() {
            return serde_json::from_str(&line).map(Some).context("read a line of input");
        }
    }
}

/// Returns a line of output: progress, and the genomes to evaluate.
fn question(search: &AskTell) -> Value {
    let (progress, probe) = (search.progress(), search.probe());
    let genome = |genome: &Genome| {
        let program = Program::lower(genome);
        let (hash, operations) = (genome.hash().to_string(), program.operations());
        json!({ "hash": hash, "operations": operations, "text": genome.to_string() })
    };
    json!({
        "generation": progress.generation,
        "evaluations": progress.evaluations,
        "best": search.best().map(|best| best.error),
        "median": probe.median,
        "diversity": probe.diversity,
        "repeats": probe.repeats,
        "genomes": search.ask().iter().map(genome).collect::<Vec<_>>(),
    })
}

/// Returns the last line of output: the front, from the longest to the shortest genome.
fn ending(search: &AskTell) -> Value {
    let told = |told: &Evaluated| {
        let (error, operations) = (told.error, told.operations);
        json!({ "hash": told.genome.hash().to_string(), "error": error, "operations": operations, "text": told.genome.to_string() })
    };
    json!({ "end": true, "front": search.front().iter().rev().map(told).collect::<Vec<_>>() })
}

/// Writes the best genome, and the front from the longest to the shortest.
fn write(folder: &Path, search: &AskTell) -> Result<()> {
    let best = search
        .best()
        .context("no genome got a finite error, so there is no best.brood to write")?;
    output::make_dir(folder)?;
    output::write_file(&folder.join("best.brood"), best.genome.to_string().as_bytes())?;
    let row =
        |told: &Evaluated| [("operations", told.operations.into()), ("error", told.error.into())];
    front::write(folder, search.front().iter().rev().map(|told| (&told.genome, row(told))))
}
