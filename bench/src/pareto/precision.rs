//! Sweep of f32 against f64: differences between developed pictures, genome by genome, and the cost
//! of the precision.

use anyhow::Result;
use brood_eval::{CanonicalEvaluator, Evaluator, Level, ReferenceEvaluator, develop, shade};
use brood_mesh::{BuiltinMesh, Mesh};
use brood_program::Program;
use brood_scene::{Exposure, SampleSet, Scene};

use crate::chart::{Axis, Cell, Plot, Point, ResultTable, Series, cells};
use crate::measure::{
    PixelDifference, difference, fastest_ms, median, one_thread, programs, quantile,
};
use crate::output;
use crate::picture::{self, Mode};
use crate::record::Finding;

/// Smallest step of an 8-bit display.
const VISIBLE: f64 = 1.0 / 255.0;
/// Differences below this are drawn as 0: far below the rounding of f32, they would only stretch
/// the axis.
const NEGLIGIBLE: f64 = 1e-9;

/// Result for one genome.
struct GenomeResult {
    difference: PixelDifference,
    /// True if any developed byte differs by more than 1.
    is_visible: bool,
    level_ms: Vec<f64>,
    reference_ms: f64,
}

/// Measures the finding.
pub fn measure(short: bool, seed: u64) -> Result<Finding> {
    let (genomes, size_px, repeats) = if short { (10, 32, 1) } else { (40, 128, 3) };
    let set = Mode::default().set(&Mesh::builtin(BuiltinMesh::Sphere), &Scene::default(), size_px);
    let pool = one_thread()?;
    let bar = output::bar(genomes.into(), "f32 against f64");
    let mut results = Vec::new();
    for program in programs(seed, genomes) {
        results.push(pool.install(|| measure_genome(&set, &program, repeats))?);
        bar.inc(1);
    }
    bar.finish_and_clear();
    Ok(Finding {
        name: "precision",
        note: format!(
            "{genomes} random genomes on the sphere at {size_px} x {size_px}, one thread, same samples and exposure; \
             share_off_by_over_1_255 have a developed byte that differs by more than 1; the reference is exact by definition and its output is \
             rounded to f32 once"
        ),
        table: table(&results),
        raw: Some(raw(&results)),
        chart: chart(&results, size_px).into(),
    })
}

fn measure_genome(set: &SampleSet, program: &Program, repeats: u32) -> Result<GenomeResult> {
    let (mut f, mut exact) = (Vec::new(), Vec::new());
    // Fills the inputs, which all levels share.
    CanonicalEvaluator::default().eval(&[program], set, &mut f)?;
    let mut level_ms = Vec::new();
    for level in Level::available() {
        let evaluator = CanonicalEvaluator::with_level(level);
        let run = || Ok(evaluator.eval(&[program], set, &mut f)?);
        level_ms.push(fastest_ms(repeats, run)?.0);
    }
    let run = || Ok(ReferenceEvaluator.eval(&[program], set, &mut exact)?);
    let (reference_ms, ()) = fastest_ms(repeats.min(2), run)?;
    let (image, reference) = (shade(set, &f), shade(set, &exact));
    let developed = develop(&image, Exposure::Auto);
    let ev = developed.exposure_ev;
    let expected = develop(&reference, Exposure::Ev(ev));
    let is_visible = developed.rgba.iter().zip(&expected.rgba).any(|(a, b)| a.abs_diff(*b) > 1);
    let difference = difference(
        &picture::exposed(image.premultiplied(), ev),
        &picture::exposed(reference.premultiplied(), ev),
        1.0,
    );
    Ok(GenomeResult { difference, is_visible, level_ms, reference_ms })
}

fn table(results: &[GenomeResult]) -> ResultTable {
    let mut table = ResultTable::default();
    let error = |share| quantile(results.iter().map(|result| result.difference.rmse), share);
    let visible = results.iter().filter(|result| result.is_visible).count() as f64;
    let visible = visible / results.len() as f64;
    let metric = "median RMSE after exposure";
    for (index, level) in Level::available().into_iter().enumerate() {
        table.push(cells! {
            knob: "precision",
            value: format!("f32 {}", level.name()),
            time_ms: median(results.iter().map(|result| result.level_ms[index])),
            error: error(0.5),
            error_metric: metric,
            error_p90: error(0.9),
            error_worst: error(1.0),
            share_off_by_over_1_255: visible,
            default: Cell::yes_if(level == Level::best()),
        });
    }
    table.push(cells! {
        knob: "precision",
        value: "f64 reference",
        time_ms: median(results.iter().map(|result| result.reference_ms)),
        error: 0.0,
        error_metric: metric,
        error_p90: 0.0,
        error_worst: 0.0,
        share_off_by_over_1_255: 0.0,
        default: "",
    });
    table
}

fn raw(results: &[GenomeResult]) -> ResultTable {
    let mut table = ResultTable::default();
    for (genome, result) in results.iter().enumerate() {
        table.push(cells! {
            genome: genome,
            rmse: result.difference.rmse,
            p999: result.difference.p999,
            max: result.difference.max,
            off_by_over_1_255: if result.is_visible { "yes" } else { "no" },
            best_ms: result.level_ms.last().copied().unwrap_or(f64::NAN),
            reference_ms: result.reference_ms,
        });
    }
    table
}

/// Errors in ascending order, against the share of genomes with at most that error.
fn chart(results: &[GenomeResult], size_px: u32) -> Plot {
    let curve = |name: &str, value: &dyn Fn(&GenomeResult) -> f64| {
        let mut values: Vec<f64> = results.iter().map(value).collect();
        values.sort_by(f64::total_cmp);
        let share = |rank: usize| 100.0 * (rank + 1) as f64 / results.len() as f64;
        let point = |(rank, y): (usize, &f64)| {
            let y = if *y < NEGLIGIBLE { 0.0 } else { *y };
            Point { x: share(rank), y, ..Point::default() }
        };
        let points = values.iter().enumerate().map(point).collect();
        Series { name: name.to_owned(), points, dots: false }
    };
    let limit = |x: f64| Point { x, y: VISIBLE, ..Point::default() };
    Plot {
        title: "f32 against f64".to_owned(),
        subtitle: format!(
            "{} random genomes on the sphere, {size_px} x {size_px} pixels, same samples and exposure; sorted by error",
            results.len()
        ),
        x: Axis::linear("share of genomes with at most this error, %"),
        y: Axis::log("difference of linear light, 0..1"),
        series: vec![
            curve("RMSE", &|result| result.difference.rmse),
            curve("largest difference of a channel", &|result| result.difference.max),
            Series {
                name: "1 / 255".to_owned(),
                points: vec![limit(0.0), limit(100.0)],
                dots: false,
            },
        ],
    }
}
