//! `cargo xtask bench inverse`: recovery of known kinds of material from one picture, by brood, by
//! Mitsuba's derivatives with Adam and by pycma on Mitsuba's pictures, one after the other on the
//! same machine.
//!
//! Owns the order of the work and the table; each side's script defines the materials and the
//! criterion of success.

use std::fmt::Write;

use anyhow::{Context, Result};
use serde_json::{Value, json};

use super::environment::{Environment, Peer, json_of};
use super::{Options, Task, paragraphs, require_all, write_report};

/// Random starts of each material on every side.
const STARTS: u32 = 50;
const THREADS: &str = "2";
/// Largest number of starts of pycma, which needs thousands of pictures for each.
const EVOLVED_STARTS: u32 = 10;
/// Number of uncounted starts that choose Adam's learning rate for a material.
const TUNING: &str = "3";

/// Runs the comparison.
pub fn run(words: &[&str]) -> Result<()> {
    let options = Options::parse(Task::Inverse, words)?;
    let count = options.starts.unwrap_or(STARTS);
    let (starts, evolved) = (count.to_string(), count.min(EVOLVED_STARTS).to_string());
    let mut environment = Environment::prepare(&options, &[Peer::Mitsuba, Peer::Cma])?;
    let mut missing = std::mem::take(&mut environment.missing);
    let mut brood = environment.brood();
    brood.args(["bench", "inverse", "--json", "--starts", &starts]);
    let own = json_of(&mut brood).context("run brood bench inverse")?;
    let mut peers = Vec::new();
    let methods = [(Peer::Mitsuba, "adam", &starts), (Peer::Cma, "cma", &evolved)];
    for (peer, method, starts) in methods {
        if !(environment.has(Peer::Mitsuba) && environment.has(peer)) {
            continue;
        }
        let mut script = environment.script("mitsuba_inverse.py");
        script.args(["--threads", THREADS, "--starts", starts, "--method", method]);
        script.args(["--tune", TUNING]);
        match json_of(&mut script) {
            Ok(found) => peers.push(found),
            Err(error) => missing.push(format!("{method}: {error:#}")),
        }
    }
    let text = markdown(&own, &peers, &environment.machine(), &missing)?;
    let report = json!({
        "machine": environment.machine(), "brood": own, "peers": peers, "missing": missing,
    });
    write_report(&options.out, "inverse", &report, &text)?;
    require_all(options.require, &missing)
}

/// Mean seconds over all starts, and number of successes.
fn figures(row: &Value) -> Option<(f64, u64)> {
    let seconds = row["seconds"]["mean"].as_f64();
    let seconds = seconds.or_else(|| Some(1e-3 * row["ms"]["mean"].as_f64()?))?;
    Some((seconds, row["successes"].as_u64()?))
}

fn markdown(own: &Value, peers: &[Value], machine: &Value, missing: &[String]) -> Result<String> {
    let rows = |side: &Value| side["rows"].as_array().cloned().unwrap_or_default();
    let mut text = String::from(
        "# One picture, 128 x 128: materials recovered from random starts\n\n\
         Success is a root mean square error of linear radiance of at most 1e-4 over the whole picture. brood runs on one thread, \
         Mitsuba on two; each recovers its own noise-free picture. Adam's first learning rate is the best of four for the material. Seconds per success are the time of all starts over the number of \
         successes.\n\n\
         | material | by | unknowns | successes | seconds per start | median RMSE | seconds per success | times brood's |\n\
         |---|---|---|---|---|---|---|---|\n",
    );
    for row in rows(own) {
        let (seconds, successes) =
            figures(&row).context("a row of brood must have times and successes")?;
        let cost = |seconds: f64, row: &Value, successes: u64| {
            row["starts"].as_f64().unwrap_or(f64::NAN) * seconds / successes as f64
        };
        let own_cost = cost(seconds, &row, successes);
        let mut line = |by: &str, row: &Value, (seconds, successes): (f64, u64)| {
            let each = cost(seconds, row, successes);
            writeln!(
                text,
                "| {} | {by} | {} | {successes} of {} | {seconds:.4} | {:.1e} | {each:.4} | {:.0} |",
                row["material"].as_str().unwrap_or_default(),
                row["unknowns"],
                row["starts"],
                row["rmse"]["median"].as_f64().unwrap_or(f64::NAN),
                each / own_cost,
            )
        };
        line("brood", &row, (seconds, successes))?;
        let same = |other: &Value| other["material"] == row["material"];
        for other in peers.iter().flat_map(rows).filter(same) {
            let by = match other["method"].as_str() {
                Some("adam") => "Mitsuba + Adam",
                _ => "Mitsuba + pycma",
            };
            line(
                by,
                &other,
                figures(&other).context("a row of the peer must have times and successes")?,
            )?;
        }
    }
    write!(text, "{}\nMachine: {machine}\n", paragraphs(missing))?;
    Ok(text)
}
