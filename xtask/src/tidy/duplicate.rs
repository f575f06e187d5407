//! Dependencies that Cargo.lock holds in several versions, against the committed list.
//!
//! Owns the list's format: one line for each crate, its name and its versions. The list may shrink
//! or grow only together with a look at it, so both a new and a vanished duplicate are objected to.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result};

const HEADER: &str = "# Crates that Cargo.lock holds in more than one version; cargo xtask tidy --update-duplicates writes this.\n";

fn list_file(root: &Path) -> PathBuf {
    root.join("xtask/duplicates.txt")
}

/// Differences between Cargo.lock and the list.
pub fn violations(root: &Path) -> Result<Vec<String>> {
    let lock = std::fs::read_to_string(root.join("Cargo.lock")).context("read Cargo.lock")?;
    let listed = std::fs::read_to_string(list_file(root)).context("read xtask/duplicates.txt")?;
    Ok(differences(&duplicates(&lock), &listed))
}

/// Writes the list as Cargo.lock has it.
pub fn update(root: &Path) -> Result<()> {
    let lock = std::fs::read_to_string(root.join("Cargo.lock")).context("read Cargo.lock")?;
    let lines = duplicates(&lock);
    std::fs::write(list_file(root), format!("{HEADER}{}\n", lines.join("\n")))
        .context("write xtask/duplicates.txt")?;
    println!("{} crates in several versions", lines.len());
    Ok(())
}

/// One line for each crate with several versions: name and versions, as Cargo.lock sorts them.
fn duplicates(lock: &str) -> Vec<String> {
    let mut versions: BTreeMap<&str, Vec<&str>> = BTreeMap::new();
    let mut name = None;
    for line in lock.lines() {
        let value = |key: &str| line.strip_prefix(key)?.strip_suffix('"');
        if let Some(text) = value("name = \"") {
            name = Some(text);
        } else if let (Some(text), Some(name)) = (value("version = \""), name.take()) {
            versions.entry(name).or_default().push(text);
        }
    }
    versions.retain(|_, versions| versions.len() > 1);
    versions.into_iter().map(|(name, versions)| format!("{name} {}", versions.join(" "))).collect()
}

fn differences(found: &[String], listed: &str) -> Vec<String> {
    let listed: Vec<&str> = listed
        .lines()
        .map(str::trim)
        .filter(|line| !line.is_empty() && !line.starts_with('#'))
        .collect();
    let new = found
        .iter()
        .filter(|line| !listed.contains(&line.as_str()))
        .map(|line| format!("Cargo.lock: several versions, not in xtask/duplicates.txt: {line}"));
    let gone = listed
        .iter()
        .filter(|line| !found.iter().any(|found| found == *line))
        .map(|line| format!("xtask/duplicates.txt: no longer so in Cargo.lock: {line}"));
    new.chain(gone).collect()
}

#[cfg(test)]
mod tests {
    use super::{differences, duplicates};

    const LOCK: &str = "version = 4\n\n[[package]]\nname = \"a\"\nversion = \"1.0.0\"\n\n[[package]]\nname = \"b\"\n\
        version = \"0.1.0\"\ndependencies = [\n \"a 1.0.0\",\n]\n\n[[package]]\nname = \"a\"\nversion = \"2.0.0\"\n";

    #[test]
    fn duplicates_are_found_when_a_crate_has_two_versions() {
        assert_eq!(duplicates(LOCK), ["a 1.0.0 2.0.0"]);
    }

    #[test]
    fn list_is_refused_when_it_differs_from_the_lock() {
        let found = duplicates(LOCK);
        assert_eq!(differences(&found, "# comment\na 1.0.0 2.0.0\n"), Vec::<String>::new());
        assert_eq!(differences(&found, "").len(), 1);
        assert_eq!(differences(&found, "a 1.0.0 2.0.0\nc 1.0.0 1.1.0\n").len(), 1);
    }
}
