//! The comparison as a page of markdown: what was measured, how it was counted, and what differs.

use std::fmt::Write as _;

use serde_json::Value;

use super::compare::Row;
use super::environment::Environment;
use super::measure::Findings;

/// What a reader has to know to judge the ratios.
const NOTES: &str = "\
An operation is one non-leaf scalar primitive on one sample; brood's are those that run after lowering. 4096 samples of \
32-bit floats, one thread, the fastest pass of all. What differs:
- brood clamps every sum and product to +-65504 and never gives what is not finite; pyoperon does not clamp. brood's \
sin and 2^x are exact to 2 units of the last place; pyoperon's exponential is e^x, its functions are those of its own \
vector library.
- A variable leaf of pyoperon carries a coefficient, one product more that the count of non-leaf nodes leaves out: the \
row with all nodes counts it, and constants as well.
- pyoperon's trees are its balanced creator's; the frequency of sin and exp is chosen so that their share is that of \
brood's programs. Translation is included on both sides, and so is output: one value of a sample for pyoperon, three for brood.
- Mitsuba draws an analytic sphere with a box filter, emitter sampling only, into 32-bit floats in numpy. Times are \
the smallest of many, kernels warm, but for new materials, where Dr.Jit has to compile. Loading the scene counts for \
those, as lowering does for brood. brood's thumbnails are antialiased, developed and encoded as PNG; Mitsuba's are not.
- Each picture of the Lambert sphere is held against a reference of 4096 samples a pixel of the same program. With a \
light that is a delta nothing but the border of the sphere, the border of its lit side and the curvature within a pixel \
makes an error. brood keeps the sample set of a mesh, camera, size and light, so the first row is what another material \
costs; Mitsuba traces its rays each time, which the second row grants it by adding the making of the set.
";

/// The page.
pub fn markdown(rows: &[Row], findings: &Findings, environment: &Environment) -> String {
    let machine = environment.machine();
    let mut page = String::from("# brood and its peers\n\n");
    page.push_str(&heading(&machine));
    page.push_str(&table(rows));
    if !findings.missing.is_empty() {
        page.push_str("\nNot compared:\n");
        for missing in &findings.missing {
            let _ = writeln!(page, "- {missing}");
        }
    }
    let _ = write!(page, "\n{NOTES}");
    page
}

/// What the figures depend on, in a line.
pub fn heading(machine: &Value) -> String {
    let field = |key: &str| machine[key].as_str().unwrap_or("not known").to_owned();
    let peers = machine["peers"].as_object().into_iter().flatten();
    let versions: Vec<String> = peers
        .map(|(name, version)| format!("{name} {}", version.as_str().unwrap_or("?")))
        .collect();
    format!(
        "{}, {} cores; {}, profile {}, {}; {}; {}. One run, in turn.\n\n",
        field("processor"),
        machine["cores"],
        field("brood_version"),
        field("brood_profile"),
        field("rustc"),
        if versions.is_empty() { "no peer".to_owned() } else { versions.join(", ") },
        field("libllvm"),
    )
}

fn table(rows: &[Row]) -> String {
    let mut text = String::from(
        "| work | peer | | brood | | ratio | goal |\n|---|---|---:|---|---:|---:|---:|\n",
    );
    for row in rows {
        let times =
            |ratio: Option<f64>| ratio.map_or_else(String::new, |ratio| format!("{ratio:.3}"));
        let _ = writeln!(
            text,
            "| {} | {} | {} | {} | {} | {} | {} |",
            row.work,
            row.peer,
            figure(row.peer_value, row.unit),
            row.brood,
            figure(row.brood_value, row.unit),
            row.ratio.map_or_else(String::new, |ratio| format!("{ratio:.1}x")),
            times(row.goal).trim_end_matches('0').trim_end_matches('.'),
        );
    }
    text
}

/// A figure with its unit, to three digits or so.
fn figure(value: f64, unit: &str) -> String {
    match unit {
        "1/s" => format!("{:.2} G/s", value / 1e9),
        "%" => format!("{value:.1} %"),
        unit if value < 10.0 => format!("{value:.3} {unit}"),
        unit => format!("{value:.1} {unit}"),
    }
}

#[cfg(test)]
mod tests {
    use super::{figure, table};
    use crate::bench::compare::Row;

    #[test]
    fn table_shows_ratio_and_goal() {
        let row = Row {
            work: "w",
            peer: "p".to_owned(),
            peer_value: 1.5e9,
            brood: "b".to_owned(),
            brood_value: 9e9,
            unit: "1/s",
            ratio: Some(6.0),
            goal: Some(6.0),
        };
        let text = table(&[row]);
        assert!(text.ends_with("| w | p | 1.50 G/s | b | 9.00 G/s | 6.0x | 6 |\n"), "{text}");
    }

    #[test]
    fn figure_has_its_unit() {
        assert_eq!(figure(0.4, "ms"), "0.400 ms");
        assert_eq!(figure(120.04, "ms"), "120.0 ms");
        assert_eq!(figure(21.9, "%"), "21.9 %");
    }
}
