//! `cargo xtask bench look`: figures of what a new user sees: broods in environments, starts of
//! lineages, visible amounts of mutation, and steering.
//!
//! Owns the list of commands; `brood bench` measures.

use std::fmt::Write;

use anyhow::Result;
use serde_json::json;

use super::environment::Environment;
use super::{Options, Task, write_report};
use crate::shell;

/// Broods of 21 in a known view of the studio: heading and options of `brood bench frame`.
const FRAMES: [(&str, &[&str]); 4] = [
    ("programs", &["--surface", "even"]),
    ("models", &["--models"]),
    ("programs that read u and v", &["--surface", "textured"]),
    ("programs that read all inputs", &["--surface", "any"]),
];
const KINDS: [&str; 3] = ["wild", "believable", "models"];
const STEERS: [&str; 9] = [
    "keep-colour",
    "only-gloss",
    "warmer",
    "cooler",
    "rougher",
    "glossier",
    "more-pattern",
    "less-pattern",
    "warmer,glossier",
];

/// Runs the benchmark.
pub fn run(words: &[&str]) -> Result<()> {
    let options = Options::parse(Task::Look, words)?;
    let environment = Environment::prepare(&options, &[])?;
    let machine = environment.machine();
    let mut report =
        Report { brood: environment.brood_file(), text: "# A first look\n".to_owned() };
    for (heading, more) in FRAMES {
        let fixed = ["frame", "--environment", "studio", "--mesh", "ball", "--size", "256"];
        let count = ["--samples", "adaptive", "--programs", "21", "--repeats", "5"];
        report.add(&format!("Brood of 21 in the studio: {heading}"), &[&fixed, &count, more])?;
    }
    report.add("Error in environments", &[&["pareto", "--sweep", "environment"]])?;
    report.add("Starts of lineages", &[&["start", "--count", "20", "--size", "48"]])?;
    report.add("Visible amounts", &[&["amount", "--count", "100", "--seeds", "1"]])?;
    for kind in KINDS {
        // Models have no pattern.
        for steer in STEERS.iter().filter(|steer| kind != "models" || !steer.contains("pattern")) {
            let fixed = ["--count", "24", "--seed", "5", "--size", "16"];
            let heading = format!("Steering {kind}: {steer}");
            report.add(&heading, &[&["brood", "--kind", kind, "--steer", steer], &fixed])?;
        }
    }
    let Report { text, .. } = report;
    write_report(&options.out, "look", &json!({ "machine": machine, "text": text }), &text)
}

/// Outputs of commands so far.
struct Report<'a> {
    brood: &'a std::path::Path,
    text: String,
}

impl Report<'_> {
    /// Runs `brood bench` with these words and adds its output.
    fn add(&mut self, heading: &str, words: &[&[&str]]) -> Result<()> {
        let words = words.concat();
        println!("brood bench {}", words.join(" "));
        let output = shell::output(shell::command(self.brood).arg("bench").args(&words))?;
        write!(
            self.text,
            "\n## {heading}\n\n`brood bench {}`\n\n```\n{}\n```\n",
            words.join(" "),
            output.trim_end()
        )?;
        Ok(())
    }
}
