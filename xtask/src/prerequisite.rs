//! External tools of the tests, besides Rust, a C++ compiler and Node: a software Vulkan driver, a
//! browser and its driver, and an instruction counter.
//!
//! Finds these tools and installs missing ones, after printing what is missing. If it cannot
//! install (no Debian, no rights) it prints what to do, and the step that needs the tool fails.

use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Result, bail};

use crate::shell;

/// npm packages of the page's checks, in the versions of tests/browser/package-lock.json.
const NPM_PACKAGES: [&str; 6] = [
    "playwright-core",
    "axe-core",
    "typescript",
    "openapi-typescript",
    "@redocly/openapi-core",
    "gltf-validator",
];

/// Reference compiler of GLSL.
const GLSL_COMPILER: &str = "glslangValidator";

/// Tools found after installing missing ones.
pub struct Prerequisites {
    /// Manifest of the software Vulkan driver; without it GPU tests use whatever adapter exists.
    pub lavapipe: Option<PathBuf>,
    /// Browser of the journey test.
    pub chromium: Option<PathBuf>,
    /// True if `cargo nextest` is installed.
    pub nextest: bool,
}

impl Prerequisites {
    /// Finds the tools and installs missing ones.
    pub fn install() -> Self {
        let mut packages = Vec::new();
        if lavapipe().is_none() {
            println!("missing: a software Vulkan driver (Debian: mesa-vulkan-drivers)");
            packages.extend(["libvulkan1", "mesa-vulkan-drivers"]);
        }
        if chromium().is_none() {
            println!("missing: a browser (Debian: chromium)");
            packages.push("chromium");
        }
        if shell::find_program(GLSL_COMPILER).is_none() {
            println!("missing: a compiler for exported GLSL (Debian: glslang-tools)");
            packages.push("glslang-tools");
        }
        if shell::find_program("valgrind").is_none() {
            println!("missing: an instruction counter (Debian: valgrind)");
            packages.push("valgrind");
        }
        if !packages.is_empty()
            && let Err(error) = install_debian(&packages)
        {
            eprintln!("could not install {}: {error:#}", packages.join(", "));
        }
        if let Err(error) = install_browser_driver() {
            eprintln!("could not install the browser's driver: {error:#}");
        }
        let found = Self::find();
        found.report();
        found
    }

    /// Finds the tools without installing any.
    pub fn find() -> Self {
        Self { lavapipe: lavapipe(), chromium: chromium(), nextest: nextest_is_installed() }
    }

    /// Sets the environment variables that the tests read.
    pub fn apply(&self, command: &mut Command) {
        if let Some(manifest) = &self.lavapipe {
            // Current loaders read the first variable, older ones the second. With the driver set,
            // a test that finds no adapter is broken and must fail.
            command
                .env("VK_DRIVER_FILES", manifest)
                .env("VK_ICD_FILENAMES", manifest)
                .env("BROOD_REQUIRE_GPU", "1");
        }
        if let Some(browser) = &self.chromium {
            command.env("CHROMIUM", browser);
        }
        // With the compiler installed, a test that does not find it is broken and must fail.
        if let Some(compiler) = shell::find_program(GLSL_COMPILER) {
            command.env("GLSL_COMPILER", compiler);
        }
    }

    fn report(&self) {
        let shown = |path: &Option<PathBuf>| match path {
            Some(path) => path.display().to_string(),
            None => "not found".to_owned(),
        };
        println!("software Vulkan driver: {}", shown(&self.lavapipe));
        println!("browser: {}", shown(&self.chromium));
        println!("compiler for GLSL: {}", shown(&shell::find_program(GLSL_COMPILER)));
        println!("instruction counter: {}", shown(&shell::find_program("valgrind")));
        println!("test runner: {}", if self.nextest { "cargo nextest" } else { "cargo test" });
    }
}

/// Manifest of Mesa's software driver, in the folders searched by Vulkan loaders.
fn lavapipe() -> Option<PathBuf> {
    let folders = ["/usr/share/vulkan/icd.d", "/usr/local/share/vulkan/icd.d", "/etc/vulkan/icd.d"];
    let of_this_machine = format!(".{}.", std::env::consts::ARCH);
    let mut found: Vec<PathBuf> = folders
        .into_iter()
        .filter_map(|folder| std::fs::read_dir(folder).ok())
        .flatten()
        .filter_map(|entry| Some(entry.ok()?.path()))
        .filter(|path| name_of(path).starts_with("lvp_icd"))
        .collect();
    // Drivers of another architecture may be installed too.
    found.sort_by_key(|path| (!name_of(path).contains(&of_this_machine), path.clone()));
    found.into_iter().next()
}

fn name_of(path: &Path) -> String {
    path.file_name().unwrap_or_default().to_string_lossy().into_owned()
}

/// Browser given by `$CHROMIUM`, else one from the search path.
fn chromium() -> Option<PathBuf> {
    if let Some(path) = std::env::var_os("CHROMIUM") {
        return Some(PathBuf::from(path)).filter(|path| path.is_file());
    }
    ["chromium", "chromium-browser", "google-chrome"].into_iter().find_map(shell::find_program)
}

fn nextest_is_installed() -> bool {
    shell::cargo().args(["nextest", "--version"]).output().is_ok_and(|it| it.status.success())
}

/// A program and the Debian packages that it needs.
pub type Program = (&'static str, &'static [&'static str]);

/// Programs that check the files of `packaging/`.
pub const PACKAGING_PROGRAMS: [Program; 3] =
    [("promtool", &["prometheus"]), ("haproxy", &["haproxy"]), ("systemd-analyze", &["systemd"])];

/// Installs the Debian packages of those programs that are not found.
pub fn install_programs(programs: &[Program]) -> Result<()> {
    let missing: Vec<&str> = programs
        .iter()
        .filter(|(program, _)| shell::find_program(program).is_none())
        .flat_map(|(_, packages)| *packages)
        .copied()
        .collect();
    if missing.is_empty() { Ok(()) } else { install_debian(&missing) }
}

/// Installs Debian packages; fails on other systems and without the rights.
pub fn install_debian(packages: &[&str]) -> Result<()> {
    if shell::find_program("apt-get").is_none() {
        bail!("apt-get not found: this is not a Debian system; install the packages by hand");
    }
    println!("installing Debian packages: {}", packages.join(" "));
    // Continues without a refreshed index, which may still contain the packages.
    if let Err(error) = shell::run(apt_get()?.args(["update", "--quiet"])) {
        eprintln!("{error:#}");
    }
    shell::run(
        apt_get()?
            .args(["install", "--yes", "--quiet", "--no-install-recommends"])
            .args(["-o", "DPkg::Lock::Timeout=300"])
            .args(packages),
    )
}

/// apt-get as root, or through a sudo that needs no password.
fn apt_get() -> Result<Command> {
    let mut command = if shell::is_root()? {
        shell::command("apt-get")
    } else if shell::find_program("sudo").is_some() {
        let mut sudo = shell::command("sudo");
        sudo.args(["--non-interactive", "DEBIAN_FRONTEND=noninteractive", "apt-get"]);
        sudo
    } else {
        bail!("installing needs root, or sudo without a password");
    };
    command.env("DEBIAN_FRONTEND", "noninteractive");
    Ok(command)
}

/// Installs the browser's driver, the page's checkers of accessibility, types and openapi.json, and
/// the validator of glTF, unless the locked versions are installed.
pub fn install_browser_driver() -> Result<()> {
    let folder = shell::root().join("tests/browser");
    let lock = std::fs::read_to_string(folder.join("package-lock.json"))?;
    if installed_versions_match(&lock, &folder) {
        return Ok(());
    }
    println!("installing npm packages: {}", NPM_PACKAGES.join(" "));
    install_npm_packages(&folder)
}

/// Installs the npm packages of a folder in the versions of its package-lock.json.
pub fn install_npm_packages(folder: &Path) -> Result<()> {
    shell::run(
        shell::command("npm")
            .args(["ci", "--ignore-scripts", "--no-audit", "--no-fund"])
            .current_dir(folder),
    )
}

fn installed_versions_match(lock: &str, folder: &Path) -> bool {
    let version_in = |text: &str, pointer: &str| -> Option<String> {
        let json: serde_json::Value = serde_json::from_str(text).ok()?;
        Some(json.pointer(pointer)?.as_str()?.to_owned())
    };
    NPM_PACKAGES.into_iter().all(|name| {
        let key = format!("node_modules/{name}").replace('/', "~1");
        let locked = version_in(lock, &format!("/packages/{key}/version"));
        let manifest = folder.join("node_modules").join(name).join("package.json");
        let found =
            std::fs::read_to_string(manifest).ok().and_then(|text| version_in(&text, "/version"));
        locked.is_some() && locked == found
    })
}
