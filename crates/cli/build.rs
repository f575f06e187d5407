//! Names the commit that the binary is built from, for `brood --version`.

use std::path::Path;
use std::process::Command;

fn main() {
    println!("cargo::rerun-if-env-changed=BROOD_COMMIT");
    // Builds from an archive of the source have no repository: the variable names the commit.
    let commit = std::env::var("BROOD_COMMIT").ok().or_else(commit_of_repository);
    let version = env!("CARGO_PKG_VERSION");
    let named = commit.map_or(version.to_owned(), |commit| format!("{version} ({commit})"));
    println!("cargo::rustc-env=BROOD_VERSION={named}");
}

/// Abbreviated hash and date of the commit that is checked out, such as `7f452a18c0de 2026-11-28`.
fn commit_of_repository() -> Option<String> {
    let head = git(&["rev-parse", "--git-path", "HEAD"])?;
    // Each commit and checkout adds a line to this file.
    let log = git(&["rev-parse", "--git-path", "logs/HEAD"])?;
    for file in [head, log].iter().filter(|file| Path::new(file).exists()) {
        println!("cargo::rerun-if-changed={file}");
    }
    // Of a package without a repository, git finds whatever repository the folder lies in.
    git(&["ls-files", "--error-unmatch", "build.rs"])?;
    git(&["log", "-1", "--format=%h %cs", "--abbrev=12"])
}

/// Output of git; `None` if it fails or is not installed.
fn git(arguments: &[&str]) -> Option<String> {
    let output = Command::new("git").args(arguments).output().ok()?;
    let text = String::from_utf8(output.stdout).ok()?;
    output.status.success().then(|| text.trim().to_owned())
}
