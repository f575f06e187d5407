//! The Python package: `cargo xtask wheel`, and the step of `cargo xtask test` that tests it.
//!
//! A person gets a wheel in the release profile from maturin. The test packs the library that the
//! build of the workspace left in the target folder, so that nothing is compiled twice, and
//! installs the wheel into an environment of its own.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail};

use crate::python::Python;
use crate::shell;
use crate::suite::target_directory;

/// Builds the wheel and prints how to install it.
pub fn run() -> Result<()> {
    println!("pip install {}", build()?.display());
    Ok(())
}

/// Builds the wheel in the release profile, into `target/wheels`, and returns its path.
pub fn build() -> Result<PathBuf> {
    let target = target_directory()?;
    let python = Python::at(&target.join("maturin"));
    python.prepare()?;
    python.install(&peer("maturin.txt"))?;
    let out = target.join("wheels");
    let mut maturin = python.command();
    maturin.args(["-m", "maturin", "build", "--release", "--locked", "--manifest-path"]);
    maturin.arg(shell::root().join("python/Cargo.toml")).arg("--out").arg(&out);
    // The home of the environment has no toolchain.
    if let Some(home) = std::env::var_os("HOME") {
        maturin.env("HOME", home);
    }
    maturin.env("CARGO_TARGET_DIR", &target);
    shell::run(&mut maturin)?;
    newest(&out)
}

/// Tests the package of the last build of the workspace.
pub fn test_built() -> Result<()> {
    let target = target_directory()?;
    test(&target, &target.join("debug/brood"))
}

/// Installs the package that was built in the dev profile, and runs its tests: pytest with the
/// notebooks of docs, then mypy.
pub fn test(target: &Path, brood: &Path) -> Result<()> {
    let folder = target.join("python-package");
    let packed = folder.join("wheels");
    // Nothing of an earlier version may be found by the tests.
    for stale in [folder.join("venv"), packed.clone()] {
        match std::fs::remove_dir_all(&stale) {
            Err(error) if error.kind() != std::io::ErrorKind::NotFound => {
                return Err(error).with_context(|| format!("remove {}", stale.display()));
            }
            _ => {}
        }
    }
    let python = Python::at(&folder);
    python.prepare()?;
    python.install(&peer("python-package.txt"))?;
    let library = target.join("debug").join(library_name());
    if !library.is_file() {
        bail!("there is no {}: build the workspace first", library.display());
    }
    let mut pack = python.command();
    pack.arg(peer("pack_wheel.py")).arg("--package").arg(shell::root().join("python"));
    pack.arg("--library").arg(&library).args(["--version", env!("CARGO_PKG_VERSION")]);
    shell::run(pack.arg("--out").arg(&packed))?;
    let mut install = python.command();
    install.args(["-m", "pip", "install", "--quiet", "--no-input", "--no-deps"]);
    install.args(["--disable-pip-version-check"]).arg(newest(&packed)?);
    shell::run(&mut install)?;

    let mut pytest = python.command();
    pytest.args(["-m", "pytest", "--quiet", "-p", "no:cacheprovider", "python/tests"]);
    let tests = shell::run(pytest.env("BROOD_BIN", brood));
    let mut mypy = python.command();
    mypy.args(["-m", "mypy", "--strict", "--cache-dir"]).arg(folder.join("mypy"));
    mypy.args(["-p", "brood_brdf"]);
    // Elsewhere mypy would check the source tree instead of what is installed.
    let types = shell::run(mypy.current_dir(&folder));
    tests.and(types)
}

fn peer(name: &str) -> PathBuf {
    shell::root().join("xtask/peer").join(name)
}

/// File name of the native library in a target folder.
fn library_name() -> String {
    format!("{}_native{}", std::env::consts::DLL_PREFIX, std::env::consts::DLL_SUFFIX)
}

/// The newest wheel of a folder.
fn newest(folder: &Path) -> Result<PathBuf> {
    let wheels = std::fs::read_dir(folder).context("list the wheels")?.filter_map(|entry| {
        let path = entry.ok()?.path();
        let is_wheel = path.extension().is_some_and(|extension| extension == "whl");
        is_wheel.then(|| Some((path.metadata().ok()?.modified().ok()?, path)))?
    });
    wheels.max().map(|(_, path)| path).with_context(|| format!("no wheel in {}", folder.display()))
}
