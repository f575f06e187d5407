//! Quick loop: everything that can be checked without building wgpu.
//!
//! Owns the list of packages left out of it.

use anyhow::Result;

use crate::shell;

/// Packages that need wgpu, a built server, or a browser.
const LEFT_OUT: [&str; 2] = ["brood-gpu", "brood-tests"];

/// Checks the workspace and runs the unit tests of libraries and binaries, without the `gpu`
/// feature.
pub fn run() -> Result<()> {
    let mut check = shell::cargo();
    check.args(["check", "--workspace", "--all-targets", "--no-default-features"]);
    shell::run(exclude(&mut check))?;
    let mut test = shell::cargo();
    test.args(["test", "--workspace", "--lib", "--bins", "--no-default-features"]);
    shell::run(exclude(&mut test))
}

fn exclude(command: &mut std::process::Command) -> &mut std::process::Command {
    for package in LEFT_OUT {
        command.args(["--exclude", package]);
    }
    command
}
