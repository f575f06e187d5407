//! `brood palette`: prints the colours of a picture, from which `brood breed --painting` paints.

use std::path::PathBuf;

use anyhow::Result;
use brood_bench::{output, painting_file};
use brood_genome::PaintingRegion;
use clap::Args;

/// Options of `brood palette`.
#[derive(Debug, Args)]
pub struct PaletteArgs {
    /// PNG or JPEG of at most 4096 pixels a side; - is stdin
    picture: PathBuf,
}

/// Runs the command.
pub fn run(args: &PaletteArgs, json: bool) -> Result<()> {
    let palette = painting_file::read(&args.picture)?;
    if json {
        return output::print_json(&palette);
    }
    let line = |region: &PaintingRegion| {
        let [dark, middle, bright] =
            region.colors().map(|[red, green, blue]| format!("#{red:02x}{green:02x}{blue:02x}"));
        format!("{dark}  {middle}  {bright}  {:5.1} %\n", 100.0 * region.share)
    };
    let lines: String = palette.regions().iter().map(line).collect();
    output::print(&format!("dark     middle   bright   area\n{lines}"))
}
