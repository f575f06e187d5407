//! `cargo xtask accept --exports`: reads exported materials with the programs that the formats are
//! for, and compares their values with those of the reference.
//!
//! Prints a line for each format: consumer and version, materials, worst and median error. The
//! scripts and the exact versions of their packages are in xtask/consumer.

use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::Mutex;
use std::time::Instant;

use anyhow::{Context, Result, ensure};
use serde_json::Value;

use crate::prerequisite::{self, Prerequisites, Program};
use crate::python::Python;
use crate::shell;

/// Language of a script.
#[derive(Debug, Clone, Copy)]
enum Runtime {
    /// With packages from PyPI, listed in a file.
    Python,
    /// With packages from npm, listed in a folder, and with a browser.
    Node,
}

/// A format and the script that reads its files.
struct Consumer {
    format: &'static str,
    runtime: Runtime,
    /// Script and list of packages in xtask/consumer, without their endings.
    script: &'static str,
    packages: &'static str,
    /// Number of random genomes.
    genomes: u32,
    /// Programs that the script calls, and their Debian packages.
    programs: &'static [Program],
}

const DISPLAY: Program = ("xvfb-run", &["xvfb", "xauth", "libgl1"]);
const GODOT: Program = ("godot3-runner", &["godot3-runner"]);
const GLSL: Program = ("glslangValidator", &["glslang-tools"]);
const SPIRV: Program = ("spirv-val", &["spirv-tools"]);

/// Most consumers.
const PYTHON: Consumer = Consumer {
    format: "",
    runtime: Runtime::Python,
    script: "",
    packages: "",
    genomes: 40,
    programs: &[],
};
/// As [`PYTHON`], for three.js.
const THREE: Consumer = Consumer { runtime: Runtime::Node, packages: "three", ..PYTHON };

const CONSUMERS: [Consumer; 10] = [
    Consumer { format: "mitsuba", script: "mitsuba_plugin", packages: "mitsuba", ..PYTHON },
    // Tables of anisotropic materials have 18 or 52 MB.
    Consumer {
        format: "rgl-bsdf",
        script: "mitsuba_table",
        packages: "mitsuba",
        genomes: 10,
        ..PYTHON
    },
    Consumer { format: "hlsl", script: "slang", packages: "slangpy", ..PYTHON },
    Consumer { format: "three-page", script: "three_page", ..THREE },
    Consumer { format: "three-tsl", script: "three_tsl", ..THREE },
    Consumer {
        format: "materialx",
        script: "materialx",
        packages: "materialx",
        programs: &[DISPLAY, GLSL, SPIRV],
        ..PYTHON
    },
    Consumer {
        format: "godot-3",
        script: "godot",
        packages: "numpy",
        programs: &[DISPLAY, GODOT],
        ..PYTHON
    },
    Consumer { format: "blender", script: "blender", packages: "bpy", ..PYTHON },
    Consumer { format: "blender-osl", script: "blender", packages: "bpy", ..PYTHON },
    Consumer { format: "gltf", script: "gltf", packages: "gltf", ..PYTHON },
];

/// Exports materials in each format and runs its consumer. Writes the results of each material to
/// `target/exports/FORMAT.jsonl`. Without `formats`, reads all that a program is known for; without
/// `genomes`, each format has its own number of random genomes.
pub(super) fn run(
    binaries: &Path,
    target: &Path,
    formats: &[String],
    genomes: Option<u32>,
) -> Result<()> {
    let known = CONSUMERS.map(|consumer| consumer.format);
    for format in formats {
        ensure!(known.contains(&format.as_str()), "formats with a program: {}", known.join(", "));
    }
    let is_chosen =
        |consumer: &&Consumer| formats.is_empty() || formats.iter().any(|f| f == consumer.format);
    let folder = target.join("exports");
    let mut failed = Vec::new();
    let mut lines = Vec::new();
    for consumer in CONSUMERS.iter().filter(is_chosen) {
        let started = Instant::now();
        let outcome = consumer.run(binaries, &folder, genomes.unwrap_or(consumer.genomes));
        let seconds = started.elapsed().as_secs_f64();
        match outcome {
            Ok(summary) => lines.push(line(consumer.format, &summary, seconds)),
            Err(error) => {
                lines.push(format!("{}: failed: {error:#}", consumer.format));
                failed.push(consumer.format);
            }
        }
    }
    lines.iter().for_each(|line| println!("{line}"));
    ensure!(failed.is_empty(), "formats that fail: {}", failed.join(", "));
    Ok(())
}

impl Consumer {
    fn run(&self, binaries: &Path, folder: &Path, genomes: u32) -> Result<Value> {
        let files = folder.join(self.format);
        if files.exists() {
            std::fs::remove_dir_all(&files).context("remove the files of the last run")?;
        }
        let mut write = shell::command(binaries.join("brood"));
        write.args(["bench", "consumer", "--format", self.format]);
        write.args(["--genomes", &genomes.to_string()]);
        write.arg("--output").arg(&files);
        shell::run(&mut write)?;
        prerequisite::install_programs(self.programs)?;
        let mut read = match self.runtime {
            Runtime::Python => self.python(folder, &files)?,
            Runtime::Node => self.node(folder, &files)?,
        };
        let lines = Mutex::new(Vec::new());
        let outcome = shell::run_watched(&mut read, |line| {
            lines.lock().expect("no reader of the output panics").push(line.to_owned());
        });
        let lines = lines.into_inner().expect("no reader of the output panics");
        let results: Vec<String> = lines.into_iter().filter(|line| line.starts_with('{')).collect();
        let last = results.last().context("the script printed no result")?.clone();
        let record = folder.join(format!("{}.jsonl", self.format));
        std::fs::write(&record, results.join("\n") + "\n").context("write the record")?;
        outcome?;
        serde_json::from_str(&last).context("parse the summary of the script")
    }

    /// Installs the packages of a Python script, and returns the command that runs it.
    fn python(&self, folder: &Path, files: &Path) -> Result<Command> {
        let mut python = Python::at(&folder.join(self.packages));
        python.prepare()?;
        python.install(&script(&format!("{}.txt", self.packages)))?;
        if self.packages == "mitsuba" {
            python.find_llvm()?;
        }
        if self.format == "gltf" {
            prerequisite::install_browser_driver()?;
        }
        let mut read = python.command();
        read.arg(script(&format!("{}.py", self.script))).arg(files);
        Ok(read)
    }

    /// Installs the packages of a Node script, and returns the command that runs it.
    fn node(&self, folder: &Path, files: &Path) -> Result<Command> {
        let packages = folder.join(self.packages);
        std::fs::create_dir_all(&packages).context("make the folder of npm packages")?;
        for list in ["package.json", "package-lock.json"] {
            std::fs::copy(script(self.packages).join(list), packages.join(list))
                .with_context(|| format!("copy {list}"))?;
        }
        prerequisite::install_npm_packages(&packages)?;
        prerequisite::install_browser_driver()?;
        let mut read = shell::command("node");
        if let Some(browser) = Prerequisites::find().chromium {
            read.env("CHROMIUM", browser);
        }
        read.arg(script(&format!("{}.mjs", self.script))).arg(files).arg(&packages);
        Ok(read)
    }
}

fn script(name: &str) -> PathBuf {
    shell::root().join("xtask/consumer").join(name)
}

/// Line of the results of a format.
fn line(format: &str, summary: &Value, seconds: f64) -> String {
    let number = |name: &str| summary[name].as_f64().unwrap_or(f64::NAN);
    format!(
        "{format}: {}, {} materials, {} refused, worst error {:.2e}, median {:.2e}, {seconds:.0} s",
        summary["consumer"].as_str().unwrap_or("unknown consumer"),
        summary["materials"],
        summary["refused"],
        number("worst_error"),
        number("median_error"),
    )
}
