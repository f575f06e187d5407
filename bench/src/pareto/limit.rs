//! Sweep of the effort of the search for the largest albedo: the error of cheaper searches, and how
//! frequent it is.

use anyhow::Result;
use brood_eval::{ALBEDO_ORDER, Effort, LimitSearch, directional_albedo};

use crate::chart::{Axis, Cell, Plot, Point, ResultTable, Series, cells};
use crate::measure::{fastest_ms, median, one_thread, programs, quantile};
use crate::output;
use crate::record::Finding;

/// Value drawn for an error of 0 on a logarithmic axis.
const FLOOR: f64 = 1e-7;

/// Compared searches: angles x azimuths x texture positions, and starts.
const EFFORTS: [Effort; 5] = [
    Effort {
        thetas: 8,
        azimuths: 3,
        uv_side: 2,
        grid_order: 4,
        starts: 1,
        search_order: 12,
        ..Effort::USUAL
    },
    Effort {
        thetas: 10,
        azimuths: 4,
        uv_side: 3,
        grid_order: 6,
        starts: 2,
        search_order: 12,
        ..Effort::USUAL
    },
    Effort {
        thetas: 12,
        azimuths: 6,
        uv_side: 4,
        grid_order: 6,
        starts: 4,
        search_order: 12,
        ..Effort::USUAL
    },
    Effort::USUAL,
    Effort {
        thetas: 24,
        azimuths: 12,
        uv_side: 7,
        grid_order: 12,
        starts: 12,
        halvings: 7,
        search_order: 24,
    },
];

/// Search that the others are compared with.
const EXHAUSTIVE: Effort = Effort {
    thetas: 36,
    azimuths: 16,
    uv_side: 9,
    grid_order: 16,
    starts: 24,
    halvings: 8,
    search_order: 32,
};

/// Results of one search for all genomes.
struct Outcome {
    effort: Effort,
    search: LimitSearch,
    ms: Vec<f64>,
    samples: Vec<f64>,
    /// Relative amount by which the albedo of this search is below the largest found by any search.
    missed: Vec<f64>,
    /// Relative amount by which the divisor is too small for that albedo; 0 if it suffices.
    exceeded: Vec<f64>,
}

/// Measures the finding.
pub fn measure(short: bool, seed: u64) -> Result<Finding> {
    let (genomes, repeats, effort) = if short { (2, 1, EFFORTS[3]) } else { (100, 3, EXHAUSTIVE) };
    let pool = one_thread()?;
    let exhaustive = LimitSearch::new(effort);
    let outcome = |effort: Effort| Outcome {
        effort,
        search: LimitSearch::new(effort),
        ms: Vec::new(),
        samples: Vec::new(),
        missed: Vec::new(),
        exceeded: Vec::new(),
    };
    let mut outcomes = EFFORTS.map(outcome);
    let bar = output::bar(genomes.into(), "limit");
    let mut seen = 0;
    for program in programs(seed, genomes) {
        let (_, place) = exhaustive.run(&program);
        let mut best = directional_albedo(&program, &place, ALBEDO_ORDER);
        let mut found = Vec::new();
        for outcome in &mut outcomes {
            let run = || Ok(outcome.search.run(&program));
            let (ms, (limit, place)) = pool.install(|| fastest_ms(repeats, run))?;
            let albedo = directional_albedo(&program, &place, ALBEDO_ORDER);
            best = best.max(albedo);
            outcome.ms.push(ms);
            outcome.samples.push(limit.samples as f64);
            found.push((albedo, limit.albedo * (1.0 + limit.error_bound)));
        }
        bar.inc(1);
        if best <= 0.0 {
            // Black: every search is exact.
            continue;
        }
        seen += 1;
        for (outcome, (albedo, bound)) in outcomes.iter_mut().zip(found) {
            outcome.missed.push((1.0 - albedo / best).max(0.0));
            outcome.exceeded.push((1.0 - bound / best).max(0.0));
        }
    }
    bar.finish_and_clear();
    Ok(Finding {
        name: "limit",
        note: format!(
            "{seen} random genomes that are not black; amount by which the albedo at the place found by a search (order \
             {ALBEDO_ORDER}) is below the largest found by any search, including one of {} angles x {} azimuths x {}^2 texture \
             positions and {} starts; `limit_exceeded_worst` is the amount by which the largest albedo exceeds the bound that \
             the search reports. One thread, best of {repeats}",
            effort.thetas, effort.azimuths, effort.uv_side, effort.starts,
        ),
        table: table(&outcomes),
        raw: None,
        chart: chart(&outcomes, seen).svg(),
    })
}

fn effort_name(effort: &Effort) -> String {
    let Effort { thetas, azimuths, uv_side, starts, .. } = effort;
    format!("{thetas}x{azimuths}x{uv_side}^2/{starts}")
}

fn table(outcomes: &[Outcome]) -> ResultTable {
    let mut table = ResultTable::default();
    for outcome in outcomes {
        let error = |share| quantile(&outcome.missed, share);
        let within = outcome.missed.iter().filter(|missed| **missed <= 0.01).count();
        table.push(cells! {
            knob: "effort of the limit's search",
            value: effort_name(&outcome.effort),
            time_ms: median(&outcome.ms),
            error: error(0.5),
            error_metric: "median share missed",
            error_p90: error(0.9),
            error_worst: error(1.0),
            within_1_percent: within as f64 / outcome.missed.len().max(1) as f64,
            limit_exceeded_worst: quantile(&outcome.exceeded, 1.0),
            samples: median(&outcome.samples),
            default: Cell::yes_if(outcome.effort == Effort::USUAL),
        });
    }
    table
}

fn chart(outcomes: &[Outcome], seen: u32) -> Plot {
    let series = |name: &str, share: f64| {
        let point = |outcome: &Outcome| Point {
            x: median(&outcome.ms),
            y: quantile(&outcome.missed, share).max(FLOOR),
            label: effort_name(&outcome.effort),
            is_default: outcome.effort == Effort::USUAL,
            is_detached: false,
        };
        Series::dotted(name, outcomes.iter().map(point))
    };
    Plot {
        title: "Effort of the search for the largest albedo".to_owned(),
        subtitle: format!("{seen} random genomes, one thread; missed share of the largest albedo"),
        x: Axis::log("time of the whole search, ms"),
        y: Axis::log("missed share of the albedo"),
        series: Series::label_first(
            [("worst genome", 1.0), ("90th percentile", 0.9), ("median genome", 0.5)]
                .map(|(name, share)| series(name, share)),
        ),
    }
}
