//! Location of a server's data, and the async runtime of a command.

use std::env;
use std::path::PathBuf;

use anyhow::{Context, Result, bail, ensure};
use brood_storage::{BlobAddress, DatabaseAddress, Store};
use clap::Args;

use crate::secret;

/// Place of a server's data.
#[derive(Debug, Clone, Args)]
pub struct DataPlace {
    /// Data directory; by default $XDG_DATA_HOME/brood or ~/.local/share/brood
    #[arg(long, value_name = "DIR", env = "BROOD_DATA")]
    pub data: Option<PathBuf>,
    /// PostgreSQL database, postgres://USER@HOST/NAME, instead of the one in the data directory. A
    /// password belongs in the variable or in ~/.pgpass: other users can see arguments
    #[arg(long, value_name = "ADDRESS", env = "BROOD_DATABASE", hide_env_values = true)]
    database: Option<DatabaseAddress>,
    /// File with the address of the PostgreSQL database
    #[arg(long, value_name = "FILE", env = "BROOD_DATABASE_FILE", conflicts_with = "database")]
    database_file: Option<PathBuf>,
}

/// Place of large files beside a PostgreSQL database.
#[derive(Debug, Clone, Args)]
pub struct BlobPlace {
    /// S3-compatible store, s3://BUCKET/FOLDER, for uploads and checkpoints over 1 MiB of a
    /// PostgreSQL database. Credentials and endpoint are in AWS_ACCESS_KEY_ID, AWS_ENDPOINT and so
    /// on
    #[arg(id = "blobs", long = "blobs", value_name = "ADDRESS", env = "BROOD_BLOBS")]
    pub address: Option<BlobAddress>,
}

impl DataPlace {
    /// Address of the PostgreSQL database; `None` for the one in the data directory.
    pub fn database(&self) -> Result<Option<DatabaseAddress>> {
        let Some(file) = &self.database_file else { return Ok(self.database.clone()) };
        let address = secret::read(file).context("read the address of the database")?;
        Ok(Some(address.into()))
    }

    /// Opens the store, also while a server uses it.
    pub async fn open_shared(&self) -> Result<Store> {
        match &self.database()? {
            Some(address) => Store::connect_shared(address).await.context("open the database"),
            None => {
                let dir = data_dir(self.data.as_ref())?;
                Store::open_shared(&dir).await.context("open the data directory")
            }
        }
    }

    /// Data directory, which must have a database. Error if the database is another.
    pub fn database_dir(&self) -> Result<PathBuf> {
        if let Some(address) = &self.database()? {
            bail!("{address} is copied and compacted by the tools of PostgreSQL, such as pg_dump");
        }
        with_database(self.data.as_ref())
    }
}

/// Data directory as in [`data_dir`]; error if it has no database.
pub fn with_database(given: Option<&PathBuf>) -> Result<PathBuf> {
    let data = data_dir(given)?;
    ensure!(
        data.join("brood.db").exists(),
        "{} holds no brood.db; name the data directory with --data",
        data.display()
    );
    Ok(data)
}

/// Data directory: `given`, else `$XDG_DATA_HOME/brood`, else `~/.local/share/brood`.
pub fn data_dir(given: Option<&PathBuf>) -> Result<PathBuf> {
    if let Some(dir) = given {
        return Ok(dir.clone());
    }
    choose(env::var_os("XDG_DATA_HOME").map(PathBuf::from), env::home_dir())
}

fn choose(xdg: Option<PathBuf>, home: Option<PathBuf>) -> Result<PathBuf> {
    // The XDG specification says to ignore a relative path.
    if let Some(xdg) = xdg.filter(|dir| dir.is_absolute()) {
        return Ok(xdg.join("brood"));
    }
    match home.filter(|dir| dir.is_absolute()) {
        Some(home) => Ok(home.join(".local/share/brood")),
        None => bail!("no home directory to store data in; name a directory with --data DIR"),
    }
}

/// Creates the async runtime of a command.
pub fn runtime() -> Result<tokio::runtime::Runtime> {
    tokio::runtime::Runtime::new().context("start the async runtime")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn data_dir_falls_back_when_xdg_is_missing_or_relative() {
        let home = || Some(PathBuf::from("/h"));
        assert_eq!(choose(Some("/x".into()), home()).unwrap(), PathBuf::from("/x/brood"));
        let fallback = PathBuf::from("/h/.local/share/brood");
        assert_eq!(choose(Some("x".into()), home()).unwrap(), fallback);
        assert_eq!(choose(None, home()).unwrap(), fallback);
        assert!(choose(None, None).is_err());
    }
}
