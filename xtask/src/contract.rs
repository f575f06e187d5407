//! `cargo xtask contract`: calls every route of a server as `openapi.json` describes it, and as it
//! does not, with schemathesis.

use std::path::Path;

use anyhow::{Context, Result, bail};

use crate::python::Python;
use crate::{shell, suite};

/// Time of the short form, which is part of the test suite.
const SHORT_SECONDS: u64 = 60;

/// Builds the server and runs the test, with `--minutes N` for that time.
pub fn run(options: &[&str]) -> Result<()> {
    let seconds = match options {
        [] => SHORT_SECONDS,
        ["--minutes", minutes] => {
            60 * minutes.parse::<u64>().context("--minutes takes a whole number")?
        }
        other => bail!("unknown options of contract: {}", other.join(" ")),
    };
    shell::run(shell::cargo().args(["build", "--locked", "--package", "brood"]))?;
    test(&suite::target_directory()?, seconds)
}

/// Runs the short form with the binary of the last build.
pub fn short(target: &Path) -> Result<()> {
    test(target, SHORT_SECONDS)
}

fn test(target: &Path, seconds: u64) -> Result<()> {
    let folder = shell::root().join("tests/contract");
    let python = Python::at(&target.join("contract"));
    python.prepare()?;
    python.install(&folder.join("packages.txt"))?;
    let mut command = python.command();
    command.arg(folder.join("run.py")).arg(seconds.to_string());
    command.env("BROOD_BIN", target.join("debug/brood"));
    shell::run(&mut command).context("the server does not do what openapi.json says")
}
