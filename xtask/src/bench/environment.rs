//! Environment of a comparison with peers: brood itself, a Python environment with the peers, and a
//! libLLVM for Mitsuba.
//!
//! Owns versions and paths. Everything is installed below the target folder, except the Debian
//! package of libLLVM. The exact versions of all Python packages are in xtask/peer/*.txt, one file
//! per peer, so that one can fail alone.

use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result, bail};
use serde_json::{Value, json};

use super::Options;
use crate::{prerequisite, shell, suite};

/// Debian packages of the libLLVM versions that Mitsuba's compiler supports.
const LLVM_PACKAGES: [&str; 3] = ["libllvm19", "libllvm20", "libllvm21"];
/// Oldest supported version.
const LLVM_OLDEST: u32 = 19;
/// Environment variable with the path of libLLVM for Mitsuba.
const LLVM_VARIABLE: &str = "DRJIT_LIBLLVM_PATH";

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
    python: PathBuf,
    /// Home directory of the peers, below the target folder, so that kernels compiled elsewhere are
    /// not reused.
    home: PathBuf,
    llvm: Option<PathBuf>,
    installed: Vec<(Peer, String)>,
    /// Reasons why peers are missing.
    pub missing: Vec<String>,
}

impl Environment {
    /// Builds brood and installs the peers; a peer that fails is only recorded as missing.
    pub(super) fn prepare(options: &Options, peers: &[Peer]) -> Result<Self> {
        let target = suite::target_directory()?;
        let (brood, profile) = brood(options, &target)?;
        let place = target.join("peers");
        let mut environment = Self {
            brood,
            profile,
            python: place.join("venv/bin/python"),
            home: place.join("home"),
            llvm: None,
            installed: Vec::new(),
            missing: Vec::new(),
        };
        std::fs::create_dir_all(&environment.home).context("create the folder of the peers")?;
        if !peers.is_empty() {
            environment.install(&place.join("venv"), peers);
        }
        Ok(environment)
    }

    fn install(&mut self, venv: &Path, peers: &[Peer]) {
        if let Err(error) = make_venv(venv, &self.python) {
            let why = format!("no Python environment ({error:#}); on Debian: python3-venv");
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
        // Wheels only: building such a package from source takes an hour, and users do not do it.
        let mut pip = shell::command(&self.python);
        pip.args(["-m", "pip", "install", "--quiet", "--no-input", "--disable-pip-version-check"]);
        pip.args(["--only-binary", ":all:", "--requirement"]).arg(list);
        shell::run(&mut pip).context("install it from PyPI")?;
        if peer == Peer::Mitsuba {
            self.llvm = Some(find_or_install_llvm()?);
        }
        let import = format!(
            "import {}; from importlib.metadata import version; print(version('{}'))",
            peer.module(),
            peer.package()
        );
        let version = shell::output(self.python().args(["-c", &import])).context("import it")?;
        self.installed.push((peer, version.trim().to_owned()));
        Ok(())
    }

    /// True if the peer is installed.
    pub fn has(&self, peer: Peer) -> bool {
        self.installed.iter().any(|(installed, _)| *installed == peer)
    }

    /// Command that runs a script of xtask/peer with the environment's Python.
    pub fn script(&self, name: &str) -> Command {
        let mut command = self.python();
        command.arg(script(name));
        command
    }

    fn python(&self) -> Command {
        let mut command = shell::command(&self.python);
        command.env("HOME", &self.home).env("PYTHONDONTWRITEBYTECODE", "1");
        if let Some(llvm) = &self.llvm {
            command.env(LLVM_VARIABLE, llvm);
        }
        command
    }

    /// Removes the peer's cache of compiled kernels.
    pub fn clear_kernel_cache(&self) -> Result<()> {
        match std::fs::remove_dir_all(self.home.join(".drjit")) {
            Err(error) if error.kind() != std::io::ErrorKind::NotFound => {
                Err(error).context("remove the peer's kernel cache")
            }
            _ => Ok(()),
        }
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
        let library = self.llvm.as_ref().and_then(|path| path.file_name());
        json!({
            "processor": processor(),
            "cores": cores,
            "brood_profile": self.profile,
            "brood_version": one_line(self.brood().arg("--version")),
            "rustc": one_line(shell::command("rustc").arg("--version")),
            "peers": versions,
            "libllvm": library.map(|name| name.to_string_lossy()),
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

fn make_venv(venv: &Path, python: &Path) -> Result<()> {
    if python.is_file() {
        return Ok(());
    }
    shell::run(shell::command("python3").args(["-m", "venv"]).arg(venv))
}

fn find_or_install_llvm() -> Result<PathBuf> {
    if let Some(path) = std::env::var_os(LLVM_VARIABLE) {
        return Ok(path.into());
    }
    if let Some(found) = find_llvm() {
        return Ok(found);
    }
    println!("missing: libLLVM, {LLVM_OLDEST} or newer (Debian: {})", LLVM_PACKAGES[0]);
    for package in LLVM_PACKAGES {
        match prerequisite::install_debian(&[package]) {
            Ok(()) => break,
            Err(error) => eprintln!("could not install {package}: {error:#}"),
        }
    }
    find_llvm().with_context(|| {
        format!("no libLLVM {LLVM_OLDEST} or newer: install one, or name it in ${LLVM_VARIABLE}")
    })
}

/// Newest supported libLLVM in the folders of Debian's packages.
fn find_llvm() -> Option<PathBuf> {
    let of_architecture = format!("/usr/lib/{}-linux-gnu", std::env::consts::ARCH);
    let own = std::fs::read_dir("/usr/lib").into_iter().flatten().filter_map(|entry| {
        let path = entry.ok()?.path();
        path.file_name()?.to_str()?.starts_with("llvm-").then(|| path.join("lib"))
    });
    std::iter::once(PathBuf::from(of_architecture))
        .chain(own)
        .filter_map(|folder| std::fs::read_dir(folder).ok())
        .flatten()
        .filter_map(|entry| {
            let path = entry.ok()?.path();
            let version = llvm_version(path.file_name()?.to_str()?)?;
            (version >= LLVM_OLDEST && path.exists()).then_some((version, path))
        })
        .max()
        .map(|(_, path)| path)
}

/// Major version in names such as `libLLVM-19.so`, `libLLVM-19.so.1` and `libLLVM.so.19.1`.
fn llvm_version(name: &str) -> Option<u32> {
    let rest = name.strip_prefix("libLLVM")?;
    if !rest.contains(".so") {
        return None;
    }
    let digits = rest.trim_start_matches(['-', '.', 's', 'o']);
    let end = digits.find(|c: char| !c.is_ascii_digit()).unwrap_or(digits.len());
    digits[..end].parse().ok()
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

#[cfg(test)]
mod tests {
    use super::llvm_version;

    #[test]
    fn libllvm_is_recognised_in_all_forms_of_its_name() {
        for name in ["libLLVM-19.so", "libLLVM-19.so.1", "libLLVM.so.19.1", "libLLVM-19.1.so"] {
            assert_eq!(llvm_version(name), Some(19), "{name}");
        }
        assert_eq!(llvm_version("libLLVM-14.0.6.so.1"), Some(14));
        for name in ["libLLVM.so", "libLLVM-19.a", "libLTO.so.19", "libLLVMSupport.a"] {
            assert_eq!(llvm_version(name), None, "{name}");
        }
    }
}
