//! Check of the energy limit: random subjects under the limit are measured by brute force, with
//! other quadratures, on other and more directions, for several efforts of the search.

mod fine_albedo;
mod fine_search;
mod subject;

use anyhow::Result;
use brood_eval::{ClimbStage, Effort, EnergyLimit, FLATTEST_COS, LimitSearch, UNBOUNDED_COS};
use brood_program::Program;

use crate::chart::{Axis, Cell, Plot, Point, Quartiles, ResultTable, Series, cells};
use crate::measure::{fastest_ms, one_thread, quantile};
use crate::output;
use crate::record::Finding;

use fine_search::{FineEffort, FineSearch};
use subject::{DrawnSubject, SubjectKind, subjects};

/// Largest albedo of a material that conserves energy, with the tolerance of the check.
const LARGEST: f64 = 1.0 + 1e-3;
/// Value drawn for a surplus of 0 on a logarithmic axis.
const FLOOR: f64 = 1e-6;

/// Compared efforts, the least first.
const EFFORTS: [(&str, Effort); 2] = [
    (
        "half",
        Effort {
            steep: 10,
            flat: 6,
            azimuths: 6,
            uv_side: 4,
            scattered: 1024,
            starts: 10,
            scattered_starts: 8,
            stages: [
                ClimbStage { climbers: [6, 4, 2], ..Effort::USUAL.stages[0] },
                ClimbStage { order: 24, climbers: [2, 1, 1], ..Effort::USUAL.stages[1] },
            ],
            ..Effort::USUAL
        },
    ),
    ("usual", Effort::USUAL),
];

/// Results of one effort for one subject.
struct Outcome {
    ms: f64,
    limit: EnergyLimit,
}

/// Results for one subject.
struct Row {
    subject: DrawnSubject,
    /// Largest albedo by brute force, without the limit.
    albedo: f64,
    place: String,
    /// By [`EFFORTS`].
    outcomes: [Outcome; EFFORTS.len()],
}

impl Row {
    /// Largest albedo under the limit of an effort.
    fn limited(&self, effort: usize) -> f64 {
        self.albedo / self.outcomes[effort].limit.divisor
    }

    /// Share by which the limit of an effort makes the subject darker than needed; `None` if it
    /// needs no limit and has none.
    fn surplus(&self, effort: usize) -> Option<f64> {
        let divisor = self.outcomes[effort].limit.divisor;
        (divisor > 1.0).then(|| (1.0 - self.albedo.max(1.0) / divisor).max(0.0))
    }
}

/// Measures the finding.
pub fn measure(short: bool, seeds: &[u64]) -> Result<Finding> {
    let (of_each, effort) = if short { (5, FineEffort::SHORT) } else { (100, FineEffort::FULL) };
    let count = seeds.len() as u32 * of_each;
    let pool = one_thread()?;
    let searches = EFFORTS.map(|(_, effort)| LimitSearch::new(effort));
    let [all, bounded] = [FLATTEST_COS, UNBOUNDED_COS].map(|cos| FineSearch::new(effort, cos));
    let bar = output::bar(count.into(), "limit");
    let mut rows = Vec::new();
    for subject in seeds.iter().flat_map(|seed| subjects(*seed, of_each)) {
        let program = &subject.program;
        let mut outcomes = Vec::new();
        for search in &searches {
            let (ms, (limit, _)) = pool.install(|| fastest_ms(1, || Ok(search.run(program))))?;
            outcomes.push(Outcome { ms, limit });
        }
        let fine = if reaches_horizon(program) { &all } else { &bounded };
        let found = fine.largest(program);
        let outcomes =
            outcomes.try_into().unwrap_or_else(|_| unreachable!("one outcome per effort"));
        rows.push(Row { subject, albedo: found.albedo, place: found.place.to_string(), outcomes });
        bar.inc(1);
    }
    bar.finish_and_clear();
    Ok(Finding {
        name: "limit",
        note: format!(
            "{count} random subjects of {} seeds under the energy limit; `above` counts those whose largest albedo by brute force \
             exceeds 1 + 1e-3. Brute force: {} elevations to cosine {FLATTEST_COS:e} ({UNBOUNDED_COS:e} if a layer is \
             unbounded at the horizon), {} azimuths, {}^2 texture positions, {} outgoing directions, then {} local searches \
             and {} directions; layers by adaptive subdivision. The surplus is the share by which a subject is darker than \
             needed. One thread",
            seeds.len(),
            effort.elevations + effort.flat,
            effort.azimuths,
            effort.side,
            effort.scan_nodes,
            effort.starts,
            effort.final_nodes,
        ),
        table: table(&rows),
        raw: Some(raw(&rows)),
        chart: chart(&rows).into(),
    })
}

/// True if all layers stay bounded at the horizon, so that the search reaches it.
fn reaches_horizon(program: &Program) -> bool {
    program.layers().iter().all(brood_brdf::Model::is_bounded_at_horizon)
}

fn table(rows: &[Row]) -> ResultTable {
    let mut table = ResultTable::default();
    for (effort, (name, kind)) in EFFORTS.iter().enumerate() {
        for group in SubjectKind::ALL {
            let of: Vec<&Row> = rows.iter().filter(|row| row.subject.group == group).collect();
            let limited: Vec<f64> = of.iter().map(|row| row.limited(effort)).collect();
            let surplus: Vec<f64> = of.iter().filter_map(|row| row.surplus(effort)).collect();
            let ms: Vec<f64> = of.iter().map(|row| row.outcomes[effort].ms).collect();
            table.push(cells! {
                effort: *name,
                subjects: group.name(),
                count: of.len(),
                above: limited.iter().filter(|albedo| **albedo > LARGEST).count(),
                largest: quantile(&limited, 1.0),
                divided: surplus.len(),
                surplus_median: quantile(&surplus, 0.5),
                surplus_p90: quantile(&surplus, 0.9),
                surplus_p99: quantile(&surplus, 0.99),
                ms_median: quantile(&ms, 0.5),
                ms_p95: quantile(&ms, 0.95),
                ms_max: quantile(&ms, 1.0),
                default: Cell::yes_if(*kind == Effort::USUAL),
            });
        }
    }
    table
}

fn raw(rows: &[Row]) -> ResultTable {
    let mut table = ResultTable::default();
    for (index, row) in rows.iter().enumerate() {
        for (effort, (name, _)) in EFFORTS.iter().enumerate() {
            let Outcome { ms, limit } = &row.outcomes[effort];
            table.push(cells! {
                subject: index,
                about: row.subject.about.clone(),
                effort: *name,
                albedo: row.albedo,
                place: row.place.clone(),
                found: limit.albedo,
                error_bound: limit.error_bound,
                limited: row.limited(effort),
                ms: *ms,
            });
        }
    }
    table
}

fn chart(rows: &[Row]) -> Plot {
    let series = |group: SubjectKind| {
        let point = |effort: usize| {
            let of = || rows.iter().filter(move |row| row.subject.group == group);
            let ms: Vec<f64> = of().map(|row| row.outcomes[effort].ms).collect();
            let surplus: Vec<f64> =
                of().filter_map(|row| row.surplus(effort)).map(|share| share.max(FLOOR)).collect();
            let (x, y) = (Quartiles::of(&ms), Quartiles::of(&surplus));
            Point {
                x: x.median,
                x_spread: x.spread(),
                y: y.median,
                y_spread: y.spread(),
                label: EFFORTS[effort].0.to_owned(),
                is_default: EFFORTS[effort].1 == Effort::USUAL,
                ..Point::default()
            }
        };
        Series::dotted(group.name(), (0..EFFORTS.len()).map(point))
    };
    Plot {
        title: "Effort of the search for the largest albedo".to_owned(),
        subtitle: format!("{} random subjects, one thread; median and quartiles", rows.len()),
        x: Axis::log("time of the whole search, ms"),
        y: Axis::log("share darker than needed"),
        series: Series::label_first(SubjectKind::ALL.map(series)),
    }
}
