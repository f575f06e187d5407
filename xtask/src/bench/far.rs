//! `cargo xtask bench far`: times, requests and bytes of a first visit and of clicks over a slow
//! network.
//!
//! Owns the options and the table; the script `tests/browser/far.mjs` measures.

use std::fmt::Write;

use anyhow::{Context, Result, bail, ensure};
use serde_json::{Value, json};

use super::environment::{Environment, json_lines};
use super::{Options, Task, write_report};
use crate::{prerequisite, shell};

/// Time from a request to its answer in milliseconds.
const LATENCY_MS: &str = "300";
/// Bytes per millisecond in each direction: 1.6 Mbit/s.
const RATE: &str = "200";
const RUNS: &str = "5";
const CLICKS: &str = "3";

/// Columns of the table: heading, kind of line and field.
const TIMES: [(&str, &str, &str); 4] = [
    ("first visit to the picture of the centre", "visit", "first_picture_ms"),
    ("first visit to all 21 pictures", "visit", "all_pictures_ms"),
    ("click to the first child", "click", "first_child_ms"),
    ("click to all 20 children", "click", "all_children_ms"),
];
const TRAFFIC: [(&str, &str, &str); 4] = [
    ("requests of a first visit", "visit", "requests"),
    ("kB of a first visit", "visit", "bytes"),
    ("requests of a click", "click", "requests"),
    ("kB of a click", "click", "bytes"),
];

/// Runs the benchmark.
pub fn run(words: &[&str]) -> Result<()> {
    let options = Options::parse(Task::Far, words)?;
    let environment = Environment::prepare(&options, &[])?;
    prerequisite::install_browser_driver()?;
    let Some(browser) = prerequisite::Prerequisites::find().chromium else {
        bail!("no browser found: install chromium, or set $CHROMIUM to its path");
    };
    let mut node = shell::command("node");
    node.args(["tests/browser/far.mjs", "--latency", LATENCY_MS, "--rate", RATE]);
    node.args(["--runs", RUNS, "--clicks", CLICKS]).arg("--waterfall");
    let folder = shell::root().join(&options.out);
    std::fs::create_dir_all(&folder).with_context(|| format!("create {}", folder.display()))?;
    node.arg(folder.join("waterfall.txt"));
    node.env("BROOD_BIN", environment.brood_file()).env("CHROMIUM", browser);
    let lines = json_lines(&mut node)?;
    let machine = environment.machine();
    let text = markdown(&lines, &machine)?;
    write_report(&options.out, "far", &json!({ "machine": machine, "found": lines }), &text)
}

/// Smallest, median and largest value of a field.
fn spread(lines: &[Value], kind: &str, field: &str) -> Result<[f64; 3]> {
    let of_kind = lines.iter().filter(|line| line["kind"] == kind);
    let mut values: Vec<f64> = of_kind
        .map(|line| line[field].as_f64().with_context(|| format!("find {field} in {line}")))
        .collect::<Result<_>>()?;
    ensure!(!values.is_empty(), "there must be lines of kind {kind}");
    values.sort_by(f64::total_cmp);
    Ok([values[0], values[values.len() / 2], values[values.len() - 1]])
}

fn markdown(lines: &[Value], machine: &Value) -> Result<String> {
    let mut text = format!(
        "# The page far from its server\n\n\
         Headless Chromium with an empty cache, answers delayed by {LATENCY_MS} ms, {RATE} kB/s in each direction, \
         {RUNS} visits of a lineage whose pictures are rendered, each with {CLICKS} clicks.\n\n\
         | | median | range |\n|---|---|---|\n"
    );
    for (heading, kind, field) in TIMES {
        let [least, median, most] = spread(lines, kind, field)?.map(|ms| ms / 1000.0);
        writeln!(text, "| {heading} | {median:.1} s | {least:.1} to {most:.1} s |")?;
    }
    for (heading, kind, field) in TRAFFIC {
        let unit = if field == "bytes" { 1000.0 } else { 1.0 };
        let [least, median, most] = spread(lines, kind, field)?.map(|value| value / unit);
        writeln!(text, "| {heading} | {median:.0} | {least:.0} to {most:.0} |")?;
    }
    writeln!(text, "\nMachine: {machine}")?;
    Ok(text)
}

#[cfg(test)]
mod tests {
    use serde_json::{Value, json};

    use super::markdown;

    #[test]
    fn table_has_medians_and_ranges_of_visits_and_clicks() {
        let visit = |ms: f64| {
            json!({ "kind": "visit", "first_picture_ms": ms, "all_pictures_ms": 2.0 * ms,
                    "requests": 30, "bytes": 300_400 })
        };
        let click = json!({ "kind": "click", "first_child_ms": 900, "all_children_ms": 1800,
                            "requests": 22, "bytes": 150_000 });
        let lines: Vec<Value> = vec![visit(3000.0), visit(2000.0), visit(2400.0), click];
        let text = markdown(&lines, &json!("m")).unwrap();
        for row in [
            "| first visit to the picture of the centre | 2.4 s | 2.0 to 3.0 s |",
            "| first visit to all 21 pictures | 4.8 s | 4.0 to 6.0 s |",
            "| click to all 20 children | 1.8 s | 1.8 to 1.8 s |",
            "| kB of a first visit | 300 | 300 to 300 |",
            "| requests of a click | 22 | 22 to 22 |",
        ] {
            assert!(text.contains(row), "{row} in\n{text}");
        }
        assert!(markdown(&lines[..3], &json!("m")).is_err(), "clicks are missing");
    }
}
