//! `brood migrate`: copies the database of a data directory into PostgreSQL.

use anyhow::{Context, Result};
use brood_bench::{logging, output};
use brood_storage::{MigrationStep, migrate};
use clap::Args;
use serde_json::json;

use crate::place::{self, DataPlace};

/// Options of `brood migrate`.
#[derive(Debug, Args)]
pub struct MigrateArgs {
    #[command(flatten)]
    place: DataPlace,
}

/// Runs the command.
pub fn run(args: &MigrateArgs, json: bool) -> Result<()> {
    logging::start_offline();
    let database = args.place.database()?;
    let database = database.context("name the PostgreSQL database with --database")?;
    let data = place::with_database(args.place.data.as_ref())?;
    let spinner = output::spinner("connecting");
    let migrated = place::runtime()?.block_on(migrate(&data, &database, |step| match step {
        MigrationStep::Copied { table, rows } => {
            spinner.set_message(format!("copying {table}: {rows} rows"));
        }
        MigrationStep::Compared { table } => spinner.set_message(format!("comparing {table}")),
    }));
    spinner.finish_and_clear();
    let migrated = migrated.with_context(|| format!("copy {} to {database}", data.display()))?;
    if json {
        return output::print_json(&json!({
            "rows": migrated.rows,
            "changed_texts": migrated.changed_texts,
        }));
    }
    output::print(&format!("copied {} rows to {database}; all hashes match\n", migrated.rows))?;
    if migrated.changed_texts > 0 {
        output::print(&format!("replaced U+0000 by U+FFFD in {} texts\n", migrated.changed_texts))?;
    }
    Ok(())
}
