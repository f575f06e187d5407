//! Comparison with peers as a Markdown page: results, method and differences.

use std::fmt::Write as _;

use serde_json::Value;

use super::compare::Row;
use super::environment::Environment;
use super::measure::Findings;
use super::not_compared;

/// Notes on the method, for readers of the ratios.
const NOTES: &str = "\
An operation is one non-leaf scalar primitive on one sample; brood's are counted after lowering. 4096 samples of \
32-bit floats, one thread, the fastest pass. Differences:
- brood clamps every sum and product to +-65504 and never returns non-finite values; pyoperon does not clamp. brood's \
sin and 2^x are accurate to 2 units in the last place; pyoperon's exponential is e^x, its functions come from its own \
vector library.
- A variable leaf of pyoperon has a coefficient, a product that the count of non-leaf nodes leaves out; the \
row with all nodes includes it, and constants as well.
- pyoperon's trees come from its balanced creator; the frequency of sin and exp is chosen so that their share is that of \
brood's programs. Translation is included on both sides, and so is output: one value per sample for pyoperon, three for brood.
- Mitsuba renders an analytic sphere with a box filter, emitter sampling only, into 32-bit floats in numpy. Times are \
the smallest of many with kernels warm, except for new materials, which Dr.Jit has to compile. Loading the scene is included for \
those, as lowering is for brood. brood's thumbnails are antialiased, developed and encoded as PNG; Mitsuba's are not.
- Each picture of the Lambert sphere is compared with a reference of 4096 samples per pixel of the same program. With a \
delta light only the edge of the sphere, the edge of its lit side and the curvature within a pixel \
cause errors. brood caches the sample set of a mesh, camera, size and light, so the first row is the cost of another material; \
Mitsuba traces its rays each time, so the second row adds the time to build the set.
";

/// Renders the page.
pub fn markdown(rows: &[Row], findings: &Findings, environment: &Environment) -> String {
    let machine = environment.machine();
    let mut page = String::from("# brood and its peers\n\n");
    page.push_str(&heading(&machine));
    page.push_str(&table(rows));
    page.push_str(&not_compared(&findings.missing));
    let _ = write!(page, "\n{NOTES}");
    page
}

/// Machine and versions in one line.
pub fn heading(machine: &Value) -> String {
    let field = |key: &str| machine[key].as_str().unwrap_or("not known").to_owned();
    let peers = machine["peers"].as_object().into_iter().flatten();
    let versions: Vec<String> = peers
        .map(|(name, version)| format!("{name} {}", version.as_str().unwrap_or("?")))
        .collect();
    format!(
        "{}, {} cores; {}, profile {}, {}; {}; {}. One run, programs alternating.\n\n",
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

/// A figure with its unit, to about three digits.
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
