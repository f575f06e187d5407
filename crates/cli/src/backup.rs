//! `brood backup`: copies the database into one file, whether or not a server is running.

use std::fs;

use std::path::PathBuf;

use anyhow::{Context, Result, ensure};
use brood_bench::{logging, output};
use brood_storage::Store;
use clap::Args;
use serde_json::json;

use crate::place::{self, DataPlace};

/// Options of `brood backup`.
#[derive(Debug, Args)]
pub struct BackupArgs {
    /// File to write; must not exist yet
    file: PathBuf,
    #[command(flatten)]
    place: DataPlace,
}

/// Runs the command.
pub fn run(args: &BackupArgs, json: bool) -> Result<()> {
    logging::start_offline();
    ensure!(
        !args.file.exists(),
        "{} exists already; choose another file name",
        args.file.display()
    );
    let data = args.place.database_dir()?;
    let part = output::name_beside(&args.file)?;
    let spinner = output::spinner("copying");
    let copied = place::runtime()?.block_on(async {
        let store = Store::open_shared(&data).await.context("open the data directory")?;
        let copied = store.backup(&part).await.context("copy the database");
        store.close().await?;
        copied
    });
    spinner.finish_and_clear();
    copied?;
    fs::rename(&part, &args.file)
        .with_context(|| format!("rename the backup to {}", args.file.display()))?;
    let bytes = fs::metadata(&args.file).context("read the size of the backup")?.len();
    if json {
        return output::print_json(&json!({ "file": args.file, "bytes": bytes }));
    }
    output::print(&format!("{}: {bytes} bytes\n", args.file.display()))
}
