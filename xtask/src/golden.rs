//! Golden images: compares them on their own, or rewrites them.
//!
//! Independent of the pictures: the `golden` test of the tests package renders and compares them,
//! and leaves its report in target/golden/.

use anyhow::Result;

use crate::shell;
use crate::suite::target_directory;

/// Builds `brood`, then compares (or rewrites) every case of tests/golden/.
pub fn run(update: bool) -> Result<()> {
    // Builds the whole workspace, although one binary is needed: cargo unifies features over the
    // requested packages, so that the same request as in the full suite reuses its build.
    shell::run(shell::cargo().args(["build", "--workspace", "--bins"]))?;
    let target = target_directory()?;
    let mut test = shell::cargo();
    test.args(["test", "--workspace", "--test", "golden", "--", "--nocapture"]);
    test.env("BROOD_BIN", target.join("debug/brood"));
    if update {
        test.env("BROOD_GOLDEN_UPDATE", "1");
    }
    let outcome = shell::run(&mut test);
    println!("report: {}", target.join("golden/index.html").display());
    outcome
}
