//! Time and result of a search with 1 to 8 islands, beside as many searches without islands. Both
//! run as many generations on the same processors, so their times differ mostly by what migration
//! and waiting cost.

use std::fmt::Write;

use anyhow::Result;
use serde_json::{Value, json};

use super::sample::Lab;
use super::searches::{GENERATIONS, INTERVAL, Plan, SAMPLES, STRATEGY, Searched, WORKERS, Way};
use super::statistics::quartiles;

/// Numbers of islands, and of searches beside them.
const COUNTS: [u32; 4] = [1, 2, 4, 8];

/// A search with islands, and searches without, of the same round.
type Pair = [Searched; 2];

/// Measured islands.
pub struct Islands {
    cells: Vec<(u32, Vec<Pair>)>,
}

impl Islands {
    /// Measures all numbers in turn.
    pub fn measure(lab: &Lab, rounds: u32) -> Result<Self> {
        let mut cells = COUNTS.map(|count| (count, Vec::new()));
        for _ in 0..rounds {
            for (count, pairs) in &mut cells {
                let measure = |way| Plan { way, count: *count }.measure(lab);
                pairs.push([measure(Way::Islands)?, measure(Way::Searches)?]);
            }
        }
        Ok(Self { cells: cells.into() })
    }

    /// All searches for the report.
    pub fn json(&self) -> Value {
        let cells = self.cells.iter().map(|(count, pairs)| {
            let of = |at: usize| pairs.iter().map(|pair| pair[at].json()).collect::<Vec<_>>();
            json!({ "count": count, "islands": of(0), "searches": of(1) })
        });
        json!({
            "strategy": STRATEGY,
            "generations": GENERATIONS,
            "samples": SAMPLES,
            "workers": WORKERS,
            "series": cells.collect::<Vec<_>>(),
        })
    }

    /// The table.
    pub fn markdown(&self) -> Result<String> {
        let mut text = format!(
            "\n## Searches with islands\n\nOne search with N islands, and N searches without islands with seeds of their own. \
             Each island and each search: {GENERATIONS} generations of `{STRATEGY}` with one thread, {SAMPLES} samples of a \
             glossy material. One server without quota, {WORKERS} workers; all share the machine, so that the time grows \
             with N once its processors are busy. Time: from the start of the first to the end of the last. Ratio: time \
             of the islands, of that of the N searches; 1 means that migration and waiting cost nothing. CPU time: \
             in seconds, that of the server with a question every {} ms whether a search has ended. E_log: of the best \
             material, on the validation samples. Pairs are of the islands and of the N searches. Medians, and \
             quartiles; rounds in turn: {}.\n\n\
             | N | islands, s | N searches, s | ratio | server, CPU s | PostgreSQL, CPU s | workers, CPU s | E_log \
             | operations |\n|---:|---:|---:|---:|---:|---:|---:|---:|---:|\n",
            INTERVAL.as_millis(),
            self.cells.first().map_or(0, |(_, pairs)| pairs.len()),
        );
        for (count, pairs) in &self.cells {
            let both = |figure: fn(&Searched) -> f64, digits: usize| {
                let [islands, searches] = medians(pairs, figure);
                format!("{islands:.digits$}, {searches:.digits$}")
            };
            let [islands_s, searches_s] = medians(pairs, |one| one.run_s);
            let [low, ratio, high] = ratios(pairs);
            writeln!(
                text,
                "| {count} | {islands_s:.2} | {searches_s:.2} | {ratio:.2} ({low:.2} to {high:.2}) | {} | {} | {} | {} | {} |",
                both(|one| one.server_s, 2),
                both(|one| one.database_s, 2),
                both(|one| one.workers_s, 1),
                both(|one| one.e_log, 5),
                both(|one| one.operations, 0),
            )?;
        }
        Ok(text)
    }
}

/// Medians of a figure: with islands, and without.
fn medians(pairs: &[Pair], figure: fn(&Searched) -> f64) -> [f64; 2] {
    [0, 1].map(|at| {
        let values: Vec<f64> = pairs.iter().map(|pair| figure(&pair[at])).collect();
        quartiles(&values)[1]
    })
}

/// Quartiles of the time of the islands relative to that of the searches of the same round.
fn ratios(pairs: &[Pair]) -> [f64; 3] {
    let ratio = |[islands, searches]: &Pair| islands.run_s / searches.run_s;
    quartiles(&pairs.iter().map(ratio).collect::<Vec<_>>())
}

#[cfg(test)]
mod tests {
    use super::{Islands, Searched};

    #[test]
    fn rows_have_medians_of_both_and_quartiles_of_the_ratio() {
        let of = |run_s: f64, e_log: f64| Searched {
            run_s,
            server_s: 0.25,
            database_s: 0.75,
            workers_s: 2.0 * run_s,
            e_log,
            operations: 40.0,
        };
        let pair = |run_s: f64| [of(run_s, 0.0125), of(2.0, 0.015)];
        let islands = Islands { cells: vec![(4, vec![pair(3.0), pair(2.0), pair(2.5)])] };
        let text = islands.markdown().unwrap();
        let row = "| 4 | 2.50 | 2.00 | 1.25 (1.00 to 1.50) | 0.25, 0.25 | 0.75, 0.75 | 5.0, 4.0 \
                   | 0.01250, 0.01500 | 40, 40 |";
        assert_eq!(text.lines().next_back(), Some(row), "{text}");
        assert!(text.contains("rounds in turn: 3."), "{text}");
        let json = islands.json();
        assert_eq!(json["series"][0]["islands"][1]["run_s"], 2.0, "{json}");
    }
}
