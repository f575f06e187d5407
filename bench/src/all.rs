//! `brood bench all`: runs every benchmark in turn, each as a process of its own, and collects all
//! files in one folder together with a description of the machine.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::Instant;

use anyhow::{Context, Result, ensure};
use brood_eval::Level;
use clap::Args;

use crate::{logging, output};

/// Options of `brood bench all`.
#[derive(Debug, Args)]
pub struct BenchAllArgs {
    /// Folder for all results; created if missing
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    /// Small, quick run that only shows that everything works
    #[arg(long)]
    short: bool,
    /// Measure the GPU too, even a software adapter
    #[arg(long)]
    gpu: bool,
}

/// One benchmark command and the destination of its output.
struct Part {
    /// Arguments after `brood bench`.
    words: Vec<String>,
    /// Stem of the file that receives the printed output.
    name: &'static str,
    /// True if the command writes files of its own into the folder.
    has_files: bool,
    /// Names of the charts that it writes.
    charts: &'static [&'static str],
}

/// Runs the command.
pub fn run(args: &BenchAllArgs, json: bool) -> Result<()> {
    logging::start_offline();
    output::make_dir(&args.out)?;
    let folder = args.out.canonicalize().context("find the folder")?;
    let program = std::env::current_exe().context("find this program")?;
    let parts = parts(args.short, args.gpu);
    output::write_file(&folder.join("machine.txt"), machine(&parts).as_bytes())?;
    let bar = output::bar(parts.len() as u64, "benchmarks");
    let mut seconds = Vec::new();
    for part in &parts {
        let started = Instant::now();
        part.run(&program, &folder)?;
        seconds.push((part.name, started.elapsed().as_secs_f64()));
        bar.inc(1);
    }
    bar.finish_and_clear();
    output::write_file(&folder.join("README.md"), readme(&parts, &folder)?.as_bytes())?;
    if json {
        let seconds: serde_json::Map<_, _> =
            seconds.iter().map(|(name, s)| ((*name).to_owned(), (*s).into())).collect();
        return output::print_json(&serde_json::json!({ "folder": args.out, "seconds": seconds }));
    }
    let lines: String = seconds.iter().map(|(name, s)| format!("{name:<24} {s:7.1} s\n")).collect();
    output::print(&format!("{}\n{lines}", args.out.display()))
}

/// Benchmarks in the order they run.
fn parts(short: bool, gpu: bool) -> Vec<Part> {
    // Common arguments, then those of a long or of a short run.
    let words = |words: &str, long: &str, brief: &str| -> Vec<String> {
        let more = if short { brief } else { long };
        words.split_whitespace().chain(more.split_whitespace()).map(str::to_owned).collect()
    };
    let on_gpu = if gpu { "pareto --gpu" } else { "pareto" };
    let count = ("--count 300", "--count 3");
    vec![
        Part {
            words: words("ops", "", "--programs 10 --passes 2"),
            name: "ops",
            has_files: true,
            charts: &["ops"],
        },
        Part {
            words: words("fitness", "", "--population 50 --rounds 1"),
            name: "fitness",
            has_files: true,
            charts: &[],
        },
        Part {
            words: words("derivative", "", "--genomes 40 --repeats 1"),
            name: "derivative",
            has_files: true,
            charts: &[],
        },
        Part {
            words: words("frame", "", "--programs 2 --repeats 2"),
            name: "frame",
            has_files: true,
            charts: &[],
        },
        Part {
            words: words("breed --size 128", count.0, count.1),
            name: "breed-128",
            has_files: false,
            charts: &[],
        },
        Part {
            words: words("breed --size 256", count.0, count.1),
            name: "breed-256",
            has_files: false,
            charts: &[],
        },
        Part {
            words: words("skip", "", "--short"),
            name: "skip",
            has_files: true,
            charts: &["skip"],
        },
        Part {
            words: words("pareto --scene lambert-sphere", "", "--short"),
            name: "lambert-sphere",
            has_files: true,
            charts: &["lambert-sphere"],
        },
        Part {
            words: words(on_gpu, "", "--short"),
            name: "pareto",
            has_files: true,
            charts: &["samples-sphere", "samples-knob", "precision", "albedo", "prefix", "backend"],
        },
        Part {
            words: words(
                "stress",
                "--evaluations 1000000000 --pairs 100000000 --pictures 1000 --meshes 1000",
                "--evaluations 300000 --pairs 10000 --pictures 10 --meshes 4",
            ),
            name: "stress",
            has_files: true,
            charts: &["stress"],
        },
    ]
}

impl Part {
    /// Writes standard output to NAME.txt, or JSON to NAME.json if the command writes no files of
    /// its own.
    fn run(&self, program: &Path, folder: &Path) -> Result<()> {
        let mut words = self.words.clone();
        let kind = if self.has_files {
            words.extend(["--out".to_owned(), folder.display().to_string()]);
            "txt"
        } else {
            words.push("--json".to_owned());
            "json"
        };
        let printed = self.output(program, &words)?;
        output::write_file(&folder.join(format!("{}.{kind}", self.name)), &printed)
    }

    fn output(&self, program: &Path, words: &[String]) -> Result<Vec<u8>> {
        let child = Command::new(program)
            .arg("bench")
            .args(words)
            .stdin(Stdio::null())
            .stderr(Stdio::inherit())
            .output()
            .with_context(|| format!("start brood bench {}", words.join(" ")))?;
        ensure!(child.status.success(), "brood bench {} failed", words.join(" "));
        Ok(child.stdout)
    }
}

/// Renders the run as Markdown: the machine, then the output and the charts of each command.
fn readme(parts: &[Part], folder: &Path) -> Result<String> {
    let read = |name: String| {
        let path = folder.join(name);
        fs::read_to_string(&path).with_context(|| format!("read {}", path.display()))
    };
    let block = |text: String| format!("```\n{}\n```\n", text.trim_end());
    let mut page = "# A recorded run\n\n".to_owned() + &block(read("machine.txt".to_owned())?);
    for part in parts {
        let kind = if part.has_files { "txt" } else { "json" };
        page += &format!("\n## {}\n\n", part.name);
        page += &block(read(format!("{}.{kind}", part.name))?);
        for chart in part.charts {
            page += &format!("\n![{chart}]({chart}.svg)\n");
        }
    }
    Ok(page)
}

/// Describes the machine, the build and the commands.
fn machine(parts: &[Part]) -> String {
    let levels: Vec<&str> = Level::available().iter().map(|level| level.name()).collect();
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    let lines = [
        ("processor", processor().unwrap_or_else(unknown)),
        ("threads", threads.to_string()),
        ("instruction sets", levels.join(", ")),
        ("memory", memory().unwrap_or_else(unknown)),
        ("system", system().unwrap_or_else(unknown)),
        ("compiler", env!("BROOD_RUSTC").to_owned()),
        ("target", env!("BROOD_TARGET").to_owned()),
        ("optimisation level", env!("BROOD_OPT_LEVEL").to_owned()),
        ("brood", env!("CARGO_PKG_VERSION").to_owned()),
        ("commit", commit().unwrap_or_else(unknown)),
    ];
    let mut text: String =
        lines.iter().map(|(name, value)| format!("{name:<20} {value}\n")).collect();
    text += "\ncommands, in this order; those that write files also get --out with this folder\n";
    for part in parts {
        text += &format!("{:<20} brood bench {}\n", part.name, part.words.join(" "));
    }
    text
}

fn unknown() -> String {
    "unknown".to_owned()
}

/// Value of the first line `key : value` or `key=value` of a file.
fn value_in(file: &str, key: &str) -> Option<String> {
    let text = fs::read_to_string(file).ok()?;
    let mut lines = text.lines().filter_map(|line| line.split_once([':', '=']));
    let (_, value) = lines.find(|(name, _)| name.trim() == key)?;
    Some(value.trim().trim_matches('"').to_owned())
}

fn processor() -> Option<String> {
    value_in("/proc/cpuinfo", "model name")
}

fn memory() -> Option<String> {
    let text = value_in("/proc/meminfo", "MemTotal")?;
    let kib: f64 = text.split_whitespace().next()?.parse().ok()?;
    Some(format!("{:.0} GiB", kib / f64::from(1u32 << 20)))
}

fn system() -> Option<String> {
    value_in("/etc/os-release", "PRETTY_NAME")
}

/// Commit of the repository that contains the working directory.
fn commit() -> Option<String> {
    let git = |words: &[&str]| {
        let output = Command::new("git").args(words).stderr(Stdio::null()).output().ok()?;
        output.status.success().then(|| String::from_utf8_lossy(&output.stdout).trim().to_owned())
    };
    let commit = git(&["rev-parse", "HEAD"])?;
    let changed = git(&["status", "--porcelain", "--untracked-files=no"])?;
    Some(if changed.is_empty() { commit } else { format!("{commit}, with local changes") })
}

#[cfg(test)]
mod tests {
    use clap::Parser;

    use super::*;
    use crate::BenchCommand;

    #[derive(Parser)]
    struct Line {
        #[command(subcommand)]
        _command: BenchCommand,
    }

    #[test]
    fn every_part_is_a_command_that_exists() {
        for (short, gpu) in [(false, false), (true, false), (false, true)] {
            for part in parts(short, gpu) {
                let words = ["bench".to_owned()].into_iter().chain(part.words.clone());
                if let Err(error) = Line::try_parse_from(words) {
                    panic!("{}: {error}", part.words.join(" "));
                }
            }
        }
    }

    #[test]
    fn machine_names_the_compiler_and_every_command() {
        let text = machine(&parts(true, false));
        assert!(
            text.contains("rustc") && text.contains("brood bench stress --evaluations"),
            "{text}"
        );
    }
}
