//! The whole suite: one build, then every check there is, then one table of what passed.
//!
//! Owns the order of the steps and the closing lines. Refuses to stop at the first failure: a run on a slow machine
//! should say everything that is wrong. Only a failed build ends it early, since nothing after it could mean anything.

use std::path::PathBuf;
use std::process::Command;
use std::sync::Mutex;
use std::time::Instant;

use anyhow::{Context, Result, bail};

use crate::prerequisite::Prerequisites;
use crate::{accept, callgrind, shell, tidy};

/// The result of one step.
struct Step {
    name: &'static str,
    seconds: f64,
    outcome: Result<()>,
}

/// Runs everything.
pub fn run() -> Result<()> {
    let found = Prerequisites::install();
    let target = target_directory()?;
    let mut steps = Vec::new();

    step(&mut steps, "format", || {
        shell::run(shell::cargo().args(["fmt", "--all", "--", "--check"]))
    });
    step(&mut steps, "tidy", tidy::run);
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
        step(&mut steps, "doc tests", || {
            shell::run(prepared(shell::cargo(), &found, &target).args([
                "test",
                "--workspace",
                "--doc",
                "--quiet",
            ]))
        });
        step(&mut steps, "acceptance, short form", || accept::short(&target, &found));
        step(&mut steps, "instruction counts", || callgrind::guard(&target));
        step(&mut steps, "page: types and unit tests", page);
        step(&mut steps, "browser journey", || browser(&found, &target));
    }
    report(&steps, closing)
}

/// The folder that cargo builds into.
pub fn target_directory() -> Result<PathBuf> {
    let text = shell::output(shell::cargo().args([
        "metadata",
        "--no-deps",
        "--format-version",
        "1",
        "--locked",
    ]))?;
    let metadata: serde_json::Value =
        serde_json::from_str(&text).context("read cargo metadata's answer")?;
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

/// A command with the environment that tests read.
fn prepared(mut command: Command, found: &Prerequisites, target: &std::path::Path) -> Command {
    found.apply(&mut command);
    command.env("BROOD_BIN", target.join("debug/brood"));
    command
}

/// Unit, API, golden and fault tests, by nextest where it is there; also the runner's own closing line.
fn tests(found: &Prerequisites, target: &std::path::Path) -> (Result<()>, Option<String>) {
    let mut command = prepared(shell::cargo(), found, target);
    if found.nextest {
        command.args(["nextest", "run", "--workspace", "--no-fail-fast"]);
    } else {
        command.args(["test", "--workspace", "--all-targets", "--no-fail-fast"]);
    }
    let closing = Mutex::new(Closing::default());
    let outcome = shell::run_watched(&mut command, |line| {
        closing.lock().expect("no reader of the output panics").see(line);
    });
    let line = closing.into_inner().expect("no reader of the output panics").line();
    (outcome, line)
}

/// The page's own checks: its types, and those of its modules that need no browser.
fn page() -> Result<()> {
    let types = shell::run(shell::command("node").args([
        "tests/browser/node_modules/typescript/bin/tsc",
        "-p",
        "web/jsconfig.json",
    ]));
    // Each file by name: what a folder means to `node --test` changed between its versions.
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
    types.and(tests)
}

fn browser(found: &Prerequisites, target: &std::path::Path) -> Result<()> {
    if found.chromium.is_none() {
        bail!("no browser: install chromium, or name one in $CHROMIUM");
    }
    let mut node = prepared(shell::command("node"), found, target);
    node.arg("tests/browser/journey.mjs").env("BROOD_PICTURES", target.join("browser"));
    shell::run(&mut node)
}

/// Ends with the test runner's own closing line; failures of other steps stand after it.
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

/// Gathers what the test runner says at its end.
#[derive(Default)]
struct Closing {
    summary: Option<String>,
    passed: u64,
    failed: u64,
    binaries: u64,
}

impl Closing {
    /// nextest says it all in one line; the built-in runner has one line for each test binary, which are added up.
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
    use super::Closing;

    #[test]
    fn closing_line_is_nextests_own_when_there_is_one() {
        let mut closing = Closing::default();
        closing.see("        PASS [   0.010s] crate a::b");
        closing.see("     Summary [   1.234s] 3 tests run: 3 passed, 0 skipped");
        assert_eq!(
            closing.line().as_deref(),
            Some("Summary [   1.234s] 3 tests run: 3 passed, 0 skipped")
        );
    }

    #[test]
    fn closing_line_adds_up_when_there_is_one_line_a_binary() {
        let mut closing = Closing::default();
        closing.see("test result: ok. 3 passed; 0 failed; 1 ignored; 0 measured; 0 filtered out");
        closing.see("test result: FAILED. 4 passed; 2 failed; 0 ignored; finished in 0.05s");
        assert_eq!(closing.line().as_deref(), Some("test result: FAILED. 7 passed; 2 failed"));
    }

    #[test]
    fn closing_line_is_absent_when_nothing_ran() {
        assert_eq!(Closing::default().line(), None);
    }
}
