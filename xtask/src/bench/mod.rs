//! `cargo xtask bench`: other programs and brood on the same work: speed (`peers`), pictures
//! (`pictures`), fits of measured materials (`fit`) and recovery of materials from pictures
//! (`inverse`, `photographs`); the page in a browser: its frame rate (`live`), and its times far
//! from the server (`far`); what a new user sees (`look`); and several servers on one machine
//! (`scale`).
//!
//! Owns the options and the order of the work. A peer that cannot be installed is reported and
//! skipped; with --require the run then fails. `environment` installs the peers, `compare` computes
//! the ratios.

mod compare;
mod environment;
mod far;
mod fit;
mod inverse;
mod live;
mod look;
mod measure;
mod metric;
mod photograph;
mod picture;
mod scale;
mod table;

use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail, ensure};
use serde_json::{Value, json};

use crate::shell;
use environment::{Environment, Peer};

pub use far::run as far;
pub use fit::run as fit;
pub use inverse::run as inverse;
pub use live::run as live;
pub use look::run as look;
pub use metric::run as metrics;
pub use photograph::run as photographs;
pub use picture::{material, run as pictures};
pub use scale::run as scale;

/// Subcommand of `cargo xtask bench`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Task {
    /// Speed of peers.
    Peers,
    /// Pictures.
    Pictures,
    /// Fits of measured materials.
    Fit,
    /// Materials recovered from pictures.
    Inverse,
    /// Materials under other lights than those of the photographs they were recovered from.
    Photographs,
    /// Frames per second of the page.
    Live,
    /// Times of the page far from the server.
    Far,
    /// Broods, starts, mutation and steering as a new user sees them.
    Look,
    /// Broods and pictures of several servers, and searches with islands.
    Scale,
}

impl Task {
    /// Name on the command line.
    fn name(self) -> &'static str {
        match self {
            Self::Peers => "peers",
            Self::Pictures => "pictures",
            Self::Fit => "fit",
            Self::Inverse => "inverse",
            Self::Photographs => "photographs",
            Self::Live => "live",
            Self::Far => "far",
            Self::Look => "look",
            Self::Scale => "scale",
        }
    }
}

/// Options of the command line.
#[derive(Debug, PartialEq)]
struct Options {
    /// Folder for the results.
    out: PathBuf,
    /// True if a missing peer is a failure.
    require: bool,
    /// True if brood is built with the release profile instead of the profile of the tests.
    release: bool,
    /// Existing brood binary to use instead of building one.
    brood: Option<PathBuf>,
    /// Number of runs; the best counts for peers, the median for scale.
    rounds: u32,
    /// Folder of meshes, recorded pictures and measured materials; for pictures, photographs and
    /// fit.
    data: Option<PathBuf>,
    /// Report of an earlier run whose peer results are reused; for fit.
    recorded: Option<PathBuf>,
    /// Comma-separated names of materials; for fit and photographs.
    materials: Option<String>,
    /// Number of seeds of brood's fits; for fit.
    seeds: Option<u32>,
    /// Number of random starts; for inverse.
    starts: Option<u32>,
    /// Comma-separated grades; for photographs.
    grades: Option<String>,
    /// Numbers of pictures of each material; for photographs.
    pictures: Option<Vec<u32>>,
    /// Seconds of each fit, for photographs; of each measurement, for scale.
    seconds: Option<Vec<u32>>,
    /// Strategy of the fits; for photographs.
    strategy: Option<String>,
    /// Comma-separated models that Mitsuba with Adam fits, or `none`; for photographs.
    peers: Option<String>,
    /// Comma-separated graphics drivers; for live.
    angle: Option<String>,
    /// True if software rendering is a failure; for live.
    hardware: bool,
    /// Comma-separated series; for scale.
    only: Option<String>,
}

/// Value of an option that takes a number from 1 to `most`.
fn count(option: &str, value: Option<&&str>, most: u32) -> Result<u32> {
    let count = value.and_then(|value| value.parse().ok());
    let count = count.filter(|count| (1..=most).contains(count));
    count.with_context(|| format!("{option} needs a number from 1 to {most}"))
}

/// Value of an option that takes comma-separated numbers from 1 to `most`, in ascending order.
fn counts(option: &str, value: Option<&&str>, most: u32) -> Result<Vec<u32>> {
    let words = value.with_context(|| format!("{option} needs numbers from 1 to {most}"))?;
    let numbers: Result<Vec<u32>> =
        words.split(',').map(|word| count(option, Some(&word), most)).collect();
    let mut numbers = numbers?;
    numbers.sort_unstable();
    numbers.dedup();
    Ok(numbers)
}

impl Options {
    fn parse(task: Task, words: &[&str]) -> Result<Self> {
        let mut options = Self {
            out: PathBuf::from("target/bench").join(task.name()),
            require: false,
            release: false,
            brood: None,
            rounds: if task == Task::Scale { 3 } else { 2 },
            data: None,
            recorded: None,
            materials: None,
            seeds: None,
            starts: None,
            grades: None,
            pictures: None,
            seconds: None,
            strategy: None,
            peers: None,
            angle: None,
            hardware: false,
            only: None,
        };
        let mut words = words.iter();
        while let Some(word) = words.next() {
            match *word {
                "--require" => options.require = true,
                "--release" => options.release = true,
                "--out" => options.out = words.next().context("--out needs a folder")?.into(),
                "--brood" => {
                    let file = words.next().context("--brood needs a file")?;
                    options.brood = Some(std::path::absolute(file).context("resolve --brood")?);
                }
                "--starts" if task == Task::Inverse => {
                    options.starts = Some(count(word, words.next(), 1000)?);
                }
                "--seeds" if task == Task::Fit => {
                    options.seeds = Some(count(word, words.next(), 1000)?);
                }
                "--angle" if task == Task::Live => {
                    let names = words.next().context("--angle needs names")?;
                    options.angle = Some((*names).to_owned());
                }
                "--hardware" if task == Task::Live => options.hardware = true,
                "--grades" if task == Task::Photographs => {
                    let names = words.next().context("--grades needs names")?;
                    options.grades = Some((*names).to_owned());
                }
                "--pictures" if task == Task::Photographs => {
                    options.pictures = Some(counts(word, words.next(), 8)?);
                }
                "--seconds" if task == Task::Photographs => {
                    options.seconds = Some(counts(word, words.next(), 3600)?);
                }
                "--strategy" if task == Task::Photographs => {
                    let name = words.next().context("--strategy needs a name")?;
                    options.strategy = Some((*name).to_owned());
                }
                "--peers" if task == Task::Photographs => {
                    let names = words.next().context("--peers needs names or none")?;
                    options.peers = Some((*names).to_owned());
                }
                "--data" if matches!(task, Task::Pictures | Task::Fit | Task::Photographs) => {
                    options.data = Some(words.next().context("--data needs a folder")?.into());
                }
                "--recorded" if task == Task::Fit => {
                    let file = words.next().context("--recorded needs a fit.json")?;
                    options.recorded = Some(file.into());
                }
                "--materials" if matches!(task, Task::Fit | Task::Photographs) => {
                    let names = words.next().context("--materials needs names")?;
                    options.materials = Some((*names).to_owned());
                }
                "--seconds" if task == Task::Scale => {
                    options.seconds = Some(vec![count(word, words.next(), 3600)?]);
                }
                "--only" if task == Task::Scale => {
                    let names = words.next().context("--only needs names")?;
                    options.only = Some((*names).to_owned());
                }
                "--rounds" if matches!(task, Task::Peers | Task::Scale) => {
                    options.rounds = count(word, words.next(), 100)?;
                }
                word => bail!("unknown option {word} of bench {}", task.name()),
            }
        }
        Ok(options)
    }
}

/// Runs the comparison with peers.
pub fn peers(words: &[&str]) -> Result<()> {
    let options = Options::parse(Task::Peers, words)?;
    let environment = Environment::prepare(&options, &Peer::FAST)?;
    let mut findings = measure::Findings::new(&environment);
    for round in 1..=options.rounds {
        println!("\n== round {round} of {}", options.rounds);
        findings.round(&environment);
    }
    let rows = compare::rows(&findings);
    findings.missing.extend(compare::gaps(&findings));
    let text = table::markdown(&rows, &findings, &environment);
    let report = json!({
        "machine": environment.machine(),
        "rounds": options.rounds,
        "comparisons": rows.iter().map(compare::Row::json).collect::<Vec<_>>(),
        "missing": findings.missing,
        "raw": findings.raw(),
    });
    write_report(&options.out, "peers", &report, &text)?;
    require_all(options.require, &findings.missing)
}

/// Error if anything is missing although everything is required.
fn require_all(is_required: bool, missing: &[String]) -> Result<()> {
    let is_complete = !is_required || missing.is_empty();
    ensure!(is_complete, "not everything could be measured: {}", missing.join("; "));
    Ok(())
}

/// One paragraph for each reason.
fn paragraphs(missing: &[String]) -> String {
    missing.iter().map(|reason| format!("\nMissing: {reason}\n")).collect()
}

/// List of the missing comparisons; empty if there are none.
fn not_compared(missing: &[String]) -> String {
    if missing.is_empty() {
        return String::new();
    }
    let lines: String = missing.iter().map(|missing| format!("- {missing}\n")).collect();
    format!("\nNot compared:\n{lines}")
}

/// Writes the report as JSON and Markdown, and prints the Markdown.
fn write_report(out: &Path, name: &str, report: &Value, text: &str) -> Result<()> {
    let folder = shell::root().join(out);
    std::fs::create_dir_all(&folder).with_context(|| format!("create {}", folder.display()))?;
    let write = |name: String, text: &str| {
        std::fs::write(folder.join(&name), text).with_context(|| format!("write {name}"))
    };
    write(format!("{name}.json"), &format!("{report:#}\n"))?;
    write(format!("{name}.md"), text)?;
    println!("\n{text}\nwritten to {}", folder.display());
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::{Options, Task};

    #[test]
    fn options_are_rejected_when_a_word_is_unknown_or_a_value_is_missing() {
        for words in
            [&["--fast"][..], &["--out"], &["--brood"], &["--rounds", "0"], &["--rounds", "many"]]
        {
            assert!(Options::parse(Task::Peers, words).is_err(), "{words:?}");
        }
    }

    #[test]
    fn options_are_read_when_given() {
        let options = Options::parse(Task::Peers, &["--require", "--out", "x/y", "--rounds", "3"]);
        let options = options.unwrap();
        assert!(options.require && !options.release);
        assert_eq!((options.out.to_str(), options.rounds), (Some("x/y"), 3));
    }
    #[test]
    fn each_task_has_options_of_its_own() {
        let options = Options::parse(Task::Pictures, &["--data", "d"]).unwrap();
        assert_eq!(options.data.as_deref(), Some(std::path::Path::new("d")));
        assert!(Options::parse(Task::Peers, &["--data", "d"]).is_err());
        assert!(Options::parse(Task::Pictures, &["--rounds", "3"]).is_err());
        let options = Options::parse(Task::Photographs, &["--peers", "none"]).unwrap();
        assert_eq!(options.peers.as_deref(), Some("none"));
        assert!(Options::parse(Task::Fit, &["--peers", "none"]).is_err());
        let options = Options::parse(Task::Photographs, &["--pictures", "4,1,4,2"]).unwrap();
        assert_eq!(options.pictures, Some(vec![1, 2, 4]));
        assert!(Options::parse(Task::Photographs, &["--pictures", "1,,2"]).is_err());
        assert!(Options::parse(Task::Photographs, &["--pictures", "9"]).is_err());
    }
}
