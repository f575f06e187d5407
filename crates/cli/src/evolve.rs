//! `brood evolve`: genomes bred against a measure that somebody else owns. Each line of standard output asks about genomes, each line
//! of standard input tells how far off they are.
//!
//! Owns the lines and the files. What is bred of what was told is the search's business.

use std::io::{self, BufRead, Read};
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail, ensure};
use brood_genome::{Dialect, Genome};
use brood_program::Program;
use brood_search::{AskOptions, AskTell, DIALECT, Told};
use clap::Args;
use serde::Deserialize;
use serde_json::{Value, json};

use crate::dialect::DialectWords;
use crate::{genome_file, logging, output};

/// As much as a line of numbers can have.
const LINE_BYTES: u64 = 1 << 20;
const STATE_BYTES: u64 = 256 << 20;

/// Options of `brood evolve`.
#[derive(Debug, Args)]
pub struct EvolveArgs {
    /// A genome to begin with; may be given again. None: random ones
    #[arg(long = "start", value_name = "GENOME")]
    pub start: Vec<PathBuf>,
    /// What random genomes may use, as in 'smooth registers 7'; that of searches where absent
    #[arg(long, value_name = "WORDS", conflicts_with = "start")]
    pub dialect: Option<DialectWords>,
    /// What it draws from: the same seed and the same errors lead to the same genomes
    #[arg(long, value_name = "S", default_value_t = 1)]
    pub seed: u64,
    /// Genomes that are asked about at once
    #[arg(long, value_name = "N", default_value_t = 20, value_parser = clap::value_parser!(u32).range(1..=4096))]
    pub count: u32,
    /// Genomes that are kept to breed from
    #[arg(long, value_name = "N", default_value_t = 64, value_parser = clap::value_parser!(u16).range(2..=4096))]
    pub kept: u16,
    /// Goes on from this file where it exists; it is written after every answer
    #[arg(long, value_name = "FILE")]
    pub state: Option<PathBuf>,
    /// Where best.brood and the front of error against operations go at the end
    #[arg(short, long, value_name = "DIR")]
    pub output: Option<PathBuf>,
}

/// An answer.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Answer {
    /// Null: of no use.
    #[serde(default)]
    errors: Option<Vec<Option<f64>>>,
    /// Nothing more is asked.
    #[serde(default)]
    end: bool,
}

/// Runs the command.
pub fn run(args: &EvolveArgs) -> Result<()> {
    logging::start_offline();
    let start: Vec<Genome> = args.start.iter().map(genome_file::read).collect::<Result<_>>()?;
    if let Some(other) = start.iter().find(|one| !one.dialect().is_compatible(start[0].dialect())) {
        bail!("{} and {} cannot be bred together", start[0].dialect(), other.dialect());
    }
    ensure!(
        start.len() <= args.count as usize,
        "--count {} is too few for {} genomes to begin with",
        args.count,
        start.len()
    );
    let dialect: Dialect = args.dialect.map_or(DIALECT, |words| words.0);
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
        let errors =
            answer.errors.context("a line of input is {\"errors\": [...]} or {\"end\": true}")?;
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

fn begin(options: AskOptions, state: Option<&Path>) -> Result<AskTell> {
    match state {
        Some(path) if path.exists() => {
            let bytes = output::read_file(path, STATE_BYTES)?;
            AskTell::resume(options, &bytes).with_context(|| path.display().to_string())
        }
        _ => Ok(AskTell::new(options)),
    }
}

/// The next line; nothing at the end of input. An empty line is passed over.
fn read(input: &mut impl BufRead) -> Result<Option<Answer>> {
    loop {
        let mut line = String::new();
        let count = input.take(LINE_BYTES).read_line(&mut line).context("read standard input")?;
        if count == 0 {
            return Ok(None);
        }
        ensure!((count as u64) < LINE_BYTES, "a line of input has at most {LINE_BYTES} bytes");
        if !line.trim().is_empty() {
            return serde_json::from_str(&line).map(Some).context("read a line of input");
        }
    }
}

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

fn ending(search: &AskTell) -> Value {
    let told = |told: &Told| {
        let (error, operations) = (told.error, told.operations);
        json!({ "hash": told.genome.hash().to_string(), "error": error, "operations": operations, "text": told.genome.to_string() })
    };
    json!({ "end": true, "front": search.front().iter().rev().map(told).collect::<Vec<_>>() })
}

/// The best, and the front from the longest to the shortest.
fn write(folder: &Path, search: &AskTell) -> Result<()> {
    let best = search.best().context("nothing was of use, and there is nothing to write")?;
    let genomes = folder.join("front");
    output::make_dir(folder)?;
    output::make_dir(&genomes)?;
    output::write_file(&folder.join("best.brood"), best.genome.to_string().as_bytes())?;
    let mut text = String::from("genome,operations,error\n");
    for (index, told) in search.front().iter().rev().enumerate() {
        let name = format!("{index:02}.brood");
        output::write_file(&genomes.join(&name), told.genome.to_string().as_bytes())?;
        text += &format!("front/{name},{},{}\n", told.operations, told.error);
    }
    output::write_file(&folder.join("front.csv"), text.as_bytes())
}
