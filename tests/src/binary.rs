//! Binary under test and its offline commands.
//!
//! Finds the binary but does not build it: the test runner must have built everything.

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use crate::database;

/// Returns the built `brood`: `$BROOD_BIN`, else the binary next to the test's own executable.
///
/// # Panics
/// If there is none; the message names the command to build it.
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

/// Returns cargo's target directory.
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

/// Finished offline command.
#[derive(Debug)]
pub struct Finished {
    /// Exit code; -1 if a signal ended it.
    pub code: i32,
    /// Text on stdout.
    pub stdout: String,
    /// Text on stderr.
    pub stderr: String,
}

/// Runs `brood` with these arguments and empty stdin.
///
/// # Panics
/// If the binary cannot be started.
#[must_use]
pub fn brood<S: AsRef<std::ffi::OsStr>>(arguments: impl IntoIterator<Item = S>) -> Finished {
    let arguments: Vec<_> =
        arguments.into_iter().map(|argument| argument.as_ref().to_owned()).collect();
    let data = arguments.iter().skip_while(|argument| *argument != "--data").nth(1);
    let database = data.and_then(|data| database::of(Path::new(data)));
    let output = Command::new(binary())
        .args(arguments)
        .envs(database.map(|address| ("BROOD_DATABASE", address)))
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
    /// Asserts exit code 0.
    ///
    /// # Panics
    /// If the command failed; quotes its stderr.
    #[track_caller]
    pub fn success(self) -> Self {
        assert_eq!(self.code, 0, "brood failed\nstdout: {}\nstderr: {}", self.stdout, self.stderr);
        self
    }
}
