//! What the tests need besides Rust, a C++ compiler and Node: a software Vulkan driver, a browser and its driver, and
//! an instruction counter.
//!
//! Owns finding these and installing what is missing, saying so first. Refuses to know what they are used for. Where
//! it cannot install (no Debian, no rights) it says what to do, and the step that needs the thing fails by itself.

use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Result, bail};

use crate::shell;

/// What the checks of the page need, in the versions that tests/browser/package-lock.json names.
const NPM_PACKAGES: [&str; 3] = ["playwright-core", "axe-core", "typescript"];

/// The reference compiler of GLSL.
const GLSL_COMPILER: &str = "glslangValidator";

/// What was found, after installing what was missing.
pub struct Prerequisites {
    /// Manifest of the software Vulkan driver; none means that tests on a GPU use whatever adapter there is.
    pub lavapipe: Option<PathBuf>,
    /// The browser of the journey.
    pub chromium: Option<PathBuf>,
    /// Whether `cargo nextest` runs.
    pub nextest: bool,
}

impl Prerequisites {
    /// Looks, installs what is missing, and looks again.
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
        let found = Self::look();
        found.report();
        found
    }

    /// Only looks.
    pub fn look() -> Self {
        Self { lavapipe: lavapipe(), chromium: chromium(), nextest: nextest_is_installed() }
    }

    /// Sets what the tests read from their environment.
    pub fn apply(&self, command: &mut Command) {
        if let Some(manifest) = &self.lavapipe {
            // Both names: the second is the one that current loaders read, the first what older ones know. With the
            // driver named, a test that finds no adapter is broken and has to fail.
            command
                .env("VK_DRIVER_FILES", manifest)
                .env("VK_ICD_FILENAMES", manifest)
                .env("BROOD_REQUIRE_GPU", "1");
        }
        if let Some(browser) = &self.chromium {
            command.env("CHROMIUM", browser);
        }
        // With the compiler there, a test that does not find it is broken and has to fail.
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

/// The manifest of Mesa's software driver, in one of the folders that Vulkan loaders search.
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
    // Drivers of a foreign architecture may lie beside the one that fits.
    found.sort_by_key(|path| (!name_of(path).contains(&of_this_machine), path.clone()));
    found.into_iter().next()
}

fn name_of(path: &Path) -> String {
    path.file_name().unwrap_or_default().to_string_lossy().into_owned()
}

/// The browser named by `$CHROMIUM`, else one on the search path.
fn chromium() -> Option<PathBuf> {
    if let Some(path) = std::env::var_os("CHROMIUM") {
        return Some(PathBuf::from(path)).filter(|path| path.is_file());
    }
    ["chromium", "chromium-browser", "google-chrome"].into_iter().find_map(shell::find_program)
}

fn nextest_is_installed() -> bool {
    shell::cargo().args(["nextest", "--version"]).output().is_ok_and(|it| it.status.success())
}

/// Installs Debian packages, where this is such a system and there is the right to.
pub fn install_debian(packages: &[&str]) -> Result<()> {
    if shell::find_program("apt-get").is_none() {
        bail!("this is no Debian system; install them by hand");
    }
    println!("installing Debian packages: {}", packages.join(" "));
    // An index that cannot be refreshed may still hold the packages.
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

/// apt-get as root, or through a sudo that asks nothing.
fn apt_get() -> Result<Command> {
    let user = shell::output(shell::command("id").arg("-u"))?;
    let mut command = if user.trim() == "0" {
        shell::command("apt-get")
    } else if shell::find_program("sudo").is_some() {
        let mut sudo = shell::command("sudo");
        sudo.args(["--non-interactive", "DEBIAN_FRONTEND=noninteractive", "apt-get"]);
        sudo
    } else {
        bail!("neither root nor sudo");
    };
    command.env("DEBIAN_FRONTEND", "noninteractive");
    Ok(command)
}

/// Puts the browser's driver, the accessibility checker and the type checker beside the journey, unless the locked versions are there.
pub fn install_browser_driver() -> Result<()> {
    let folder = shell::root().join("tests/browser");
    let lock = std::fs::read_to_string(folder.join("package-lock.json"))?;
    if installed_versions_match(&lock, &folder) {
        return Ok(());
    }
    println!("installing npm packages: {}", NPM_PACKAGES.join(" "));
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
        let wanted = version_in(lock, &format!("/packages/node_modules~1{name}/version"));
        let manifest = folder.join("node_modules").join(name).join("package.json");
        let found =
            std::fs::read_to_string(manifest).ok().and_then(|text| version_in(&text, "/version"));
        wanted.is_some() && wanted == found
    })
}
