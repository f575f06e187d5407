//! `brood compact`: packs genomes of earlier versions and gives free pages back, while no server is
//! running.

use anyhow::{Context, Result};
use brood_bench::{logging, output};
use brood_storage::{Compacted, Store};
use clap::Args;
use serde_json::json;

use crate::place::{self, DataPlace};

/// Options of `brood compact`.
#[derive(Debug, Args)]
pub struct CompactArgs {
    #[command(flatten)]
    place: DataPlace,
}

/// Runs the command.
pub fn run(args: &CompactArgs, json: bool) -> Result<()> {
    logging::start_offline();
    let data = args.place.database_dir()?;
    let spinner = output::spinner("packing genomes");
    let compacted = place::runtime()?.block_on(Store::compact(&data, |genomes| {
        spinner.set_message(format!("packing genomes: {genomes}"));
    }));
    spinner.finish_and_clear();
    let Compacted { genomes, bytes_before, bytes_after } =
        compacted.context("compact the database")?;
    if json {
        return output::print_json(&json!({
            "genomes": genomes,
            "bytes_before": bytes_before,
            "bytes_after": bytes_after,
        }));
    }
    output::print(&format!(
        "{genomes} genomes packed; brood.db has {bytes_after} bytes, before {bytes_before}\n"
    ))
}
