//! Golden images: the comparison on its own, and the one command that writes them anew.
//!
//! Owns the switch between comparing and writing. Refuses to know the pictures: they are made and compared by the
//! `golden` test of the tests package, which leaves its report in target/golden/.

use anyhow::Result;

use crate::shell;
use crate::suite::target_directory;

/// Builds `brood`, then compares (or rewrites) every case of tests/golden/.
pub fn run(update: bool) -> Result<()> {
    // The whole workspace, though one binary is wanted: cargo joins features over what it is asked to build, and the
    // same question as in the full suite finds everything built already.
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
