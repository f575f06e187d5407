//! Secrets that are given as an argument, in the environment, or in a file.

use std::path::Path;

use anyhow::{Context, Result, ensure};

/// Returns the secret in a file, without white space around it. The file must not be empty.
pub fn read(file: &Path) -> Result<String> {
    let text = std::fs::read_to_string(file).with_context(|| format!("read {}", file.display()))?;
    let secret = text.trim();
    ensure!(!secret.is_empty(), "{} is empty", file.display());
    Ok(secret.to_owned())
}
