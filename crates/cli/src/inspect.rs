//! `brood inspect`: prints the identity, live code, cost and physical checks of a genome.

use std::fmt::Write;
use std::path::PathBuf;

use anyhow::Result;
use brood_bench::{genome_file, logging, output};
use brood_eval::{encode_png, express};
use brood_inspect::{Inspection, image_slice, inspect, marked_source};
use clap::Args;

/// Options of `brood inspect`.
#[derive(Debug, Args)]
pub struct InspectArgs {
    /// Genome, as a `.brood` or JSON file; - is stdin
    pub genome: PathBuf,
    /// PNG file for the image slice: half angle from left to right, difference angle from bottom to
    /// top
    #[arg(long, value_name = "FILE")]
    pub slice: Option<PathBuf>,
    /// Side of the image slice in pixels
    #[arg(long, value_name = "N", default_value_t = 256, value_parser = clap::value_parser!(u32).range(16..=2048))]
    pub slice_size: u32,
}

/// Runs the command.
pub fn run(args: &InspectArgs, json: bool) -> Result<()> {
    logging::start_offline();
    let genome = genome_file::read_brdf(&args.genome)?;
    if let Some(path) = &args.slice {
        let slice = image_slice(&express(&genome), args.slice_size);
        output::write_file(path, &encode_png(slice.size_px, slice.size_px, &slice.rgba))?;
    }
    let inspection = inspect(&genome);
    if json {
        return output::print_json(&inspection);
    }
    output::print(&text(&inspection)?)
}

fn text(inspection: &Inspection) -> Result<String> {
    let Inspection { counts, physics, energy, .. } = inspection;
    let names = match inspection.inputs.as_slice() {
        [] => "none".to_owned(),
        inputs => inputs.join(" "),
    };
    let mut text = String::new();
    writeln!(text, "genome        {}", inspection.hash)?;
    writeln!(text, "program       {}", inspection.program_hash)?;
    writeln!(text, "dialect       {}, length {}", inspection.dialect, counts.instructions)?;
    writeln!(text, "inputs        {names} ({} of {})", counts.inputs_read, counts.inputs_known)?;
    writeln!(text, "instructions  {}, live {}", counts.instructions, counts.live_instructions)?;
    writeln!(
        text,
        "operations    {} written, {} live, {} after value numbering, {} after folding: executed",
        counts.scalar_operations,
        counts.live_scalar_operations,
        counts.numbered_operations,
        counts.operations
    )?;
    writeln!(text, "registers     {} in use at once", counts.registers)?;
    writeln!(
        text,
        "reciprocity   exact by construction; {} of {} swapped pairs differ",
        physics.not_reciprocal, physics.swapped_pairs
    )?;
    writeln!(
        text,
        "f             {} to {} over {} values of the hemisphere, {} not finite",
        physics.min_f, physics.max_f, physics.samples, physics.non_finite
    )?;
    writeln!(
        text,
        "reflects      at most {:.6} (theta_i {:.2} degrees), {:.1e} of it allowed for the search; {}",
        energy.max_albedo,
        energy.theta_deg,
        energy.error_bound,
        match energy.limited {
            true => format!("energy limit: divided by {:.6}", energy.divisor),
            false => "no energy limit".to_owned(),
        }
    )?;
    if let Some(slopes) = &inspection.bumps {
        writeln!(
            text,
            "bumps         mean slope {:.3}, largest {:.3}; the checks above are about the normal that they turn: about \
             the mesh's, f is not reciprocal, and steep places may reflect more",
            slopes.mean, slopes.largest
        )?;
    }
    writeln!(text, "\nsource\n")?;
    text += &marked_source(&inspection.source, &inspection.live);
    writeln!(text, "\nlive code\n")?;
    text += &inspection.code;
    Ok(text)
}
