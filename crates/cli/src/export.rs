//! `brood export`: prints a genome as source code for other renderers.

use std::path::PathBuf;

use anyhow::{Context, Result};
use brood_bench::{genome_file, logging, output};
use brood_eval::express;
use brood_export::{Format, Within, print};
use clap::Args;
use serde_json::json;

use crate::breed::on_off;

/// Options of `brood export`.
#[derive(Debug, Args)]
pub struct ExportArgs {
    /// Genome, as a `.brood` or JSON file; - is stdin
    genome: PathBuf,
    /// Format: glsl-es-300, glsl-410, wgsl, or vrm-mtoon for simple painted materials
    #[arg(long, value_name = "FORMAT", default_value = "glsl-es-300")]
    format: Format,
    /// Energy limit: divide by the largest albedo if that is above 1; by default as the genome says
    #[arg(long, value_name = "on|off", value_parser = on_off)]
    limit: Option<bool>,
    /// Number of lights of the function of a painted material, 1 to 8
    #[arg(long, value_name = "N", default_value_t = 1)]
    lights: usize,
    /// File to write; stdout by default
    #[arg(long, short, value_name = "FILE")]
    output: Option<PathBuf>,
}

/// Runs the command.
pub fn run(args: &ExportArgs, json: bool) -> Result<()> {
    logging::start_offline();
    let genome = genome_file::read(&args.genome)?;
    let limited = args.limit.unwrap_or(genome.is_limited());
    let program = express(&genome.with_limit(limited));
    let within = Within { lights: args.lights, ..Within::default() };
    let text =
        print(&program, args.format, within).with_context(|| args.genome.display().to_string())?;
    let Some(path) = &args.output else {
        return match json {
            true => output::print_json(&json!({ "format": args.format.name(), "source": text })),
            false => output::print(&text),
        };
    };
    output::write_file(path, text.as_bytes())?;
    if json {
        return output::print_json(
            &json!({ "format": args.format.name(), "path": path, "bytes": text.len() }),
        );
    }
    eprintln!("{}: {}, {} operations", path.display(), args.format.label(), program.operations());
    Ok(())
}
