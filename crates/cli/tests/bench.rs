//! Short forms of the benchmarks: each runs, prints JSON and writes its files.
#![expect(clippy::unwrap_used, reason = "a test may fail by panicking anywhere")]

use std::path::Path;
use std::process::{Command, Stdio};

use serde_json::Value;

fn bench(words: &[&str]) -> String {
    let output = Command::new(env!("CARGO_BIN_EXE_brood"))
        .arg("bench")
        .args(words)
        .stdin(Stdio::null())
        .output()
        .expect("the binary must start");
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{words:?}: {stderr}");
    String::from_utf8(output.stdout).unwrap()
}

/// Runs a benchmark with `--json` and `--out`; checks that it prints the JSON that it writes.
fn recorded(words: &[&str], dir: &Path, name: &str) -> Value {
    let mut all = words.to_vec();
    all.extend(["--json", "--out", dir.to_str().unwrap()]);
    let json: Value = serde_json::from_str(&bench(&all)).unwrap();
    let file = std::fs::read_to_string(dir.join(format!("{name}.json"))).unwrap();
    assert_eq!(json, serde_json::from_str::<Value>(&file).unwrap());
    json
}

/// Checks that a chart is a complete SVG without NaN or infinity, and that its CSV has rows.
fn has_chart(dir: &Path, name: &str) {
    let svg = std::fs::read_to_string(dir.join(format!("{name}.svg"))).unwrap();
    assert!(svg.starts_with("<svg ") && svg.ends_with("</svg>\n"), "{name}");
    assert!(!svg.contains("NaN") && !svg.contains("inf"), "{name}: {svg}");
    let csv = std::fs::read_to_string(dir.join(format!("{name}.csv"))).unwrap();
    assert!(csv.lines().count() > 1, "{name}: {csv}");
}

#[test]
fn pareto_writes_a_chart_for_each_sweep() {
    let dir = tempfile::tempdir().unwrap();
    let json = recorded(&["pareto", "--short"], dir.path(), "pareto");
    for name in ["samples-sphere", "samples-knob", "precision", "albedo", "prefix", "backend"] {
        has_chart(dir.path(), name);
        let rows = json[name]["rows"].as_array().unwrap();
        for row in rows {
            for key in ["knob", "value", "time_ms", "error", "error_metric"] {
                assert!(!row[key].is_null(), "{name}: {key} in {row}");
            }
            assert!(row["time_ms"].as_f64().unwrap() > 0.0, "{name}: {row}");
        }
        let defaults = rows.iter().filter(|row| row["default"] == "yes").count();
        assert!(defaults <= 1, "{name}: {defaults} defaults");
    }
    // More samples give a smaller error on any sphere.
    let rows = json["samples-sphere"]["rows"].as_array().unwrap();
    let error = |mode: &str| {
        let row = rows.iter().find(|row| row["value"] == mode).unwrap();
        row["error"].as_f64().unwrap()
    };
    assert!(error("1") > error("16") && error("1") > error("adaptive"), "{rows:?}");
}

#[test]
fn lambert_sphere_has_a_row_for_each_mode() {
    let dir = tempfile::tempdir().unwrap();
    let words = ["pareto", "--scene", "lambert-sphere", "--short"];
    let json = recorded(&words, dir.path(), "lambert-sphere");
    has_chart(dir.path(), "lambert-sphere");
    let rows = json["rows"].as_array().unwrap();
    let rmse = |mode: &str| {
        let row = rows.iter().find(|row| row["mode"] == mode).unwrap();
        assert!(row["picture_ms_one_thread"].as_f64().unwrap() > 0.0, "{row}");
        assert!(row["set_ms_one_thread"].as_f64().unwrap() > 0.0, "{row}");
        row["rmse"].as_f64().unwrap()
    };
    assert!(rmse("1") > 2.0 * rmse("64") && rmse("1") > 2.0 * rmse("adaptive"), "{rows:?}");
    assert!(json["reference_rmse"].as_f64().unwrap() < rmse("16"), "{json}");
}

#[test]
fn skip_measures_every_kind_with_and_without() {
    let dir = tempfile::tempdir().unwrap();
    let json = recorded(&["skip", "--short"], dir.path(), "skip");
    has_chart(dir.path(), "skip");
    let rows = json["skip"]["rows"].as_array().unwrap();
    assert!(rows.len() >= 12, "{rows:?}");
    for row in rows {
        // A whole brood may read every input; everything else skips some work.
        assert!(row["with"].as_f64().unwrap() <= row["without"].as_f64().unwrap(), "{row}");
        assert!(row["times_faster"].as_f64().unwrap() > 0.0, "{row}");
    }
}

#[test]
fn ops_and_stress_leave_their_files() {
    let dir = tempfile::tempdir().unwrap();
    let words = ["ops", "--programs", "5", "--passes", "1"];
    let json = recorded(&words, dir.path(), "ops");
    has_chart(dir.path(), "ops");
    assert!(json[0]["executed_per_second"].as_f64().unwrap() > 0.0, "{json}");
    let words =
        ["stress", "--evaluations", "1", "--pairs", "1", "--pictures", "8", "--meshes", "6"];
    let json = recorded(&words, dir.path(), "stress");
    has_chart(dir.path(), "stress");
    for key in ["not_finite", "negative", "differing_from_scalar", "swapped_inputs_differing"] {
        assert_eq!(json[key], 0, "{key}");
    }
    assert_eq!(json["evaluations_per_level"], 64 * 4096);
    assert_eq!(json["mesh_samples_not_finite"], 0);
}

#[test]
fn derivative_measures_both_directions_for_every_group() {
    let dir = tempfile::tempdir().unwrap();
    let words = ["derivative", "--genomes", "40", "--samples", "300", "--repeats", "1"];
    let json = recorded(&words, dir.path(), "derivative");
    let rows = json.as_array().unwrap();
    assert!(rows.len() >= 3, "{json}");
    for row in rows {
        for key in ["plain_us", "forward_us", "reverse_us"] {
            assert!(row[key].as_f64().unwrap() > 0.0, "{key} in {row}");
        }
        assert!(row["constants_min"].as_u64() <= row["constants_max"].as_u64(), "{row}");
    }
}

#[test]
fn amounts_of_variation_change_pictures() {
    let dir = tempfile::tempdir().unwrap();
    let json = recorded(
        &["amount", "--count", "40", "--seeds", "2", "--size", "24"],
        dir.path(),
        "amount",
    );
    has_chart(dir.path(), "amount");
    let mean = |from: &str, value: f64| {
        let rows = json["amount"]["rows"].as_array().unwrap();
        let is = |row: &&Value| {
            row["from"] == from && (row["value"].as_f64().unwrap() - value).abs() < 1e-6
        };
        rows.iter().find(is).unwrap()["mean"].as_f64().unwrap()
    };
    // Equal at 0 and farther with more mutation; with less of the first parent the second comes
    // nearer.
    for from in ["the parent", "the first parent"] {
        let means = [0.0, 0.1, 0.4, 1.0].map(|value| mean(from, value));
        assert_eq!(means[0], 0.0);
        assert!(means.is_sorted() && means[3] > 0.2, "{from}: {means:?}");
    }
    let means = [1.0, 0.9, 0.5, 0.0].map(|value| mean("the second parent", value));
    assert!(means[0] < 0.02 && means.is_sorted(), "{means:?}");
}
