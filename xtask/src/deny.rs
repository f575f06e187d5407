//! `cargo xtask deny`: checks licences, sources and advisories of all dependencies by `deny.toml`,
//! with cargo-deny.

use std::path::PathBuf;
use std::process::Command;

use anyhow::{Context, Result};

use crate::{shell, suite};

const VERSION: &str = "0.20.2";

/// Runs the checks. The advisories are skipped, with a line that says so, where their database
/// cannot be fetched.
pub fn run() -> Result<()> {
    let program = install()?;
    let deny = || {
        let mut command = shell::command(&program);
        command.arg("--locked");
        command
    };
    let rules = shell::run(deny().args(["check", "licenses", "bans", "sources"]));
    let advisories = match shell::run(deny().args(["fetch", "db"])) {
        Ok(()) => shell::run(deny().args(["--offline", "check", "advisories"])),
        Err(error) => {
            println!("skipped: advisories, whose database cannot be fetched: {error:#}");
            Ok(())
        }
    };
    rules.and(advisories)
}

/// Installs this version of cargo-deny below the target directory, unless it is there. A build
/// without optimisation takes 40 s; the checks take 2 s with it.
fn install() -> Result<PathBuf> {
    let root = suite::target_directory()?.join("tools");
    let program = root.join("bin").join(format!("cargo-deny{}", std::env::consts::EXE_SUFFIX));
    let found = Command::new(&program).arg("--version").output();
    if !found.is_ok_and(|said| String::from_utf8_lossy(&said.stdout).contains(VERSION)) {
        let mut cargo = shell::cargo();
        cargo.env("CARGO_PROFILE_DEV_DEBUG", "false").env("CARGO_PROFILE_DEV_OPT_LEVEL", "0");
        cargo.args(["install", "cargo-deny", "--version", VERSION, "--locked", "--debug"]);
        cargo.args(["--quiet", "--root"]).arg(&root);
        shell::run(&mut cargo).context("install cargo-deny")?;
    }
    Ok(program)
}
