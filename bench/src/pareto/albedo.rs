//! Sweep of the quadrature order of the directional albedo, which the energy limit uses.
//!
//! For each genome, the search of the energy limit finds the incident direction with the largest
//! albedo. There the integral is computed at growing orders and compared with a high order in f64.

use anyhow::Result;
use brood_eval::{
    Effort, Incidence, LimitSearch, Quadrature, ReferenceEvaluator, direction_pair,
    directional_albedo,
};
use brood_program::Program;
use brood_scene::SampleSet;

use crate::chart::{Axis, Cell, Plot, Point, ResultTable, Series, cells};
use crate::measure::{fastest_ms, median, one_thread, programs, quantile};
use crate::output;
use crate::record::Finding;

/// Relative error allowed for rounding in canonical f32, on top of the bound of the quadrature.
const ROUNDING: f64 = 1e-6;

/// Amount of work of the sweep.
struct Workload {
    genomes: u32,
    orders: &'static [usize],
    reference_order: usize,
    repeats: u32,
}

/// Results of one order for all genomes.
struct OrderResult {
    order: usize,
    ms: Vec<f64>,
    errors: Vec<f64>,
}

/// Results of the whole search for all genomes.
struct Limits {
    ms: Vec<f64>,
    /// Relative error at the found place.
    errors: Vec<f64>,
    /// Error bound that the limit reports.
    bounds: Vec<f64>,
}

/// Measures the finding.
pub fn measure(short: bool, seed: u64) -> Result<Finding> {
    let workload = if short {
        Workload { genomes: 2, orders: &[4, 16, 64], reference_order: 128, repeats: 1 }
    } else {
        Workload {
            genomes: 20,
            orders: &[4, 8, 16, 32, 64, 128, 256],
            reference_order: 1024,
            repeats: 3,
        }
    };
    let search = LimitSearch::new(Effort::USUAL);
    let pool = one_thread()?;
    let result = |order: &usize| OrderResult { order: *order, ms: Vec::new(), errors: Vec::new() };
    let mut orders: Vec<OrderResult> = workload.orders.iter().map(result).collect();
    let mut limits = Limits { ms: Vec::new(), errors: Vec::new(), bounds: Vec::new() };
    let mut reference_error = Vec::new();
    let bar = output::bar(workload.genomes.into(), "albedo");
    for program in programs(seed, workload.genomes) {
        let (ms, (limit, place)) =
            pool.install(|| fastest_ms(workload.repeats, || Ok(search.run(&program))))?;
        let exact = reference(&program, &place, workload.reference_order);
        let coarser = reference(&program, &place, workload.reference_order / 2);
        bar.inc(1);
        if exact <= 0.0 {
            // Black: every order is exact.
            continue;
        }
        reference_error.push((coarser / exact - 1.0).abs());
        limits.ms.push(ms);
        limits.errors.push((limit.albedo / exact - 1.0).abs());
        limits.bounds.push(limit.error_bound);
        for result in &mut orders {
            let run = || Ok(directional_albedo(&program, &place, result.order));
            let (ms, albedo) = pool.install(|| fastest_ms(workload.repeats, run))?;
            result.ms.push(ms);
            result.errors.push((albedo / exact - 1.0).abs());
        }
    }
    bar.finish_and_clear();
    Ok(Finding {
        name: "albedo",
        note: format!(
            "{} random genomes, without black ones, each at the incident direction where the search of the energy limit \
             found the largest albedo; order n is n rings times 2n azimuths; relative to order {} in f64, which differs from \
             half that order by reference_error (median); one thread, including inputs. The search of \
             `beyond_bound` genomes has an error above its own bound plus {ROUNDING:e} for rounding",
            workload.genomes, workload.reference_order,
        ),
        table: table(&orders, &limits, median(&reference_error)),
        raw: Some(raw(&orders, &limits)),
        chart: chart(&orders, &workload).into(),
    })
}

/// Largest albedo over the channels at a place, in f64 except for the inputs.
fn reference(program: &Program, place: &Incidence, order: usize) -> f64 {
    let wi = place.direction();
    let rule = Quadrature::new(order);
    let pairs: Vec<_> = rule.directions().iter().map(|wo| direction_pair(wi, *wo)).collect();
    let set = SampleSet::from_pairs(&pairs, &vec![place.uv; pairs.len()]);
    let f = ReferenceEvaluator::reflectance(program, &set);
    (0..3).map(|channel| rule.integrate(f.iter().map(|f| f[channel]))).fold(0.0, f64::max)
}

fn is_default(order: usize) -> bool {
    order == brood_eval::ALBEDO_ORDER
}

/// Rows of the orders and of the whole search.
fn table(orders: &[OrderResult], limits: &Limits, reference_error: f64) -> ResultTable {
    let mut table = ResultTable::default();
    let mut push = |value: &str, ms: f64, errors: [f64; 3], beyond: Cell, is_default: bool| {
        table.push(cells! {
            knob: "albedo quadrature order",
            value: value,
            time_ms: ms,
            error: errors[0],
            error_metric: "median relative error",
            error_p90: errors[1],
            error_worst: errors[2],
            beyond_bound: beyond,
            reference_error: reference_error,
            default: Cell::yes_if(is_default),
        });
    };
    let errors = |errors: &[f64]| [0.5, 0.9, 1.0].map(|share| quantile(errors, share));
    for result in orders {
        let name = result.order.to_string();
        let is_default = is_default(result.order);
        push(&name, median(&result.ms), errors(&result.errors), Cell::Missing, is_default);
    }
    let both = limits.errors.iter().zip(&limits.bounds);
    let beyond = both.filter(|(error, bound)| **error > **bound + ROUNDING).count();
    push("whole search", median(&limits.ms), errors(&limits.errors), beyond.into(), false);
    table
}

fn raw(orders: &[OrderResult], limits: &Limits) -> ResultTable {
    let mut table = ResultTable::default();
    for result in orders {
        for (genome, (ms, error)) in result.ms.iter().zip(&result.errors).enumerate() {
            let bound = f64::NAN;
            table.push(cells! {
                genome: genome,
                order: result.order.to_string(),
                ms: *ms,
                relative_error: *error,
                reported_bound: bound,
            });
        }
    }
    for (genome, (ms, error)) in limits.ms.iter().zip(&limits.errors).enumerate() {
        let bound = limits.bounds[genome];
        table.push(cells! {
            genome: genome,
            order: "search",
            ms: *ms,
            relative_error: *error,
            reported_bound: bound,
        });
    }
    table
}

fn chart(orders: &[OrderResult], workload: &Workload) -> Plot {
    let series = |name: &str, share: f64| {
        let point = |result: &OrderResult| Point {
            x: median(&result.ms),
            y: quantile(&result.errors, share),
            label: result.order.to_string(),
            is_default: is_default(result.order),
            ..Point::default()
        };
        Series::dotted(name, orders.iter().map(point))
    };
    Plot {
        title: "Order of the albedo quadrature".to_owned(),
        subtitle: format!(
            "{} random genomes at the incident direction of the largest albedo, one thread; against order {} in f64",
            workload.genomes, workload.reference_order
        ),
        x: Axis::log("time of one integral, ms"),
        y: Axis::log("relative error of the albedo"),
        series: Series::label_first(
            [("median genome", 0.5), ("90th percentile", 0.9), ("worst genome", 1.0)]
                .map(|(name, share)| series(name, share)),
        ),
    }
}
