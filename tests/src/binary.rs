//! The binary under test, and its offline commands.
//!
//! Owns where the binary is looked for. Refuses to build it: whoever starts the tests has built everything once.

use std::path::PathBuf;
use std::process::{Command, Stdio};

/// The built `brood`: `$BROOD_BIN`, else the one beside this test's own executable.
///
/// # Panics
/// Where there is none, with a sentence on what to do.
#[must_use]
pub fn binary() -> PathBuf {
    if let Some(path) = std::env::var_os("BROOD_BIN") {
        let path = PathBuf::from(path);
        assert!(path.is_file(), "$BROOD_BIN names no file; run `cargo xtask test`");
        return path;
    }
    let name = format!("brood{}", std::env::consts::EXE_SUFFIX);
    let path = profile_directory().join(name);
    assert!(path.is_file(), "brood is not built: run `cargo xtask test`, or `cargo build` first");
    path
}

/// Cargo's target directory.
#[must_use]
pub fn target_directory() -> PathBuf {
    let profile = profile_directory();
    profile.parent().expect("a profile's folder lies in the target directory").to_path_buf()
}

fn profile_directory() -> PathBuf {
    let own = std::env::current_exe().expect("a test knows its own executable");
    let deps = own.parent().expect("an executable lies in a folder");
    deps.parent().expect("test executables lie in target/<profile>/deps").to_path_buf()
}

/// An offline command that has ended.
#[derive(Debug)]
pub struct Finished {
    /// Exit code; -1 where a signal ended it.
    pub code: i32,
    /// What it printed.
    pub stdout: String,
    /// What it complained about.
    pub stderr: String,
}

/// Runs `brood` with these arguments and nothing to read.
///
/// # Panics
/// Where the binary cannot be started.
#[must_use]
pub fn brood<S: AsRef<std::ffi::OsStr>>(arguments: impl IntoIterator<Item = S>) -> Finished {
    let output = Command::new(binary())
        .args(arguments)
        .stdin(Stdio::null())
        .output()
        .expect("the built brood can be started");
    Finished {
        code: output.status.code().unwrap_or(-1),
        stdout: String::from_utf8_lossy(&output.stdout).into_owned(),
        stderr: String::from_utf8_lossy(&output.stderr).into_owned(),
    }
}

impl Finished {
    /// Insists on exit code 0.
    ///
    /// # Panics
    /// Where the command failed, with what it said.
    #[track_caller]
    pub fn success(self) -> Self {
        assert_eq!(self.code, 0, "brood failed\nstdout: {}\nstderr: {}", self.stdout, self.stderr);
        self
    }
}
