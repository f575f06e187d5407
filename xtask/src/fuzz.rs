//! `cargo xtask fuzz`: feeds every parser with inputs that libFuzzer makes.
//!
//! The build needs no nightly compiler: coverage comes from LLVM's options, and there is no
//! sanitizer, as the parsers are safe Rust.

use std::path::{Path, PathBuf};
use std::sync::Mutex;

use anyhow::{Context, Result, bail, ensure};

use crate::{shell, suite};

/// Total time if none is given.
const MINUTES: f64 = 15.0;
/// Options of the compiler that record which code an input runs.
const COVERAGE: &str = "-Cpasses=sancov-module -Cllvm-args=-sanitizer-coverage-level=4 \
    -Cllvm-args=-sanitizer-coverage-inline-8bit-counters \
    -Cllvm-args=-sanitizer-coverage-pc-table -Cllvm-args=-sanitizer-coverage-trace-compares \
    -Ccodegen-units=1 -Cdebug-assertions -Coverflow-checks";
/// Largest input in bytes, largest memory in MiB, longest time in seconds.
const LIMITS: [&str; 4] =
    ["-max_len=65536", "-rss_limit_mb=2048", "-malloc_limit_mb=512", "-timeout=20"];

/// Runs the parsers with these names, or all, for `--minutes N` together.
pub fn run(options: &[&str]) -> Result<()> {
    let mut minutes = MINUTES;
    let mut wanted = Vec::new();
    let mut options = options.iter();
    while let Some(option) = options.next() {
        if *option == "--minutes" {
            let value = options.next().context("--minutes takes a number")?;
            minutes = value.parse().context("--minutes takes a number")?;
        } else {
            wanted.push(*option);
        }
    }
    let seeds = shell::root().join("fuzz/seeds");
    let parsers = names(&seeds)?;
    for name in &wanted {
        ensure!(
            parsers.iter().any(|known| known == name),
            "no parser {name}: {}",
            parsers.join(", ")
        );
    }
    let parsers: Vec<_> = parsers
        .iter()
        .filter(|name| wanted.is_empty() || wanted.contains(&name.as_str()))
        .collect();
    let target = suite::target_directory()?.join("fuzz");
    let binary = build(&target)?;
    let seconds = (minutes * 60.0 / parsers.len() as f64).max(1.0) as u64;
    let mut lines = Vec::new();
    let mut failed = Vec::new();
    for name in parsers {
        let (line, outcome) = feed(&binary, &target, &seeds.join(name), name, seconds)?;
        println!("{line}");
        lines.push(line);
        if outcome.is_err() {
            failed.push(name.as_str());
        }
    }
    println!("\nfuzz:");
    lines.iter().for_each(|line| println!("  {line}"));
    if failed.is_empty() {
        return Ok(());
    }
    bail!("{} failed; the inputs are in {}", failed.join(", "), target.join("found").display())
}

/// Names of the parsers: the folders of seeds.
fn names(seeds: &Path) -> Result<Vec<String>> {
    let folders = std::fs::read_dir(seeds).context("list the seeds")?;
    let mut names = Vec::new();
    for folder in folders {
        names.push(folder?.file_name().to_string_lossy().into_owned());
    }
    names.sort();
    Ok(names)
}

/// Builds the fuzzer; returns its path.
fn build(target: &Path) -> Result<PathBuf> {
    let host = shell::output(shell::command("rustc").arg("-vV"))?;
    let host =
        host.lines().find_map(|line| line.strip_prefix("host: ")).context("find the host")?;
    let mut cargo = shell::cargo();
    cargo.args(["build", "--locked", "--release", "--package", "brood-fuzz"]);
    // A named target keeps the options away from build scripts.
    cargo.args(["--features", "libfuzzer", "--target", host, "--target-dir"]).arg(target);
    cargo.env("RUSTFLAGS", COVERAGE).env("CARGO_PROFILE_RELEASE_LTO", "off");
    shell::run(&mut cargo)?;
    Ok(target.join(host).join("release/fuzz"))
}

/// Runs one parser; returns a line of figures. Inputs that reach new code are kept in the target
/// folder for the next run.
fn feed(
    binary: &Path,
    target: &Path,
    seeds: &Path,
    name: &str,
    seconds: u64,
) -> Result<(String, Result<()>)> {
    let (corpus, found) = (target.join("corpus").join(name), target.join("found"));
    std::fs::create_dir_all(&corpus)?;
    std::fs::create_dir_all(&found)?;
    let mut command = shell::command(binary);
    command.env("BROOD_PARSER", name).args([&corpus, seeds]).args(LIMITS);
    command.arg(format!("-max_total_time={seconds}")).arg("-print_final_stats=1");
    command.arg(format!("-artifact_prefix={}/{name}-", found.display()));
    let figures = Mutex::new((0_u64, 0_u64));
    let outcome = shell::run_watched(&mut command, |line| {
        let mut figures = figures.lock().expect("no reader of the output panics");
        let number = |text: &str| text.trim().parse().unwrap_or(0);
        if let Some(count) = line.strip_prefix("stat::number_of_executed_units:") {
            figures.0 = number(count);
        } else if let Some(mib) = line.strip_prefix("stat::peak_rss_mb:") {
            figures.1 = number(mib);
        }
    });
    let (inputs, mib) = figures.into_inner().expect("no reader of the output panics");
    let word = if outcome.is_ok() { "no failure" } else { "FAILED" };
    Ok((format!("{name}: {inputs} inputs in {seconds} s, {mib} MiB at most, {word}"), outcome))
}
