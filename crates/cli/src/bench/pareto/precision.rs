//! f32 against f64: how far developed pictures are apart, genome by genome, and what the precision costs.

use anyhow::Result;
use brood_eval::{CanonicalEvaluator, Evaluator, Level, ReferenceEvaluator, develop, shade};
use brood_program::Program;
use brood_scene::{BuiltinMesh, Exposure, Mesh, SampleSet, Scene};

use crate::bench::measure::{
    Difference, difference, fastest_ms, median, one_thread, programs, quantile,
};
use crate::bench::picture::{self, Mode};
use crate::bench::record::Finding;
use crate::chart::{Axis, Plot, Point, Scale, Series, Table};
use crate::output;

/// What an 8-bit display can show at best.
const VISIBLE: f64 = 1.0 / 255.0;
/// Differences that are left out of the chart: far below the rounding of f32, they would only stretch its axis.
const NEGLIGIBLE: f64 = 1e-9;

struct Shot {
    apart: Difference,
    /// Whether any developed byte is off by more than 1.
    off: bool,
    level_ms: Vec<f64>,
    reference_ms: f64,
}

/// One finding.
pub fn measure(short: bool, seed: u64) -> Result<Finding> {
    let (genomes, size_px, repeats) = if short { (10, 32, 1) } else { (400, 128, 3) };
    let set = Mode::default().set(&Mesh::builtin(BuiltinMesh::Sphere), &Scene::default(), size_px);
    let pool = one_thread()?;
    let bar = output::bar(genomes.into(), "f32 against f64");
    let mut shots = Vec::new();
    for program in programs(seed, genomes) {
        shots.push(pool.install(|| shot(&set, &program, repeats))?);
        bar.inc(1);
    }
    bar.finish_and_clear();
    let off = shots.iter().filter(|shot| shot.off).count();
    Ok(Finding {
        name: "precision",
        note: format!(
            "{genomes} random genomes on the sphere at {size_px} x {size_px}, one thread; the same samples and exposure; \
             {off} have a developed byte off by more than 1; the reference is exact by definition and its output is \
             rounded to f32 once"
        ),
        table: table(&shots),
        raw: Some(raw(&shots)),
        chart: chart(&shots, size_px).svg(),
    })
}

fn shot(set: &SampleSet, program: &Program, repeats: u32) -> Result<Shot> {
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
    let off = developed.rgba.iter().zip(&expected.rgba).any(|(a, b)| a.abs_diff(*b) > 1);
    let apart = difference(
        &picture::exposed(image.premultiplied(), ev),
        &picture::exposed(reference.premultiplied(), ev),
        1.0,
    );
    Ok(Shot { apart, off, level_ms, reference_ms })
}

fn table(shots: &[Shot]) -> Table {
    let mut table = Table::new(&[
        "knob",
        "value",
        "time_ms",
        "error",
        "error_metric",
        "error_p90",
        "error_worst",
        "share_off_by_over_1_255",
        "default",
    ]);
    let error = |share| quantile(shots.iter().map(|shot| shot.apart.rmse), share);
    let off = shots.iter().filter(|shot| shot.off).count() as f64 / shots.len() as f64;
    let metric = "median RMSE after exposure";
    for (index, level) in Level::available().into_iter().enumerate() {
        table.push([
            "precision".into(),
            format!("f32 {}", level.name()).into(),
            median(shots.iter().map(|shot| shot.level_ms[index])).into(),
            error(0.5).into(),
            metric.into(),
            error(0.9).into(),
            error(1.0).into(),
            off.into(),
            if level == Level::best() { "yes" } else { "" }.into(),
        ]);
    }
    table.push([
        "precision".into(),
        "f64 reference".into(),
        median(shots.iter().map(|shot| shot.reference_ms)).into(),
        0.0.into(),
        metric.into(),
        0.0.into(),
        0.0.into(),
        0.0.into(),
        "".into(),
    ]);
    table
}

fn raw(shots: &[Shot]) -> Table {
    let mut table = Table::new(&[
        "genome",
        "rmse",
        "p999",
        "max",
        "off_by_over_1_255",
        "best_ms",
        "reference_ms",
    ]);
    for (genome, shot) in shots.iter().enumerate() {
        table.push([
            genome.into(),
            shot.apart.rmse.into(),
            shot.apart.p999.into(),
            shot.apart.max.into(),
            if shot.off { "yes" } else { "no" }.into(),
            shot.level_ms.last().copied().unwrap_or(f64::NAN).into(),
            shot.reference_ms.into(),
        ]);
    }
    table
}

/// The errors in ascending order: how many genomes stay below each.
fn chart(shots: &[Shot], size_px: u32) -> Plot {
    let curve = |name: &str, value: &dyn Fn(&Shot) -> f64| {
        let mut values: Vec<f64> = shots.iter().map(value).collect();
        values.sort_by(f64::total_cmp);
        let share = |rank: usize| 100.0 * (rank + 1) as f64 / shots.len() as f64;
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
            shots.len()
        ),
        x: Axis { title: "share of genomes with at most this error, %", scale: Scale::Linear },
        y: Axis { title: "difference of linear light, 0..1", scale: Scale::Log },
        series: vec![
            curve("RMSE", &|shot| shot.apart.rmse),
            curve("largest difference of a channel", &|shot| shot.apart.max),
            Series {
                name: "1 / 255".to_owned(),
                points: vec![limit(0.0), limit(100.0)],
                dots: false,
            },
        ],
    }
}
