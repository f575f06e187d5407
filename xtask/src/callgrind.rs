//! `cargo xtask callgrind`: instruction counts of fixed work, compared with a committed table.
//!
//! Counts do not depend on other load, so they detect slow-downs where times cannot. Owns the
//! format of the table and the tolerance. The work is the example `instruction_count` of the eval
//! crate in the profile of the tests. callgrind does not support AVX-512, so the AVX2 code is
//! counted.

use std::path::Path;
use std::process::Command;

use anyhow::{Context, Result, bail, ensure};
use serde_json::{Map, Value, json};

use crate::{shell, suite};

/// Work items by their names in the example.
const WORK: [&str; 4] = ["evaluate", "lower", "picture", "breed"];
/// File of the recorded counts.
const TABLE: &str = "docs/bench/instructions.json";
/// Relative growth above which a count fails; a larger decrease is worth recording.
const TOLERANCE: f64 = 0.03;
/// Exit code of the example on machines without AVX2.
const NO_LEVEL: i32 = 77;

/// Builds the example, counts, and compares with or updates the table.
pub fn run(update: bool) -> Result<()> {
    let target = suite::target_directory()?;
    let example =
        ["build", "--locked", "--package", "brood-eval", "--example", "instruction_count"];
    shell::run(shell::cargo().args(example))?;
    if shell::find_program("valgrind").is_none() {
        bail!("valgrind is not installed (Debian: valgrind)");
    }
    if update {
        let counts = count_all(&target)?.context("counting needs a machine with AVX2")?;
        let path = shell::root().join(TABLE);
        std::fs::write(&path, format!("{:#}\n", table(&counts))).context("write the table")?;
        println!("written to {TABLE}");
        return Ok(());
    }
    check(&target)
}

/// Counts with the binaries of a previous full build and compares; prints a line if it cannot.
pub fn guard(target: &Path) -> Result<()> {
    if shell::find_program("valgrind").is_none() {
        println!("skipped: no valgrind (Debian: valgrind), and it could not be installed");
        return Ok(());
    }
    check(target)
}

fn check(target: &Path) -> Result<()> {
    let text = std::fs::read_to_string(shell::root().join(TABLE));
    let text =
        text.with_context(|| format!("read {TABLE}; cargo xtask callgrind --update writes it"))?;
    let table: Value = serde_json::from_str(&text).with_context(|| format!("read {TABLE}"))?;
    let Some(counts) = count_all(target)? else {
        println!("skipped: this machine has no AVX2");
        return Ok(());
    };
    let mut failed = Vec::new();
    for (work, count) in &counts {
        let recorded = table["instructions"][work].as_u64();
        let verdict = Verdict::of(*count, recorded);
        println!("{}", verdict.line(work, *count, recorded));
        if matches!(verdict, Verdict::More(_) | Verdict::Unknown) {
            failed.push(work.as_str());
        }
    }
    if failed.is_empty() {
        return Ok(());
    }
    let (then, now) = (table["rustc"].as_str().unwrap_or("not known"), rustc()?);
    let other = if then == now {
        String::new()
    } else {
        format!(" The table was written with {then}, this is {now}, which may be the only reason.")
    };
    bail!(
        "more instructions than {TABLE} allows: {}.{other} To see where they are spent: callgrind_annotate {}. If the \
         increase is justified: cargo xtask callgrind --update, with the reason in the commit",
        failed.join(", "),
        output_file(target, failed[0]).display(),
    )
}

/// Result of comparing a count with the table.
#[derive(Debug, PartialEq)]
enum Verdict {
    /// Within the tolerance, with the relative change.
    Same(f64),
    /// Fewer, with the relative change: the table may be updated.
    Less(f64),
    /// More than the tolerance allows, with the relative change.
    More(f64),
    /// Missing from the table.
    Unknown,
}

impl Verdict {
    fn of(count: u64, recorded: Option<u64>) -> Self {
        let Some(recorded) = recorded.filter(|recorded| *recorded > 0) else {
            return Self::Unknown;
        };
        let share = count as f64 / recorded as f64 - 1.0;
        if share > TOLERANCE {
            Self::More(share)
        } else if share < -TOLERANCE {
            Self::Less(share)
        } else {
            Self::Same(share)
        }
    }

    fn line(&self, work: &str, count: u64, recorded: Option<u64>) -> String {
        let (share, words) = match self {
            Self::Same(share) => (*share, ""),
            Self::Less(share) => (*share, "  fewer: cargo xtask callgrind --update records it"),
            Self::More(share) => (*share, "  MORE than allowed"),
            Self::Unknown => return format!("{work:<10} {count:>12}  is not in {TABLE}"),
        };
        let recorded = recorded.unwrap_or_default();
        format!("{work:<10} {count:>12}  recorded {recorded:>12}  {:+.2} %{words}", 100.0 * share)
    }
}

/// Instructions of each work item; `None` if the machine cannot run them.
fn count_all(target: &Path) -> Result<Option<Vec<(String, u64)>>> {
    println!(
        "instructions by callgrind, one thread, AVX2 (callgrind does not support AVX-512), profile dev"
    );
    std::fs::create_dir_all(target.join("callgrind")).context("create the folder of the counts")?;
    let mut counts = Vec::new();
    for work in WORK {
        match count(target, work)? {
            Some(count) => counts.push((work.to_owned(), count)),
            None => return Ok(None),
        }
    }
    Ok(Some(counts))
}

fn count(target: &Path, work: &str) -> Result<Option<u64>> {
    let file = output_file(target, work);
    let mut command = command(target, work, &file);
    let output = command.output().context("start valgrind")?;
    if output.status.code() == Some(NO_LEVEL) {
        return Ok(None);
    }
    let stderr = String::from_utf8_lossy(&output.stderr);
    ensure!(output.status.success(), "valgrind on {work} ended with {}:\n{stderr}", output.status);
    let text = std::fs::read_to_string(&file).context("read callgrind's output")?;
    let count = total(&text).context("find the total in callgrind's output")?;
    ensure!(
        count > 0,
        "no instructions were counted for {work}: its function must be called `measured`"
    );
    Ok(Some(count))
}

fn output_file(target: &Path, work: &str) -> std::path::PathBuf {
    target.join("callgrind").join(format!("{work}.out"))
}

fn command(target: &Path, work: &str, file: &Path) -> Command {
    let mut command = shell::command("valgrind");
    let mut out = std::ffi::OsString::from("--callgrind-out-file=");
    out.push(file);
    command
        .args(["--tool=callgrind", "--collect-atstart=no"])
        .arg("--toggle-collect=instruction_count::measured*")
        .arg(out)
        .arg(target.join("debug/examples/instruction_count"))
        .arg(work)
        // Otherwise the allocator creates arenas depending on the number of cores.
        .env("MALLOC_ARENA_MAX", "1")
        .env("RAYON_NUM_THREADS", "1");
    command
}

/// Number after `totals:` (or `summary:`, as older versions write) in callgrind's file.
fn total(text: &str) -> Option<u64> {
    let line = |key: &str| text.lines().find_map(|line| line.strip_prefix(key));
    let numbers = line("totals:").or_else(|| line("summary:"))?;
    numbers.split_whitespace().next()?.parse().ok()
}

fn table(counts: &[(String, u64)]) -> Value {
    let instructions: Map<String, Value> =
        counts.iter().map(|(work, count)| (work.clone(), json!(count))).collect();
    json!({
        "about": "cargo xtask callgrind --update writes this; AVX2, one thread, profile dev",
        "rustc": rustc().unwrap_or_default(),
        "tolerance": TOLERANCE,
        "instructions": instructions,
    })
}

fn rustc() -> Result<String> {
    Ok(shell::output(shell::command("rustc").arg("--version"))?.trim().to_owned())
}

#[cfg(test)]
mod tests {
    use super::{Verdict, total};

    #[test]
    fn total_is_read_from_either_line() {
        assert_eq!(total("version: 1\nsummary: 123\n\ntotals: 456\n"), Some(456));
        assert_eq!(total("summary: 123 4\n"), Some(123));
        assert_eq!(total("version: 1\n"), None);
    }

    #[test]
    fn count_fails_when_it_grows_by_more_than_the_tolerance() {
        assert!(matches!(Verdict::of(1_031, Some(1_000)), Verdict::More(_)));
        assert!(matches!(Verdict::of(1_029, Some(1_000)), Verdict::Same(_)));
        assert!(matches!(Verdict::of(900, Some(1_000)), Verdict::Less(_)));
    }

    #[test]
    fn count_fails_when_it_is_missing_from_the_table() {
        assert_eq!(Verdict::of(5, None), Verdict::Unknown);
        assert_eq!(Verdict::of(5, Some(0)), Verdict::Unknown);
    }
}
