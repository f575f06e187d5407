//! `cargo xtask mutants`: changes the code in small ways and lists the changes that no test
//! detects.
//!
//! Runs cargo-mutants on the crates whose tests are fast enough. A mutant that survives must be in
//! the recorded list with a reason why it is harmless; any other survivor is an error. Not part of
//! CI, because each mutant is a build and a test run.

use std::collections::BTreeMap;
use std::path::Path;

use anyhow::{Context, Result, bail, ensure};

use crate::{shell, suite};

/// Version of cargo-mutants that writes the names in the list.
const VERSION: &str = "27.1.0";
/// Crates without an argument.
const CRATES: [&str; 7] = ["genome", "program", "light", "mesh", "scene", "storage", "server"];
/// Recorded survivors.
const LIST: &str = "docs/mutants.md";
/// Output of cargo-mutants that names survivors. Mutants that never end are not among them: the
/// tests hang.
const SURVIVORS: &str = "missed.txt";

/// Exit codes of cargo-mutants after it has tested the mutants: all detected, some missed, some
/// timed out.
const TESTED: [i32; 3] = [0, 2, 3];

/// Runs cargo-mutants and compares the survivors with the list.
///
/// Arguments: names of crates, `--shard K/N` to test one of N parts, `--file GLOB` to test some
/// files, and `--compare` to only compare the results of the last run.
pub fn run(arguments: &[&str]) -> Result<()> {
    let options = Options::parse(arguments)?;
    let target = suite::target_directory()?;
    if !options.compare_only {
        install()?;
        let mut command = options.command(&target);
        println!("$ {command:?}");
        let status = command.status().context("start cargo-mutants")?;
        // The lists of survivors are empty, or those of the run before, if no mutant was tested.
        ensure!(
            status.code().is_some_and(|code| TESTED.contains(&code)),
            "cargo-mutants tested no mutant: it ended with {status}"
        );
    }
    let results = target.join("mutants/mutants.out");
    let mut found = Survivors::default();
    let path = results.join(SURVIVORS);
    let text = std::fs::read_to_string(&path)
        .with_context(|| format!("read {}: cargo-mutants did not finish", path.display()))?;
    text.lines().for_each(|line| found.add(&normalised(line), 1));
    let list = std::fs::read_to_string(shell::root().join(LIST))
        .with_context(|| format!("read {LIST}"))?;
    let unknown = found.without(&Survivors::parse(&list)?);
    println!("{} survivors, {} of them not in {LIST}", found.count(), unknown.count());
    if unknown.count() == 0 {
        return Ok(());
    }
    for (mutant, count) in &unknown.0 {
        println!("- `{mutant}` ({count})");
    }
    bail!("add a test that detects each, or record in {LIST} why it is harmless")
}

/// Installs cargo-mutants unless it is installed.
fn install() -> Result<()> {
    let version = shell::cargo().args(["mutants", "--version"]).output();
    let installed = version.is_ok_and(|output| {
        let text = String::from_utf8_lossy(&output.stdout);
        output.status.success() && text.split_whitespace().last() == Some(VERSION)
    });
    if installed {
        return Ok(());
    }
    let arguments = ["install", "cargo-mutants", "--locked", "--version", VERSION];
    shell::run(shell::cargo().args(arguments))
}

#[derive(Debug, Default, PartialEq, Eq)]
struct Options {
    crates: Vec<String>,
    shard: Option<String>,
    files: Vec<String>,
    compare_only: bool,
}

impl Options {
    fn parse(arguments: &[&str]) -> Result<Self> {
        let mut options = Self::default();
        let mut rest = arguments.iter();
        while let Some(argument) = rest.next() {
            match *argument {
                "--compare" => options.compare_only = true,
                "--shard" => {
                    let shard = rest.next().context("--shard needs K/N, such as 0/20")?;
                    options.shard = Some((*shard).to_owned());
                }
                "--file" => {
                    let file = rest.next().context("--file needs a path or glob")?;
                    options.files.push((*file).to_owned());
                }
                flag if flag.starts_with('-') => bail!("unknown option: {flag}"),
                name => options.crates.push(name.to_owned()),
            }
        }
        if options.crates.is_empty() {
            options.crates = CRATES.map(str::to_owned).to_vec();
        }
        Ok(options)
    }

    fn command(&self, target: &Path) -> std::process::Command {
        let mut command = shell::cargo();
        // The sources are copied to a new folder by every run; builds of dependencies are kept.
        command.env("CARGO_TARGET_DIR", target.join("mutants/build"));
        command.args(["mutants", "--test-tool", "nextest", "--no-times", "--colors", "never"]);
        command.arg("--output").arg(target.join("mutants"));
        for name in &self.crates {
            command.args(["--package", &format!("brood-{name}")]);
        }
        for file in &self.files {
            command.args(["--file", file]);
        }
        if let Some(shard) = &self.shard {
            command.args(["--shard", shard]);
        }
        command
    }
}

/// Names of mutants, and how often each occurs: a function may have the same operator twice.
#[derive(Debug, Default, PartialEq, Eq)]
struct Survivors(BTreeMap<String, usize>);

impl Survivors {
    /// Reads list items such as ``- `file: mutant` (2): reason``.
    fn parse(list: &str) -> Result<Self> {
        let mut survivors = Self::default();
        for line in list.lines() {
            let Some(item) = line.strip_prefix("- `") else { continue };
            let (mutant, rest) =
                item.rsplit_once('`').with_context(|| format!("{LIST}: no closing `: {line}"))?;
            let (count, reason) = match rest.trim_start().strip_prefix('(') {
                Some(rest) => {
                    let (count, reason) = rest.split_once(')').unwrap_or((rest, ""));
                    let count = count.parse();
                    (count.with_context(|| format!("{LIST}: count of {mutant}"))?, reason)
                }
                None => (1, rest),
            };
            let reason = reason.trim_start_matches(':').trim();
            ensure!(!reason.is_empty(), "{LIST}: no reason for {mutant}");
            survivors.add(mutant, count);
        }
        Ok(survivors)
    }

    fn add(&mut self, mutant: &str, count: usize) {
        *self.0.entry(mutant.to_owned()).or_default() += count;
    }

    /// Survivors that `known` has not, or not as often.
    fn without(&self, known: &Self) -> Self {
        let mut rest = Self::default();
        for (mutant, count) in &self.0 {
            let unknown = count.saturating_sub(known.0.get(mutant).copied().unwrap_or(0));
            if unknown > 0 {
                rest.add(mutant, unknown);
            }
        }
        rest
    }

    fn count(&self) -> usize {
        self.0.values().sum()
    }
}

/// Name of a mutant without line and column, which change with every edit.
fn normalised(line: &str) -> String {
    let mut parts = line.splitn(4, ':');
    match (parts.next(), parts.next(), parts.next(), parts.next()) {
        (Some(file), Some(_), Some(_), Some(mutant)) => format!("{file}:{mutant}"),
        _ => line.to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn survivor_is_unknown_when_the_list_has_it_less_often() {
        let list = "# Mutants\n\n- `a.rs: replace | with ^ in f` (2): the bits are disjoint.\n\
                    - `b.rs: replace g -> bool with true`: only saves time.\n";
        let known = Survivors::parse(list).unwrap();
        let mut found = Survivors::default();
        for line in ["a.rs:1:2: replace | with ^ in f"; 3] {
            found.add(&normalised(line), 1);
        }
        found.add(&normalised("b.rs:7:5: replace g -> bool with true"), 1);
        let unknown = found.without(&known);
        assert_eq!((found.count(), unknown.count()), (4, 1));
        assert_eq!(unknown.0["a.rs: replace | with ^ in f"], 1);
    }

    #[test]
    fn list_is_refused_when_a_survivor_has_no_reason() {
        assert!(Survivors::parse("- `a.rs: replace f with ()`\n").is_err());
        assert!(Survivors::parse("- `a.rs: replace f with ()` (2):\n").is_err());
    }

    #[test]
    fn options_name_crates_parts_and_files() {
        let options = Options::parse(&["program", "--shard", "1/8", "--file", "x.rs"]).unwrap();
        assert_eq!(options.crates, ["program"]);
        assert_eq!((options.shard.as_deref(), options.files.len()), (Some("1/8"), 1));
        assert_eq!(Options::parse(&[]).unwrap().crates.len(), CRATES.len());
        assert!(Options::parse(&["--fast"]).is_err());
    }
}
