//! `brood inspect`: what a genome is, what of it lives, and whether it is physical.

use std::fmt::Write;
use std::path::PathBuf;

use anyhow::Result;
use brood_genome::{Genome, Input, live_instructions};
use brood_program::{Counts, Program, Tape};
use brood_protocol::Backend;
use brood_worker::Renderer;
use clap::Args;
use serde_json::json;

use crate::physics::{self, Physics};
use crate::{genome_file, listing, logging, output};

/// Options of `brood inspect`.
#[derive(Debug, Args)]
pub struct InspectArgs {
    /// A `.brood` or JSON file; - is stdin
    pub genome: PathBuf,
}

/// Runs the command.
pub fn run(args: &InspectArgs, json: bool) -> Result<()> {
    logging::start_offline();
    let genome = genome_file::read(&args.genome)?;
    let program = Program::lower(&genome);
    let physics = physics::check(&Renderer::new(Backend::Cpu), &program)?;
    if json {
        return output::print_json(&report(&genome, &program, &physics));
    }
    output::print(&text(&genome, &program, &physics)?)
}

fn report(genome: &Genome, program: &Program, physics: &Physics) -> serde_json::Value {
    let counts = Counts::of(genome);
    let inputs: Vec<&str> = program.inputs().iter().map(|input| input.name()).collect();
    json!({
        "hash": genome.hash().to_string(),
        "program_hash": program.hash().to_string(),
        "dialect": genome.dialect(),
        "inputs": inputs,
        "counts": {
            "instructions": counts.instructions,
            "live_instructions": counts.live_instructions,
            "scalar_operations": counts.scalar_operations,
            "live_scalar_operations": counts.live_scalar_operations,
            "numbered_operations": counts.numbered_operations,
            "operations": counts.operations,
            "inputs_read": inputs.len(),
            "inputs_known": Input::ALL.len(),
            "registers": Tape::new(program).registers(),
        },
        "physics": physics,
        "source": genome.to_string(),
        "live": live_instructions(genome),
        "code": listing::scalar_code(program),
    })
}

fn text(genome: &Genome, program: &Program, physics: &Physics) -> Result<String> {
    let counts = Counts::of(genome);
    let inputs: Vec<&str> = program.inputs().iter().map(|input| input.name()).collect();
    let names = if inputs.is_empty() { "none".to_owned() } else { inputs.join(" ") };
    let mut text = String::new();
    writeln!(text, "genome        {}", genome.hash())?;
    writeln!(text, "program       {}", program.hash())?;
    let dialect = genome.dialect();
    writeln!(text, "dialect       {dialect}, length {}", dialect.length)?;
    writeln!(text, "inputs        {names} ({} of {})", inputs.len(), Input::ALL.len())?;
    writeln!(text, "instructions  {}, live {}", counts.instructions, counts.live_instructions)?;
    writeln!(
        text,
        "operations    {} written, {} live, {} after value numbering, {} after folding: executed",
        counts.scalar_operations,
        counts.live_scalar_operations,
        counts.numbered_operations,
        counts.operations
    )?;
    writeln!(text, "registers     {} in use at once", Tape::new(program).registers())?;
    writeln!(
        text,
        "reciprocity   exact by construction; {} pairs swapped, {} differ",
        physics.swapped_pairs, physics.not_reciprocal
    )?;
    writeln!(
        text,
        "f             {} to {} over {} values of the hemisphere, {} not finite",
        physics.min_f, physics.max_f, physics.samples, physics.non_finite
    )?;
    writeln!(
        text,
        "albedo        at most {:.6} (theta_i {:.0} degrees) over {} integrals of {} samples each",
        physics.max_albedo,
        physics.max_albedo_theta_deg,
        physics.integrals,
        physics.samples_per_integral
    )?;
    writeln!(text, "\nsource\n")?;
    text += &listing::marked_source(&genome.to_string(), &live_instructions(genome));
    writeln!(text, "\nlive code\n")?;
    text += &listing::scalar_code(program);
    Ok(text)
}
