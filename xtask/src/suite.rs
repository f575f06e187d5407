//! Full test suite: one build, then all checks, then a table of the results.
//!
//! Owns the order of the steps and the summary. A failed step does not stop the run, so that one
//! slow run reports every problem; only a failed build does, because the later steps need it.

use std::path::PathBuf;
use std::process::Command;
use std::sync::Mutex;
use std::time::Instant;

use anyhow::{Context, Result, bail};

use crate::prerequisite::Prerequisites;
use crate::{accept, callgrind, contract, deny, packaging, postgres, shell, tidy, wheel};

/// Result of one step.
struct Step {
    name: &'static str,
    seconds: f64,
    outcome: Result<()>,
}

/// Runs all steps.
pub fn run() -> Result<()> {
    let found = Prerequisites::install();
    let target = target_directory()?;
    let mut steps = Vec::new();

    step(&mut steps, "format", || {
        shell::run(shell::cargo().args(["fmt", "--all", "--", "--check"]))
    });
    step(&mut steps, "tidy", || tidy::run(&[]));
    step(&mut steps, "dependencies", deny::run);
    step(&mut steps, "packaging", || packaging::check(&target));
    let built = step(&mut steps, "build", || {
        shell::run(shell::cargo().args(["build", "--workspace", "--all-targets", "--locked"]))
    });
    let mut closing = None;
    if built {
        step(&mut steps, "clippy", || {
            let mut clippy = shell::cargo();
            clippy.args(["clippy", "--workspace", "--all-targets", "--", "-D", "warnings"]);
            shell::run(&mut clippy)
        });
        step(&mut steps, "tests", || {
            let (outcome, line) = tests(&found, &target);
            closing = line;
            outcome
        });
        step(&mut steps, "tests on PostgreSQL", || postgres::short(&target, &found));
        step(&mut steps, "doc tests", || {
            shell::run(prepared(shell::cargo(), &found, &target).args([
                "test",
                "--workspace",
                "--doc",
                "--quiet",
            ]))
        });
        step(&mut steps, "acceptance, short form", || accept::short(&target, &found));
        step(&mut steps, "Python package", || wheel::test(&target, &target.join("debug/brood")));
        step(&mut steps, "contract, short form", || contract::short(&target));
        step(&mut steps, "instruction counts", || callgrind::guard(&target));
        step(&mut steps, "openapi.json; page: types and unit tests", page);
        step(&mut steps, "browser journey", || browser(&found, &target));
    }
    report(&steps, closing)
}

/// Target directory of cargo.
pub fn target_directory() -> Result<PathBuf> {
    let text = shell::output(shell::cargo().args([
        "metadata",
        "--no-deps",
        "--format-version",
        "1",
        "--locked",
    ]))?;
    let metadata: serde_json::Value =
        serde_json::from_str(&text).context("parse the output of cargo metadata")?;
    let folder = metadata["target_directory"].as_str().context("find the target directory")?;
    Ok(PathBuf::from(folder))
}

fn step(steps: &mut Vec<Step>, name: &'static str, work: impl FnOnce() -> Result<()>) -> bool {
    println!("\n== {name}");
    let start = Instant::now();
    let outcome = work();
    if let Err(error) = &outcome {
        eprintln!("{name} failed: {error:#}");
    }
    let passed = outcome.is_ok();
    steps.push(Step { name, seconds: start.elapsed().as_secs_f64(), outcome });
    passed
}

/// Adds the environment variables that tests read to a command.
pub fn prepared(mut command: Command, found: &Prerequisites, target: &std::path::Path) -> Command {
    found.apply(&mut command);
    command.env("BROOD_BIN", target.join("debug/brood"));
    command
}

/// Runs unit, API, golden and fault tests, with nextest if it is installed. Also returns the
/// runner's summary line.
fn tests(found: &Prerequisites, target: &std::path::Path) -> (Result<()>, Option<String>) {
    let mut command = prepared(shell::cargo(), found, target);
    if found.nextest {
        command.args(["nextest", "run", "--workspace", "--no-fail-fast"]);
    } else {
        command.args(["test", "--workspace", "--all-targets", "--no-fail-fast"]);
    }
    let closing = Mutex::new(RunnerSummary::default());
    let outcome = shell::run_watched(&mut command, |line| {
        closing.lock().expect("no reader of the output panics").see(line);
    });
    let line = closing.into_inner().expect("no reader of the output panics").line();
    (outcome, line)
}

/// Validates openapi.json, checks the page's types, and runs the tests of its modules that need no
/// browser.
fn page() -> Result<()> {
    let document = shell::run(shell::command("node").arg("tests/browser/openapi.mjs"));
    let generated = shell::run(shell::command("node").args(["tests/browser/types.mjs", "--check"]));
    let types = shell::run(shell::command("node").args([
        "tests/browser/node_modules/typescript/bin/tsc",
        "-p",
        "web/jsconfig.json",
    ]));
    // Each file is named, because the meaning of a folder differs between versions of `node
    // --test`.
    let mut files: Vec<PathBuf> = std::fs::read_dir(shell::root().join("web/test"))
        .context("list the page's tests")?
        .filter_map(|entry| Some(entry.ok()?.path()))
        .filter(|path| path.extension().is_some_and(|extension| extension == "js"))
        .collect();
    files.sort();
    if files.is_empty() {
        bail!("web/test holds no test");
    }
    let tests = shell::run(shell::command("node").arg("--test").args(files));
    document.and(generated).and(types).and(tests)
}

fn browser(found: &Prerequisites, target: &std::path::Path) -> Result<()> {
    if found.chromium.is_none() {
        bail!("no browser found: install chromium, or set $CHROMIUM to its path");
    }
    let mut node = prepared(shell::command("node"), found, target);
    node.arg("tests/browser/journey.mjs").env("BROOD_PICTURES", target.join("browser"));
    shell::run(&mut node)
}

/// Prints the results and the test runner's summary; returns an error with the names of the failed
/// steps.
fn report(steps: &[Step], closing: Option<String>) -> Result<()> {
    println!("\n== summary");
    for step in steps {
        let word = if step.outcome.is_ok() { "passed" } else { "FAILED" };
        println!("{word}  {:>7.1} s  {}", step.seconds, step.name);
    }
    if let Some(line) = closing {
        println!("{line}");
    }
    let failed: Vec<&str> =
        steps.iter().filter(|step| step.outcome.is_err()).map(|step| step.name).collect();
    if failed.is_empty() { Ok(()) } else { bail!("failed: {}", failed.join(", ")) }
}

/// Collects the summary of the test runner.
#[derive(Default)]
struct RunnerSummary {
    summary: Option<String>,
    passed: u64,
    failed: u64,
    binaries: u64,
}

impl RunnerSummary {
    /// nextest prints one summary line; the built-in runner prints one per test binary, which are
    /// added up.
    fn see(&mut self, line: &str) {
        let line = line.trim();
        if line.starts_with("Summary [") {
            self.summary = Some(line.to_owned());
        } else if let Some(rest) = line.strip_prefix("test result: ") {
            let count = |word: &str| {
                rest.split([';', '.'])
                    .find_map(|part| part.trim().strip_suffix(word)?.trim().parse::<u64>().ok())
                    .unwrap_or(0)
            };
            self.passed += count("passed");
            self.failed += count("failed");
            self.binaries += 1;
        }
    }

    fn line(self) -> Option<String> {
        if self.summary.is_some() {
            return self.summary;
        }
        let word = if self.failed == 0 { "ok" } else { "FAILED" };
        (self.binaries > 0)
            .then(|| format!("test result: {word}. {} passed; {} failed", self.passed, self.failed))
    }
}

#[cfg(test)]
mod tests {
    use super::RunnerSummary;

    #[test]
    fn summary_line_is_nextests_own_when_there_is_one() {
        let mut closing = RunnerSummary::default();
        closing.see("        PASS [   0.010s] crate a::b");
        closing.see("     Summary [   1.234s] 3 tests run: 3 passed, 0 skipped");
        assert_eq!(
            closing.line().as_deref(),
            Some("Summary [   1.234s] 3 tests run: 3 passed, 0 skipped")
        );
    }

    #[test]
    fn summary_line_adds_up_when_there_is_one_line_per_binary() {
        let mut closing = RunnerSummary::default();
        closing.see("test result: ok. 3 passed; 0 failed; 1 ignored; 0 measured; 0 filtered out");
        closing.see("test result: FAILED. 4 passed; 2 failed; 0 ignored; finished in 0.05s");
        assert_eq!(closing.line().as_deref(), Some("test result: FAILED. 7 passed; 2 failed"));
    }

    #[test]
    fn summary_line_is_absent_when_nothing_ran() {
        assert_eq!(RunnerSummary::default().line(), None);
    }
}
