//! Computes ratios and goals from the printed results of brood and its peers.
//!
//! Pure: reads JSON values, starts nothing. A missing figure leaves out its row. The best of all
//! rounds counts on either side, because other load can only make a run slower.

use serde_json::{Value, json};

use super::measure::{Findings, Measurement};

/// Largest RMSE at which a picture of the Lambert sphere counts as correct.
const SPHERE_RMSE: f64 = 1.7e-4;
/// Shares of functions within this difference count as the same mix.
const SAME_SHARE: f64 = 0.03;

/// A figure of a peer and of brood for the same work.
#[derive(Debug, Clone, PartialEq)]
pub struct Row {
    /// Work done.
    pub work: &'static str,
    /// Description of the peer's figure.
    pub peer: String,
    /// The peer's figure.
    pub peer_value: f64,
    /// Description of brood's figure.
    pub brood: String,
    /// brood's figure.
    pub brood_value: f64,
    /// Unit of both figures.
    pub unit: &'static str,
    /// Speed of brood over the peer's; `None` if the figures are not speeds.
    pub ratio: Option<f64>,
    /// Intended ratio.
    pub goal: Option<f64>,
}

impl Row {
    /// Row as it is written to the report.
    pub fn json(&self) -> Value {
        json!({
            "work": self.work,
            "peer": self.peer,
            "peer_value": self.peer_value,
            "brood": self.brood,
            "brood_value": self.brood_value,
            "unit": self.unit,
            "ratio": self.ratio,
            "goal": self.goal,
        })
    }
}

/// All comparisons with the available results.
pub fn rows(findings: &Findings) -> Vec<Row> {
    let mut rows = Vec::new();
    rows.extend(operations(findings, "add, sub, mul", "add sub mul", "add sub mul", 6.0));
    let functions = "add sub mul sin exp";
    rows.extend(operations(findings, "the paper's opcodes", functions, "paper's opcodes", 3.0));
    let work = "add, sub, mul, sin, exponential";
    rows.extend(operations(findings, work, functions, "add sub mul sin ex2", 3.0));
    rows.extend(finite(findings));
    rows.extend(sphere(findings));
    rows.extend(new_materials(findings));
    rows.extend(known_materials(findings));
    rows
}

/// Results that were measured but give no row, as sentences.
pub fn gaps(findings: &Findings) -> Vec<String> {
    let gap = |work: Measurement| {
        let (rmse, _) = least(all_rows(findings, work).into_iter(), "rmse")?;
        let name = work.name();
        (rmse > SPHERE_RMSE).then(|| {
            format!("{name}: the smallest RMSE must be at most {SPHERE_RMSE:.1e}, got {rmse:.2e}")
        })
    };
    [Measurement::BroodSphere, Measurement::MitsubaSphere].into_iter().filter_map(gap).collect()
}

/// All rows of all rounds of one measurement, whether the JSON is a list or has a list `rows`.
fn all_rows(findings: &Findings, work: Measurement) -> Vec<&Value> {
    findings.of(work).iter().flat_map(rows_of_round).collect()
}

fn rows_of_round(value: &Value) -> &[Value] {
    let rows = value.as_array().or_else(|| value["rows"].as_array());
    rows.map_or(&[], Vec::as_slice)
}

/// Row with the largest value under `key`.
fn best<'a>(rows: impl Iterator<Item = &'a Value>, key: &str) -> Option<(f64, &'a Value)> {
    let valued = rows.filter_map(|row| Some((row[key].as_f64()?, row)));
    valued.max_by(|a, b| a.0.total_cmp(&b.0))
}

/// Row with the smallest value under `key`.
fn least<'a>(rows: impl Iterator<Item = &'a Value>, key: &str) -> Option<(f64, &'a Value)> {
    let valued = rows.filter_map(|row| Some((row[key].as_f64()?, row)));
    valued.min_by(|a, b| a.0.total_cmp(&b.0))
}

/// Two rows: against operations as defined, and against all nodes, which also counts the peer's
/// leaves.
fn operations(
    findings: &Findings,
    work: &'static str,
    peer_mix: &str,
    brood_mix: &str,
    goal: f64,
) -> Vec<Row> {
    let of_brood = all_rows(findings, Measurement::BroodOperations);
    let of_brood = of_brood.into_iter().filter(|row| row["mix"] == brood_mix);
    let Some((brood_value, row)) = best(of_brood, "executed_per_second") else { return vec![] };
    let level = row["level"].as_str().unwrap_or("best level");
    let peer_rows = all_rows(findings, Measurement::OperonOperations);
    let peer_rows: Vec<&Value> =
        peer_rows.into_iter().filter(|row| row["mix"] == peer_mix).collect();
    let peer_rows = of_share(peer_rows, row["function_share"].as_f64());
    let make = |key: &str, what: &str, goal| {
        let (peer_value, row) = best(peer_rows.iter().copied(), key)?;
        let share = row["function_share"].as_f64().unwrap_or_default();
        let length = row["nodes_per_program"].as_f64().unwrap_or_default();
        Some(Row {
            work,
            peer: format!(
                "pyoperon, {what}, trees of {length:.0} nodes, {:.0} % functions",
                100.0 * share
            ),
            peer_value,
            brood: format!("executed operations, {level}"),
            brood_value,
            unit: "1/s",
            ratio: Some(brood_value / peer_value),
            goal,
        })
    };
    let rows = [
        make("operations_per_second", "non-leaf nodes", Some(goal)),
        make("nodes_per_second", "all nodes including leaves", None),
    ];
    rows.into_iter().flatten().collect()
}

/// The peer's rows with about brood's share of functions. Without a share, the rows with the
/// smallest one, which are the peer's fastest.
fn of_share(rows: Vec<&Value>, share: Option<f64>) -> Vec<&Value> {
    let share_of = |row: &Value| row["function_share"].as_f64().unwrap_or_default();
    let distance = |row: &Value| (share_of(row) - share.unwrap_or(0.0)).abs();
    let nearest = rows.iter().map(|row| distance(row)).fold(f64::INFINITY, f64::min);
    rows.into_iter().filter(|row| distance(row) <= nearest + SAME_SHARE).collect()
}

fn finite(findings: &Findings) -> Vec<Row> {
    let Some(stress) = findings.of(Measurement::BroodStress).first() else { return vec![] };
    let (Some(bad), Some(evaluations)) =
        (stress["not_finite"].as_f64(), stress["evaluations_per_level"].as_f64())
    else {
        return vec![];
    };
    let peers = findings.of(Measurement::OperonOperations).first();
    let peers = peers.and_then(|value| value["finite"].as_array()).map_or(&[][..], Vec::as_slice);
    let row = |peer: &Value| {
        let (mix, sizes) = (peer["mix"].as_str()?, peer["coefficients"].as_str()?);
        Some(Row {
            work: "random programs with only finite values",
            peer: format!("pyoperon, {mix}, coefficients {sizes}"),
            peer_value: 100.0 * peer["finite_programs_share"].as_f64()?,
            brood: format!(
                "values of {evaluations:.0} evaluations, all dialects, constants up to +-65504"
            ),
            brood_value: 100.0 * (1.0 - bad / evaluations),
            unit: "%",
            ratio: None,
            goal: None,
        })
    };
    peers.iter().filter_map(row).collect()
}

/// Two rows: with the sample set precomputed, as in breeding, and including the time to build it.
fn sphere(findings: &Findings) -> Vec<Row> {
    let exact = |row: &&Value| row["rmse"].as_f64().is_some_and(|rmse| rmse <= SPHERE_RMSE);
    let peers = all_rows(findings, Measurement::MitsubaSphere).into_iter().filter(exact);
    let own: Vec<Value> = all_rows(findings, Measurement::BroodSphere)
        .into_iter()
        .filter(exact)
        .map(with_set)
        .collect();
    let Some((peer_value, peer)) = least(peers, "ms") else { return vec![] };
    let error = |row: &Value| row["rmse"].as_f64().unwrap_or(f64::NAN);
    let make = |key: &str, what: &str, goal| {
        let (brood_value, own) = least(own.iter(), key)?;
        let mode = own["mode"].as_str().map_or_else(|| own["mode"].to_string(), str::to_owned);
        Some(Row {
            work: "256 x 256 Lambert sphere, RMSE at most 1.7e-4",
            peer: format!(
                "Mitsuba, 2 threads, {} samples a pixel, RMSE {:.2e}",
                peer["spp"],
                error(peer)
            ),
            peer_value,
            brood: format!("1 thread, {what}, samples {mode}, RMSE {:.2e}", error(own)),
            brood_value,
            unit: "ms",
            ratio: Some(peer_value / brood_value),
            goal,
        })
    };
    let rows = [
        make("picture_ms_one_thread", "sample set precomputed", Some(30.0)),
        make("cold_ms", "sample set built", None),
    ];
    rows.into_iter().flatten().collect()
}

/// Adds the time of a picture including its sample set.
fn with_set(row: &Value) -> Value {
    let mut row = row.clone();
    let time = |key: &str| row[key].as_f64();
    if let (Some(picture), Some(set)) = (time("picture_ms_one_thread"), time("set_ms_one_thread")) {
        row["cold_ms"] = json!(picture + set);
    }
    row
}

/// Smallest time over all rounds of brood's thumbnails, in memory and over HTTP.
fn brood_thumbnails(findings: &Findings) -> Vec<(&'static str, f64)> {
    let smallest = |work, pointers: &[&str]| {
        let values = findings.of(work).iter().filter_map(|value| {
            let found = pointers.iter().find_map(|pointer| value.pointer(pointer));
            found.and_then(Value::as_f64)
        });
        values.reduce(f64::min)
    };
    // The minimum of a run if it is reported, as for the peer; otherwise the reported total.
    let frame =
        smallest(Measurement::BroodFrame, &["/total_ms/min_ms", "/total_ms/min", "/total_ms"]);
    let breed = smallest(Measurement::BroodBreed, &["/total/median_ms"]);
    let memory =
        frame.map(|ms| ("20 new programs lowered, shaded and encoded in memory, 2 threads", ms));
    let http = breed.map(|ms| ("breed over HTTP to the last byte of 21 PNGs, median", ms));
    memory.into_iter().chain(http).collect()
}

fn new_materials(findings: &Findings) -> Vec<Row> {
    let peers = all_rows(findings, Measurement::MitsubaNew);
    let kinds = ["expressions", "nested built-in materials"];
    let peers = kinds.into_iter().filter_map(|kind| {
        let of_kind = peers.iter().copied().filter(|row| row["kind"] == kind);
        Some((kind, least(of_kind, "total_ms")?))
    });
    let peers: Vec<_> = peers.collect();
    let pair = |(brood, brood_value): (&'static str, f64)| {
        let peers = peers.clone().into_iter();
        peers.map(move |(kind, (peer_value, row))| {
            let peer = format!("{kind}, {} kernels compiled", row["kernels_compiled"]);
            materials("20 new materials, 128 x 128", &peer, peer_value, (brood, brood_value))
        })
    };
    brood_thumbnails(findings).into_iter().flat_map(pair).collect()
}

/// Row of a comparison of twenty thumbnails with Mitsuba.
fn materials(
    work: &'static str,
    peer: &str,
    peer_value: f64,
    (brood, brood_value): (&str, f64),
) -> Row {
    Row {
        work,
        peer: format!("Mitsuba, 2 threads, 4 samples a pixel, {peer}"),
        peer_value,
        brood: brood.to_owned(),
        brood_value,
        unit: "ms",
        ratio: Some(peer_value / brood_value),
        goal: None,
    }
}

/// Materials with changed parameters: the peer reuses its compiled kernel, brood lowers the
/// programs again.
fn known_materials(findings: &Findings) -> Vec<Row> {
    let Some((brood, brood_value)) = brood_thumbnails(findings).into_iter().next() else {
        return vec![];
    };
    let peers = all_rows(findings, Measurement::MitsubaKnown);
    let row = |material: &str| {
        let of_material = peers.iter().copied().filter(|row| row["material"] == material);
        let (peer_value, _) = least(of_material, "total_ms")?;
        let peer = format!("{material}, kernel warm");
        let work = "20 materials with other parameters, 128 x 128";
        Some(materials(work, &peer, peer_value, (brood, brood_value)))
    };
    ["diffuse", "roughconductor", "principled"].into_iter().filter_map(row).collect()
}

#[cfg(test)]
mod tests {
    use super::{gaps, of_share, rows};
    use crate::bench::measure::{Findings, Measurement};
    use serde_json::{Value, json};

    fn findings(results: &[(Measurement, Value)]) -> Findings {
        let mut findings = Findings::with_missing(vec![]);
        for (work, value) in results {
            findings.add(*work, value.clone());
        }
        findings
    }

    #[test]
    fn operations_are_compared_by_the_best_of_all_rounds_and_levels() {
        let peer = |rate: f64| {
            json!({"rows": [{"mix": "add sub mul", "function_share": 0.0,
            "operations_per_second": rate, "nodes_per_second": 2.0 * rate, "nodes_per_program": 50}]})
        };
        let own = |level: &str, rate: f64| json!({"mix": "add sub mul", "level": level, "executed_per_second": rate});
        let found = rows(&findings(&[
            (Measurement::OperonOperations, peer(1e9)),
            (Measurement::OperonOperations, peer(2e9)),
            (Measurement::BroodOperations, json!([own("sse2", 9e9), own("avx2", 16e9)])),
            (Measurement::BroodOperations, json!({"rows": [own("avx2", 14e9)]})),
        ]));
        assert_eq!(found.len(), 2, "{found:?}");
        assert_eq!((found[0].ratio, found[0].goal), (Some(8.0), Some(6.0)));
        assert_eq!(found[1].ratio, Some(4.0));
        assert!(found[0].brood.contains("avx2"), "{found:?}");
    }

    #[test]
    fn peer_mix_has_the_nearest_share_of_functions() {
        let values: Vec<Value> =
            [0.1, 0.15, 0.16, 0.4].map(|share| json!({"function_share": share})).to_vec();
        let near = |share| of_share(values.iter().collect(), share).len();
        assert_eq!(near(Some(0.14)), 2);
        assert_eq!(near(Some(0.9)), 1);
        assert_eq!(near(None), 1);
    }

    #[test]
    fn sphere_is_compared_by_the_cheapest_picture_that_is_exact_enough() {
        let peer = json!({"rows": [{"spp": 64, "rmse": 2e-4, "ms": 1.0}, {"spp": 100, "rmse": 1.6e-4, "ms": 90.0},
            {"spp": 128, "rmse": 1.2e-4, "ms": 60.0}]});
        let own = json!({"rows": [{"mode": "1", "rmse": 1e-3, "picture_ms_one_thread": 0.1},
            {"mode": "adaptive", "rmse": 1e-4, "picture_ms_one_thread": 0.5, "set_ms_one_thread": 5.5}]});
        let found = rows(&findings(&[
            (Measurement::MitsubaSphere, peer.clone()),
            (Measurement::BroodSphere, own),
        ]));
        let ratios: Vec<_> = found.iter().map(|row| row.ratio).collect();
        assert_eq!(ratios, [Some(120.0), Some(10.0)]);
        assert!(found[0].peer.contains("128 samples"));
        assert_eq!(rows(&findings(&[(Measurement::MitsubaSphere, peer)])), vec![]);
    }

    #[test]
    fn gap_is_reported_when_no_picture_is_exact_enough() {
        let own = json!({"rows": [{"rmse": 1e-3}, {"rmse": 1.9e-4}]});
        let found = gaps(&findings(&[(Measurement::BroodSphere, own)]));
        assert_eq!(found.len(), 1, "{found:?}");
        assert!(found[0].contains("1.90e-4"), "{found:?}");
        let own = json!({"rows": [{"rmse": 1e-3}, {"rmse": 1.7e-4}]});
        assert_eq!(gaps(&findings(&[(Measurement::BroodSphere, own)])), Vec::<String>::new());
    }

    #[test]
    fn new_materials_are_compared_in_memory_and_over_http() {
        let peer =
            json!({"rows": [{"kind": "expressions", "total_ms": 2000.0, "kernels_compiled": 20}]});
        let frame = json!({"size_px": 128, "total_ms": {"median_ms": 4.0, "min_ms": 2.0}});
        let breed = json!({"total": {"median_ms": 20.0}});
        let found = rows(&findings(&[
            (Measurement::MitsubaNew, peer),
            (Measurement::BroodFrame, frame),
            (Measurement::BroodBreed, breed),
        ]));
        let ratios: Vec<_> = found.iter().map(|row| row.ratio).collect();
        assert_eq!(ratios, [Some(1000.0), Some(100.0)]);
    }

    #[test]
    fn no_row_is_made_without_results() {
        assert_eq!(rows(&findings(&[])), vec![]);
    }
}
