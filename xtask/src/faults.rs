//! `cargo xtask faults`: runs the tests that kill processes, fill the disk and measure memory, and
//! prints their figures. The short form is also part of the test suite; `--long` repeats the tests
//! with ten times the rounds for an hour. `--cluster` runs the faults of a cluster (`cluster.rs`).

use std::collections::BTreeMap;
use std::sync::Mutex;
use std::time::{Duration, Instant};

use anyhow::{Context, Result, bail};

use crate::{cluster, shell, suite};

/// Start of the lines with figures that tests print.
pub const PREFIX: &str = "fault: ";
const HOUR: Duration = Duration::from_secs(3600);
/// Factor of the rounds of the long form.
const ROUNDS: &str = "10";

/// Runs the tests once, or with `--long` or `--minutes N` until the time is over.
pub fn run(options: &[&str]) -> Result<()> {
    let time = match options {
        ["--cluster", options @ ..] => return cluster::run(options),
        [] => None,
        ["--long"] => Some(HOUR),
        ["--minutes", minutes] => {
            let minutes: u64 = minutes.parse().context("--minutes takes a whole number")?;
            Some(Duration::from_secs(60 * minutes))
        }
        other => bail!("unknown options of faults: {}", other.join(" ")),
    };
    shell::run(shell::cargo().args(["build", "--locked", "--package", "brood"]))?;
    let binary = suite::target_directory()?.join("debug/brood");
    let lines = Mutex::new(BTreeMap::<String, Vec<String>>::new());
    let (start, mut passes) = (Instant::now(), 0_u32);
    let outcome = loop {
        let mut tests = shell::cargo();
        tests.args(["test", "--locked", "--package", "brood-tests", "--test", "faults", "--"]);
        tests.args(["--nocapture", "--test-threads", "1"]).env("BROOD_BIN", &binary);
        if time.is_some() {
            tests.env("BROOD_FAULT_ROUNDS", ROUNDS);
        }
        passes += 1;
        let outcome = shell::run_watched(&mut tests, |line| {
            if let Some((_, figures)) = line.split_once(PREFIX) {
                let kind = figures.split(':').next().unwrap_or(figures).to_owned();
                let mut lines = lines.lock().expect("no reader of the output panics");
                lines.entry(kind).or_default().push(figures.to_owned());
            }
        });
        if outcome.is_err() || time.is_none_or(|time| start.elapsed() >= time) {
            break outcome;
        }
    };
    let minutes = start.elapsed().as_secs_f64() / 60.0;
    println!("\nfaults: {passes} passes in {minutes:.0} minutes; the figures of the last:");
    let lines = lines.into_inner().expect("no reader of the output panics");
    for figures in lines.values() {
        let each = figures.len() / passes as usize;
        figures.iter().rev().take(each.max(1)).rev().for_each(|line| println!("  {line}"));
    }
    outcome.context("a fault was not survived")
}
