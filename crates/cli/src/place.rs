//! Location of the data directory, and the async runtime of a command.

use std::env;
use std::path::PathBuf;

use anyhow::{Context, Result, bail, ensure};

/// Data directory: `given`, else `$XDG_DATA_HOME/brood`, else `~/.local/share/brood`.
pub fn data_dir(given: Option<&PathBuf>) -> Result<PathBuf> {
    if let Some(dir) = given {
        return Ok(dir.clone());
    }
    choose(env::var_os("XDG_DATA_HOME").map(PathBuf::from), env::home_dir())
}

/// Data directory as in [`data_dir`]; error if it has no database.
pub fn database_dir(given: Option<&PathBuf>) -> Result<PathBuf> {
    let data = data_dir(given)?;
    ensure!(
        data.join("brood.db").exists(),
        "{} holds no brood.db; name the data directory with --data",
        data.display()
    );
    Ok(data)
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
