//! Python environments with packages of exact versions, and a libLLVM for Mitsuba.
//!
//! Everything is installed below the target folder, except the Debian package of libLLVM.

use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result};

use crate::{prerequisite, shell};

/// Debian packages of the libLLVM versions that Mitsuba's compiler supports.
const LLVM_PACKAGES: [&str; 3] = ["libllvm19", "libllvm20", "libllvm21"];
/// Oldest supported version.
const LLVM_OLDEST: u32 = 19;
/// Environment variable with the path of libLLVM for Mitsuba.
const LLVM_VARIABLE: &str = "DRJIT_LIBLLVM_PATH";

/// A Python environment of its own.
pub struct Python {
    venv: PathBuf,
    /// Home directory of its programs, so that kernels compiled elsewhere are not reused.
    home: PathBuf,
    llvm: Option<PathBuf>,
}

impl Python {
    /// The environment in a folder, which need not exist yet.
    pub fn at(folder: &Path) -> Self {
        Self { venv: folder.join("venv"), home: folder.join("home"), llvm: None }
    }

    /// Makes the environment unless it is there.
    pub fn prepare(&self) -> Result<()> {
        std::fs::create_dir_all(&self.home)
            .with_context(|| format!("create {}", self.home.display()))?;
        if self.program().is_file() {
            return Ok(());
        }
        shell::run(shell::command("python3").args(["-m", "venv"]).arg(&self.venv))
            .context("make a Python environment (on Debian: python3-venv)")
    }

    /// Installs the packages that a file lists.
    pub fn install(&self, list: &Path) -> Result<()> {
        let mut pip = self.pip();
        // Wheels only: building such a package from source takes an hour, and users do not do it.
        pip.args(["--only-binary", ":all:", "--requirement"]).arg(list);
        shell::run(&mut pip).context("install it from PyPI")
    }

    fn pip(&self) -> Command {
        let mut pip = shell::command(self.program());
        pip.args(["-m", "pip", "install", "--quiet", "--no-input", "--disable-pip-version-check"]);
        pip
    }

    /// Command that runs a program of an installed package.
    pub fn tool(&self, name: &str) -> Command {
        let mut command = shell::command(self.venv.join("bin").join(name));
        command.env("HOME", &self.home);
        command
    }

    fn program(&self) -> PathBuf {
        self.venv.join("bin/python")
    }

    /// Command that runs Python.
    pub fn command(&self) -> Command {
        let mut command = shell::command(self.program());
        command.env("HOME", &self.home).env("PYTHONDONTWRITEBYTECODE", "1");
        if let Some(llvm) = &self.llvm {
            command.env(LLVM_VARIABLE, llvm);
        }
        command
    }

    /// Finds a libLLVM for Mitsuba, or installs one, and passes its path to commands.
    pub fn find_llvm(&mut self) -> Result<()> {
        self.llvm = Some(find_or_install_llvm()?);
        Ok(())
    }

    /// File name of the libLLVM that was found.
    pub fn llvm_name(&self) -> Option<String> {
        Some(self.llvm.as_ref()?.file_name()?.to_string_lossy().into_owned())
    }

    /// Removes Mitsuba's cache of compiled kernels.
    pub fn clear_kernel_cache(&self) -> Result<()> {
        match std::fs::remove_dir_all(self.home.join(".drjit")) {
            Err(error) if error.kind() != std::io::ErrorKind::NotFound => {
                Err(error).context("remove the cache of compiled kernels")
            }
            _ => Ok(()),
        }
    }
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
