//! Environment of a comparison with peers: brood itself, and a Python environment with the peers.
//!
//! Owns versions and paths. The exact versions of all Python packages are in xtask/peer/*.txt, one
//! file per peer, so that one can fail alone.

use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result, bail};
use serde_json::{Value, json};

use super::Options;
use crate::python::Python;
use crate::{shell, suite};

/// Program that brood is compared with.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Peer {
    /// Symbolic regression in C++.
    Operon,
    /// Renderer that compiles materials.
    Mitsuba,
    /// Evolution strategy.
    Cma,
    /// Picture metrics.
    Metrics,
}

impl Peer {
    /// Peers of the speed comparison.
    pub const FAST: [Self; 2] = [Self::Operon, Self::Mitsuba];

    /// Name of the package and of its version list.
    pub fn package(self) -> &'static str {
        match self {
            Self::Operon => "pyoperon",
            Self::Mitsuba => "mitsuba",
            Self::Cma => "cma",
            Self::Metrics => "scikit-image",
        }
    }

    /// Name of the Python module.
    fn module(self) -> &'static str {
        match self {
            Self::Operon | Self::Mitsuba | Self::Cma => self.package(),
            Self::Metrics => "skimage",
        }
    }
}

/// Installed programs, and reasons for missing ones.
pub struct Environment {
    brood: PathBuf,
    profile: &'static str,
    python: Python,
    installed: Vec<(Peer, String)>,
    /// Reasons why peers are missing.
    pub missing: Vec<String>,
}

impl Environment {
    /// Builds brood and installs the peers; a peer that fails is only recorded as missing.
    pub(super) fn prepare(options: &Options, peers: &[Peer]) -> Result<Self> {
        let target = suite::target_directory()?;
        let (brood, profile) = brood(options, &target)?;
        let mut environment = Self {
            brood,
            profile,
            python: Python::at(&target.join("peers")),
            installed: Vec::new(),
            missing: Vec::new(),
        };
        if !peers.is_empty() {
            environment.install(peers);
        }
        Ok(environment)
    }

    fn install(&mut self, peers: &[Peer]) {
        if let Err(error) = self.python.prepare() {
            let why = format!("{error:#}");
            self.missing.extend(peers.iter().map(|peer| format!("{}: {why}", peer.package())));
            return;
        }
        for &peer in peers {
            if let Err(error) = self.install_peer(peer) {
                eprintln!("skipping {}: {error:#}", peer.package());
                self.missing.push(format!("{}: {error:#}", peer.package()));
            }
        }
    }

    fn install_peer(&mut self, peer: Peer) -> Result<()> {
        let list = script(&format!("{}.txt", peer.package()));
        self.python.install(&list)?;
        if peer == Peer::Mitsuba {
            self.python.find_llvm()?;
        }
        let import = format!(
            "import {}; from importlib.metadata import version; print(version('{}'))",
            peer.module(),
            peer.package()
        );
        let version =
            shell::output(self.python.command().args(["-c", &import])).context("import it")?;
        self.installed.push((peer, version.trim().to_owned()));
        Ok(())
    }

    /// True if the peer is installed.
    pub fn has(&self, peer: Peer) -> bool {
        self.installed.iter().any(|(installed, _)| *installed == peer)
    }

    /// Command that runs a script of xtask/peer with the environment's Python.
    pub fn script(&self, name: &str) -> Command {
        let mut command = self.python.command();
        command.arg(script(name));
        command
    }

    /// Removes the peer's cache of compiled kernels.
    pub fn clear_kernel_cache(&self) -> Result<()> {
        self.python.clear_kernel_cache()
    }

    /// Command that runs the measured brood.
    pub fn brood(&self) -> Command {
        shell::command(&self.brood)
    }

    /// Path of the measured brood, for scripts that start it.
    pub fn brood_file(&self) -> &Path {
        &self.brood
    }

    /// Description of the machine and all versions.
    pub fn machine(&self) -> Value {
        let cores = std::thread::available_parallelism().map_or(0, usize::from);
        let versions: serde_json::Map<String, Value> = self
            .installed
            .iter()
            .map(|(peer, version)| (peer.package().to_owned(), json!(version)))
            .collect();
        json!({
            "processor": processor(),
            "cores": cores,
            "brood_profile": self.profile,
            "brood_version": one_line(self.brood().arg("--version")),
            "rustc": one_line(shell::command("rustc").arg("--version")),
            "peers": versions,
            "libllvm": self.python.llvm_name(),
        })
    }
}

/// Path and profile of the measured brood, built unless one is given.
fn brood(options: &Options, target: &Path) -> Result<(PathBuf, &'static str)> {
    if let Some(file) = &options.brood {
        return Ok((file.clone(), "of a given binary"));
    }
    let mut build = shell::cargo();
    build.args(["build", "--package", "brood", "--locked"]);
    let (folder, profile) = if options.release {
        build.arg("--release");
        ("release", "release")
    } else {
        ("debug", "dev")
    };
    shell::run(&mut build)?;
    Ok((target.join(folder).join("brood"), profile))
}

fn script(name: &str) -> PathBuf {
    shell::root().join("xtask/peer").join(name)
}

fn processor() -> String {
    let text = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let line = text.lines().find_map(|line| line.strip_prefix("model name")?.split_once(':'));
    line.map_or_else(|| std::env::consts::ARCH.to_owned(), |(_, name)| name.trim().to_owned())
}

fn one_line(command: &mut Command) -> Option<String> {
    match shell::output(command) {
        Ok(text) => Some(text.trim().to_owned()),
        Err(error) => {
            eprintln!("{error:#}");
            None
        }
    }
}

/// Runs a command and parses each printed line as JSON.
pub fn json_lines(command: &mut Command) -> Result<Vec<Value>> {
    let text = shell::output(command)?;
    let lines: Vec<Value> = text
        .lines()
        .map(|line| serde_json::from_str(line).context("parse a printed line as JSON"))
        .collect::<Result<_>>()?;
    if lines.is_empty() {
        bail!("the command printed nothing");
    }
    Ok(lines)
}

/// Runs a command and parses its output as JSON.
pub fn json_of(command: &mut Command) -> Result<Value> {
    let text = shell::output(command)?;
    let value = serde_json::from_str(&text).context("parse the output as JSON")?;
    if value == Value::Null {
        bail!("the command printed null");
    }
    Ok(value)
}
