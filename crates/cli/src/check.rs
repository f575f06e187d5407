//! `brood check`: reads the database, all genomes, the files in the object store and the cached
//! pictures, and lists what is damaged, whether or not a server is running.

use anyhow::{Context, Result, bail};
use brood_bench::{logging, output};
use brood_storage::CheckedStore;
use clap::Args;
use serde_json::json;

use crate::place::{self, BlobPlace, DataPlace};

/// Options of `brood check`.
#[derive(Debug, Args)]
pub struct CheckArgs {
    #[command(flatten)]
    place: DataPlace,
    #[command(flatten)]
    blobs: BlobPlace,
}

/// Runs the command. Damage of the database is an error; damaged pictures are rendered again.
pub fn run(args: &CheckArgs, json: bool) -> Result<()> {
    logging::start_offline();
    let data = match args.place.database()? {
        Some(_) => place::data_dir(args.place.data.as_ref())?,
        None => args.place.database_dir()?,
    };
    let spinner = output::spinner("checking the database");
    let checked = place::runtime()?.block_on(async {
        let store = args.place.open_shared().await?;
        let store = store.with_blobs_to_read(args.blobs.address.as_ref()).await;
        let store = store.context("open the object store")?;
        let checked = store.check(|genomes| spinner.set_message(format!("genomes: {genomes}")));
        let checked = checked.await.context("check the database");
        store.close().await?;
        checked
    });
    spinner.set_message("pictures");
    let pictures = brood_server::check_pictures(&data).context("read the cached pictures");
    spinner.finish_and_clear();
    let CheckedStore { genomes, files, unread_files, problems } = checked?;
    let (pictures, damaged_pictures) = pictures?;
    if json {
        output::print_json(&json!({
            "genomes": genomes,
            "files": files,
            "unread_files": unread_files,
            "pictures": pictures,
            "damaged_pictures": damaged_pictures,
            "problems": problems,
        }))?;
    } else {
        output::print(&format!(
            "{genomes} genomes and {pictures} pictures are as they were written; \
             {damaged_pictures} pictures are damaged and will be rendered again\n"
        ))?;
        if files > 0 {
            output::print(&format!("read {files} files in the object store\n"))?;
        }
        if unread_files > 0 {
            output::print(&format!(
                "did not read {unread_files} files in the object store; name it with --blobs\n"
            ))?;
        }
        problems.iter().try_for_each(|problem| output::print(&format!("{problem}\n")))?;
    }
    if !problems.is_empty() {
        bail!("the database is damaged; restore a backup");
    }
    Ok(())
}
