//! Order of the quadrature of the directional albedo, on which the energy limit rests.
//!
//! For each genome the search of the energy limit names the incident direction where the albedo is largest; there the
//! integral is taken at growing orders and held against f64 at a high one.

use anyhow::Result;
use brood_eval::{
    Effort, LimitSearch, Place, Quadrature, ReferenceEvaluator, directional_albedo, pair,
};
use brood_program::Program;
use brood_scene::SampleSet;

use crate::bench::measure::{fastest_ms, median, one_thread, programs, quantile};
use crate::bench::record::Finding;
use crate::chart::{Axis, Plot, Point, Scale, Series, Table};
use crate::output;

/// The relative error that canonical f32 itself may add: the bound speaks of the quadrature.
const ROUNDING: f64 = 1e-6;

struct Extent {
    genomes: u32,
    orders: &'static [usize],
    reference_order: usize,
    repeats: u32,
}

/// One order for all genomes.
struct OrderResult {
    order: usize,
    ms: Vec<f64>,
    errors: Vec<f64>,
}

struct Limits {
    ms: Vec<f64>,
    /// True relative error at the place found, and the bound that the limit reports.
    errors: Vec<f64>,
    bounds: Vec<f64>,
}

/// One finding.
pub fn measure(short: bool, seed: u64) -> Result<Finding> {
    let extent = if short {
        Extent { genomes: 2, orders: &[4, 16, 64], reference_order: 128, repeats: 1 }
    } else {
        Extent {
            genomes: 50,
            orders: &[4, 8, 16, 32, 64, 128, 256],
            reference_order: 1024,
            repeats: 3,
        }
    };
    let usual = LimitSearch::new(Effort::USUAL);
    let pool = one_thread()?;
    let result = |order: &usize| OrderResult { order: *order, ms: Vec::new(), errors: Vec::new() };
    let mut orders: Vec<OrderResult> = extent.orders.iter().map(result).collect();
    let mut limits = Limits { ms: Vec::new(), errors: Vec::new(), bounds: Vec::new() };
    let mut reference_error = Vec::new();
    let bar = output::bar(extent.genomes.into(), "albedo");
    for program in programs(seed, extent.genomes) {
        let (ms, (limit, place)) =
            pool.install(|| fastest_ms(extent.repeats, || Ok(usual.run(&program))))?;
        let exact = reference(&program, &place, extent.reference_order);
        let coarser = reference(&program, &place, extent.reference_order / 2);
        bar.inc(1);
        if exact <= 0.0 {
            // Black: every order is right.
            continue;
        }
        reference_error.push((coarser / exact - 1.0).abs());
        limits.ms.push(ms);
        limits.errors.push((limit.albedo / exact - 1.0).abs());
        limits.bounds.push(limit.error_bound);
        for result in &mut orders {
            let run = || Ok(directional_albedo(&program, &place, result.order));
            let (ms, albedo) = pool.install(|| fastest_ms(extent.repeats, run))?;
            result.ms.push(ms);
            result.errors.push((albedo / exact - 1.0).abs());
        }
    }
    bar.finish_and_clear();
    let both = limits.errors.iter().zip(&limits.bounds);
    let held = both.filter(|(error, bound)| **error <= **bound + ROUNDING).count();
    let floor = median(reference_error.iter().copied());
    Ok(Finding {
        name: "albedo",
        note: format!(
            "{} random genomes, each at the incident direction where the search of the energy limit found its albedo \
             largest; order n is n rings times 2n azimuths; relative to order {} in f64, which differs from half of it by \
             {floor:.1e} (median); one thread, inputs included. The whole search takes {:.0} ms (median), and its bound, \
             with {ROUNDING:e} allowed for rounding, holds for {held} of {}",
            limits.ms.len(),
            extent.reference_order,
            median(limits.ms.iter().copied()),
            limits.ms.len(),
        ),
        table: table(&orders),
        raw: Some(raw(&orders, &limits)),
        chart: chart(&orders, &extent).svg(),
    })
}

/// The largest albedo of the channels at a place, in f64 but for the inputs.
fn reference(program: &Program, place: &Place, order: usize) -> f64 {
    let wi = place.direction();
    let rule = Quadrature::new(order);
    let pairs: Vec<_> = rule.directions().iter().map(|wo| pair(wi, *wo)).collect();
    let set = SampleSet::from_pairs(&pairs, &vec![place.uv; pairs.len()]);
    let f = ReferenceEvaluator::reflectance(program, &set);
    (0..3).map(|channel| rule.integrate(f.iter().map(|f| f[channel]))).fold(0.0, f64::max)
}

fn is_default(order: usize) -> bool {
    order == brood_eval::ALBEDO_ORDER
}

fn table(orders: &[OrderResult]) -> Table {
    let mut table = Table::new(&[
        "knob",
        "value",
        "time_ms",
        "error",
        "error_metric",
        "error_p90",
        "error_worst",
        "default",
    ]);
    for result in orders {
        let error = |share| quantile(result.errors.iter().copied(), share);
        table.push([
            "albedo quadrature order".into(),
            result.order.into(),
            median(result.ms.iter().copied()).into(),
            error(0.5).into(),
            "median relative error".into(),
            error(0.9).into(),
            error(1.0).into(),
            if is_default(result.order) { "yes" } else { "" }.into(),
        ]);
    }
    table
}

fn raw(orders: &[OrderResult], limits: &Limits) -> Table {
    let mut table = Table::new(&["genome", "order", "ms", "relative_error", "reported_bound"]);
    for result in orders {
        for (genome, (ms, error)) in result.ms.iter().zip(&result.errors).enumerate() {
            let bound = f64::NAN.into();
            table.push([
                genome.into(),
                result.order.to_string().into(),
                (*ms).into(),
                (*error).into(),
                bound,
            ]);
        }
    }
    for (genome, (ms, error)) in limits.ms.iter().zip(&limits.errors).enumerate() {
        let bound = limits.bounds[genome].into();
        table.push([genome.into(), "search".into(), (*ms).into(), (*error).into(), bound]);
    }
    table
}

fn chart(orders: &[OrderResult], extent: &Extent) -> Plot {
    let series = |name: &str, share: f64, labelled: bool| Series {
        name: name.to_owned(),
        dots: true,
        points: orders
            .iter()
            .map(|result| Point {
                x: median(result.ms.iter().copied()),
                y: quantile(result.errors.iter().copied(), share),
                label: if labelled { result.order.to_string() } else { String::new() },
                chosen: labelled && is_default(result.order),
                apart: false,
            })
            .collect(),
    };
    Plot {
        title: "Order of the albedo quadrature".to_owned(),
        subtitle: format!(
            "{} random genomes at their brightest incident direction, one thread; against order {} in f64",
            extent.genomes, extent.reference_order
        ),
        x: Axis { title: "time of one integral, ms", scale: Scale::Log },
        y: Axis { title: "relative error of the albedo", scale: Scale::Log },
        series: vec![
            series("median genome", 0.5, true),
            series("90th percentile", 0.9, false),
            series("worst genome", 1.0, false),
        ],
    }
}
