//! `cargo xtask callgrind`: how many instructions fixed pieces of work take, against a committed table.
//!
//! A count does not depend on what else the machine does, so it can guard against slowness where times cannot. Owns the
//! table's format and when a count is objected to. The work is the example `instruction_count` of the eval crate, in
//! the profile that tests use; callgrind does not know AVX-512, so it is the AVX2 code that is counted.

use std::path::Path;
use std::process::Command;

use anyhow::{Context, Result, bail, ensure};
use serde_json::{Map, Value, json};

use crate::{shell, suite};

/// The pieces of work, as the example calls them.
const WORK: [&str; 4] = ["evaluate", "lower", "picture", "breed"];
/// The table.
const TABLE: &str = "docs/bench/instructions.json";
/// A count that grew by more than this share is objected to; one that shrank by more is worth recording.
const TOLERANCE: f64 = 0.03;
/// The example's exit code where the machine has no AVX2.
const NO_LEVEL: i32 = 77;

/// Builds the example, counts, and compares or writes the table.
pub fn run(update: bool) -> Result<()> {
    let target = suite::target_directory()?;
    let example =
        ["build", "--locked", "--package", "brood-eval", "--example", "instruction_count"];
    shell::run(shell::cargo().args(example))?;
    if shell::find_program("valgrind").is_none() {
        bail!("no valgrind (Debian: valgrind)");
    }
    if update {
        let counts = count_all(&target)?.context("this machine has no AVX2 to count with")?;
        let path = shell::root().join(TABLE);
        std::fs::write(&path, format!("{:#}\n", table(&counts))).context("write the table")?;
        println!("written to {TABLE}");
        return Ok(());
    }
    check(&target)
}

/// Counts what a build of everything has left there and compares; says so where it cannot.
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
    let mut refused = Vec::new();
    for (work, count) in &counts {
        let recorded = table["instructions"][work].as_u64();
        let verdict = Verdict::of(*count, recorded);
        println!("{}", verdict.line(work, *count, recorded));
        if matches!(verdict, Verdict::More(_) | Verdict::Unknown) {
            refused.push(work.as_str());
        }
    }
    if refused.is_empty() {
        return Ok(());
    }
    let (then, now) = (table["rustc"].as_str().unwrap_or("not known"), rustc()?);
    let other = if then == now {
        String::new()
    } else {
        format!(
            " The table was written with {then}, this is {now}, which may be all there is to it."
        )
    };
    bail!(
        "more instructions than {TABLE} allows: {}.{other} To see where they go: callgrind_annotate {}. Where the \
         work is worth it: cargo xtask callgrind --update, and say why in the commit",
        refused.join(", "),
        output_file(target, refused[0]).display(),
    )
}

/// How a count compares.
#[derive(Debug, PartialEq)]
enum Verdict {
    /// Within the tolerance, by this share.
    Same(f64),
    /// Fewer: the table could be written anew.
    Less(f64),
    /// More than is allowed.
    More(f64),
    /// The table has no such line.
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
            Self::Less(share) => {
                (*share, "  fewer: cargo xtask callgrind --update would record it")
            }
            Self::More(share) => (*share, "  MORE than allowed"),
            Self::Unknown => return format!("{work:<10} {count:>12}  is not in {TABLE}"),
        };
        let recorded = recorded.unwrap_or_default();
        format!("{work:<10} {count:>12}  recorded {recorded:>12}  {:+.2} %{words}", 100.0 * share)
    }
}

/// Instructions of each piece of work; none where the machine cannot run them.
fn count_all(target: &Path) -> Result<Option<Vec<(String, u64)>>> {
    println!("instructions by callgrind, one thread, AVX2 (it does not know AVX-512), profile dev");
    std::fs::create_dir_all(target.join("callgrind")).context("make a folder for the counts")?;
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
    let said = String::from_utf8_lossy(&output.stderr);
    ensure!(output.status.success(), "valgrind on {work} ended with {}:\n{said}", output.status);
    let text = std::fs::read_to_string(&file).context("read what callgrind wrote")?;
    let count = total(&text).context("find the total in what callgrind wrote")?;
    ensure!(count > 0, "nothing was counted for {work}: is its function still called `measured`?");
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
        // The allocator would keep an arena for each thread, as many as there are cores.
        .env("MALLOC_ARENA_MAX", "1")
        .env("RAYON_NUM_THREADS", "1");
    command
}

/// The number after `totals:` (or `summary:`, which older versions write) in callgrind's file.
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
    fn count_is_refused_when_it_grew_by_more_than_the_tolerance() {
        assert!(matches!(Verdict::of(1_031, Some(1_000)), Verdict::More(_)));
        assert!(matches!(Verdict::of(1_029, Some(1_000)), Verdict::Same(_)));
        assert!(matches!(Verdict::of(900, Some(1_000)), Verdict::Less(_)));
    }

    #[test]
    fn count_is_refused_when_the_table_does_not_have_it() {
        assert_eq!(Verdict::of(5, None), Verdict::Unknown);
        assert_eq!(Verdict::of(5, Some(0)), Verdict::Unknown);
    }
}
