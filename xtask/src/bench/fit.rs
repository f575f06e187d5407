//! `cargo xtask bench fit`: fits of measured materials by brood and by symbolic regression
//! (pyoperon), from the same samples, measured on the same held-out samples, one after the other on
//! the same machine.
//!
//! Owns the order of the work and the table; `brood bench fit` defines the fits and their samples.

use std::collections::BTreeMap;
use std::fmt::Write;
use std::path::Path;

use anyhow::{Context, Result, ensure};
use serde_json::{Value, json};

use super::environment::{Environment, Peer};
use super::{Options, Task, paragraphs, require_all, write_report};
use crate::{shell, suite};

/// Seconds per channel for the peer, and brood's longest budget for all three channels.
const SECONDS: &str = "25";
/// Other fits of the same materials: column of brood's table, and name.
const OTHERS: [(&str, &str); 4] = [
    ("e_log_sgd", "SGD"),
    ("e_log_abc", "ABC"),
    ("e_log_ward", "Ward"),
    ("e_log_ggx2", "two lobes of microfacets"),
];
/// Threads of both programs.
const THREADS: &str = "2";

/// Runs the comparison.
pub fn run(words: &[&str]) -> Result<()> {
    let options = Options::parse(Task::Fit, words)?;
    let data = options.data.as_ref().context("bench fit needs --data DIR")?;
    let data = data.canonicalize().context("resolve --data")?;
    let peers_to_install: &[Peer] = if options.recorded.is_some() { &[] } else { &[Peer::Operon] };
    let mut environment = Environment::prepare(&options, peers_to_install)?;
    let mut missing = std::mem::take(&mut environment.missing);
    let folder = suite::target_directory()?.join("peers/fit");
    if folder.exists() {
        std::fs::remove_dir_all(&folder).context("empty the folder of samples")?;
    }
    let mut brood = environment.brood();
    brood.args(["bench", "fit", "--threads", THREADS, "--seconds"]).arg(format!("1,5,{SECONDS}"));
    brood.arg("--out").arg(&folder);
    if let Some(materials) = &options.materials {
        brood.arg("--materials").arg(materials);
    }
    if let Some(seeds) = options.seeds {
        brood.args(["--seeds", &seeds.to_string()]);
    }
    let own = shell::output(brood.arg(&data).arg("--json"))?;
    let own: Vec<Value> = serde_json::from_str(&own).context("read brood's table")?;
    let mut peers = match &options.recorded {
        Some(file) => recorded(file)?,
        None => BTreeMap::new(),
    };
    if let Some(file) = &options.recorded {
        missing.push(format!(
            "pyoperon in this run: its figures are from {}, on the same samples",
            file.display()
        ));
    }
    if environment.has(Peer::Operon) {
        let mut script = environment.script("operon_fit.py");
        script.args(["--seconds", SECONDS, "--threads", THREADS]).arg(folder.join("samples"));
        match shell::output(&mut script) {
            Ok(text) => peers = by_material(&text)?,
            Err(error) => missing.push(format!("pyoperon: {error:#}")),
        }
    }
    let text = markdown(&own, &peers, &environment.machine(), &missing)?;
    let report = json!({
        "machine": environment.machine(), "brood": own, "pyoperon": peers, "missing": missing,
    });
    write_report(&options.out, "fit", &report, &text)?;
    copy_chart(&folder, &options.out)?;
    require_all(options.require, &missing)
}

fn copy_chart(folder: &Path, out: &Path) -> Result<()> {
    let chart = folder.join("fit.svg");
    std::fs::copy(&chart, shell::root().join(out).join("fit.svg")).context("copy the chart")?;
    Ok(())
}

/// The peer's results of an earlier run. Samples depend only on the material, so they are the same.
fn recorded(file: &Path) -> Result<BTreeMap<String, Value>> {
    let text = std::fs::read(file).with_context(|| file.display().to_string())?;
    let mut report: Value =
        serde_json::from_slice(&text).context("parse the report of an earlier run")?;
    serde_json::from_value(report["pyoperon"].take())
        .context("the report of the earlier run needs a key pyoperon")
}

/// The peer's printed lines, by material.
fn by_material(text: &str) -> Result<BTreeMap<String, Value>> {
    let line = |line: &str| {
        let value: Value = serde_json::from_str(line).context("parse the peer's output")?;
        let name = value["material"]
            .as_str()
            .context("a line of the peer's output must name its material")?
            .to_owned();
        Ok((name, value))
    };
    text.lines().filter(|line| line.starts_with('{')).map(line).collect()
}

fn number(value: &Value) -> Option<f64> {
    value.as_f64().filter(|number| number.is_finite())
}

/// Median; for an even count the mean of the two middle values.
fn median(mut values: Vec<f64>) -> Option<f64> {
    values.sort_by(f64::total_cmp);
    let middle = values.len() / 2;
    match values.len() {
        0 => None,
        count if count % 2 == 1 => Some(values[middle]),
        _ => Some(0.5 * (values[middle - 1] + values[middle])),
    }
}

fn markdown(
    own: &[Value],
    peers: &BTreeMap<String, Value>,
    machine: &Value,
    missing: &[String],
) -> Result<String> {
    ensure!(!own.is_empty(), "brood bench fit returned no rows");
    let mut budgets: Vec<f64> =
        own.iter().filter_map(|row| number(&row["budget_seconds"])).collect();
    budgets.sort_by(f64::total_cmp);
    budgets.dedup();
    let mut materials: Vec<&str> = own.iter().filter_map(|row| row["material"].as_str()).collect();
    materials.dedup();
    let mut text = format!(
        "# Fits of measured materials\n\nE_log over all channels on 16384 held-out samples, {THREADS} threads; brood fits all channels at once, pyoperon one after \
         the other with {SECONDS} s each. {}\n\n",
        machine["processor"].as_str().unwrap_or_default()
    );
    text += "| material |";
    for budget in &budgets {
        write!(text, " brood {budget} s | operations |")?;
    }
    text += " pyoperon |";
    for (_, name) in OTHERS {
        write!(text, " {name} |")?;
    }
    text += "\n|---|";
    text += &"---|".repeat(2 * budgets.len() + 1 + OTHERS.len());
    text.push('\n');
    let of = |material: &str, budget: f64| {
        own.iter().find(|row| {
            row["material"] == material && number(&row["budget_seconds"]) == Some(budget)
        })
    };
    let shown = |value: Option<f64>| value.map_or("-".to_owned(), |value| format!("{value:.5}"));
    for material in &materials {
        write!(text, "| {material} |")?;
        for budget in &budgets {
            let row = of(material, *budget).context("every material must have every budget")?;
            write!(text, " {} | {} |", shown(number(&row["e_log"])), row["operations"])?;
        }
        let peer = peers.get(*material).and_then(|peer| number(&peer["e_log"]));
        write!(text, " {} |", shown(peer))?;
        let row = of(material, budgets[0]).context("every material must have every budget")?;
        for (column, _) in OTHERS {
            write!(text, " {} |", shown(number(&row[column])))?;
        }
        text.push('\n');
    }
    text += "\nMedian ratio of E_log, brood over the other:\n\n| budget | pyoperon | better of SGD and ABC |";
    text += " two lobes of microfacets | seconds | generations |\n|---|---|---|---|---|---|\n";
    for budget in &budgets {
        let ratios = |other: &dyn Fn(&Value) -> Option<f64>| {
            let ratio = |material: &&str| {
                let row = of(material, *budget)?;
                Some(number(&row["e_log"])? / other(row)?)
            };
            median(materials.iter().filter_map(ratio).collect())
        };
        let peer = ratios(&|row| number(&peers.get(row["material"].as_str()?)?["e_log"]));
        let published = ratios(&|row| {
            let both = [number(&row["e_log_sgd"]), number(&row["e_log_abc"])];
            both.into_iter().flatten().reduce(f64::min)
        });
        let lobes = ratios(&|row| number(&row["e_log_ggx2"]));
        let middle = |column: &str| {
            let value = |material: &&str| number(&of(material, *budget)?[column]);
            median(materials.iter().filter_map(value).collect())
        };
        let shown =
            |value: Option<f64>| value.map_or("-".to_owned(), |value| format!("{value:.3}"));
        let (seconds, generations) = (shown(middle("seconds")), shown(middle("generations")));
        let (peer, published, lobes) = (shown(peer), shown(published), shown(lobes));
        writeln!(
            text,
            "| {budget} s | {peer} | {published} | {lobes} | {seconds} | {generations} |"
        )?;
    }
    if let Some(budget) = budgets.last() {
        let rows: Vec<&Value> =
            materials.iter().filter_map(|material| of(material, *budget)).collect();
        text += &quality(&rows, *budget)?;
    }
    Ok(text + &paragraphs(missing))
}

/// Table of picture errors and physical measures of the fits of one budget.
fn quality(rows: &[&Value], budget: f64) -> Result<String> {
    let mut text = format!(
        "\nAfter {budget} s, on a knob under two lights not in the samples: mean Delta E_ITP (linear 1 is 100 cd/m2) and mean FLIP of the pixels that it \
         covers. Largest f is relative to the target's, over 65536 pairs near the mirror direction and at grazing angles; not reciprocal counts pairs that differ \
         when swapped; albedo is the largest of any channel.\n\n\
         | material | Delta E_ITP | FLIP | largest f | least f | not reciprocal | albedo |\n|---|---|---|---|---|---|---|\n"
    );
    for row in rows {
        let of = |column: &str| number(&row[column]).unwrap_or(f64::NAN);
        writeln!(
            text,
            "| {} | {:.2} | {:.4} | {:.2} | {:.2e} | {} | {:.3} |",
            row["material"].as_str().context("a row must name its material")?,
            of("unseen_itp"),
            of("unseen_flip"),
            of("largest_over_target"),
            of("least_f"),
            row["not_reciprocal"],
            of("max_albedo"),
        )?;
    }
    let below = |column: &str, most: f64| {
        rows.iter().filter(|row| number(&row[column]).is_some_and(|value| value <= most)).count()
    };
    writeln!(
        text,
        "\n{} of {} are within 1 Delta E_ITP, {} within 0.02 FLIP, {} within twice the target's largest f.",
        below("unseen_itp", 1.0),
        rows.len(),
        below("unseen_flip", 0.02),
        below("largest_over_target", 2.0),
    )?;
    Ok(text)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn table_has_a_row_for_each_material_and_medians_of_the_ratios() {
        let row = |material: &str, e_log: f64| {
            json!({"material": material, "budget_seconds": 5.0, "e_log": e_log, "operations": 9,
                   "e_log_sgd": 0.4, "e_log_abc": null, "e_log_ward": 0.5, "seconds": 4.0,
                   "generations": 7, "unseen_itp": 10.0 * e_log, "unseen_flip": 0.01})
        };
        let own = [row("gold", 0.1), row("paint", 0.3), row("cloth", 0.2)];
        let peers = by_material(
            "starting\n{\"material\": \"gold\", \"e_log\": 0.2}\n{\"material\": \"cloth\", \"e_log\": 0.2}\n",
        );
        let text = markdown(&own, &peers.unwrap(), &json!({"processor": "P"}), &[]).unwrap();
        assert!(
            text.contains("| gold | 0.10000 | 9 | 0.20000 | 0.40000 | - | 0.50000 | - |"),
            "{text}"
        );
        assert!(text.contains("| paint | 0.30000 | 9 | - | 0.40000 | - | 0.50000 | - |"), "{text}");
        assert!(text.contains("1 of 3 are within 1 Delta E_ITP, 3 within 0.02 FLIP"), "{text}");
        assert!(text.contains("| 5 s | 0.750 | 0.500 | - | 4.000 | 7.000 |"), "{text}");
    }
}
