//! Sweep of the evaluators on one brood: every instruction set, the f64 reference and, on request,
//! the GPU.

use anyhow::{Result, ensure};
use brood_eval::{CanonicalEvaluator, Evaluator, Level, ReferenceEvaluator, develop, shade};
use brood_mesh::{BuiltinMesh, Mesh};
use brood_program::Program;
use brood_protocol::Backend;
use brood_scene::{Exposure, SampleSet, Scene};
use brood_worker::Renderer;

use crate::chart::{Axis, Bar, BarChart, Cell, Group, ResultTable, cells};
use crate::measure::{difference, fastest_ms, median, programs};
use crate::picture::{self, Mode};
use crate::record::Finding;

/// Number of programs: a brood and its centre.
const PROGRAMS: u32 = 21;

/// Result of one evaluator.
struct Row {
    name: String,
    ms: f64,
    rmse: f64,
    differing: u64,
    is_default: bool,
}

/// Measures the finding.
pub fn measure(short: bool, seed: u64, gpu: bool) -> Result<Finding> {
    let (size_px, repeats) = if short { (32, 2) } else { (256, 3) };
    let set = Mode::default().set(&Mesh::builtin(BuiltinMesh::Sphere), &Scene::default(), size_px);
    let programs = programs(seed, PROGRAMS);
    let batch: Vec<&Program> = programs.iter().collect();
    let mut exact = Vec::new();
    let run = || Ok(ReferenceEvaluator.eval(&batch, &set, &mut exact)?);
    let (reference_ms, ()) = fastest_ms(repeats.min(3), run)?;
    let mut canonical = Vec::new();
    CanonicalEvaluator::default().eval(&batch, &set, &mut canonical)?;
    let mut rows = Vec::new();
    for level in Level::available() {
        let evaluator = CanonicalEvaluator::with_level(level);
        let mut f = Vec::new();
        let (ms, ()) = fastest_ms(repeats, || Ok(evaluator.eval(&batch, &set, &mut f)?))?;
        let is_default = level == Level::best();
        let name = format!("cpu {}", level.name());
        rows.push(row(name, ms, &set, [&f, &exact, &canonical], is_default));
    }
    rows.push(row(
        "reference f64".to_owned(),
        reference_ms,
        &set,
        [&exact, &exact, &canonical],
        false,
    ));
    let mut note = "GPU not measured (--gpu)".to_owned();
    if gpu {
        let renderer = Renderer::new(Backend::Gpu);
        let report = renderer.report();
        note = format!("GPU: {} ({})", report.adapter, report.reason);
        if renderer.worker_report().gpu {
            let run = || Ok(renderer.reflectance(Backend::Gpu, &batch, &set)?);
            run()?;
            let (ms, f) = fastest_ms(repeats, run)?;
            rows.push(row(report.adapter, ms, &set, [&f, &exact, &canonical], false));
        }
    }
    let differing: u64 =
        rows.iter().filter(|row| row.name != "reference f64").map(|row| row.differing).sum();
    ensure!(
        differing == 0,
        "{differing} values of exact evaluators differ from the canonical ones; expected 0"
    );
    Ok(Finding {
        name: "backend",
        note: format!(
            "{PROGRAMS} random programs on the sphere at {size_px} x {size_px} ({} samples), all threads, evaluation \
             and translation into memory; {note}",
            set.len()
        ),
        table: table(&rows),
        raw: None,
        chart: chart(&rows, size_px).into(),
    })
}

/// Compares values with both references: `f` holds the values, those of the f64 reference and the
/// canonical ones.
fn row(name: String, ms: f64, set: &SampleSet, f: [&[f32]; 3], is_default: bool) -> Row {
    let [own, exact, canonical] = f;
    let pictures = own.chunks(3 * set.len()).zip(exact.chunks(3 * set.len()));
    let rmse = pictures.map(|(own, exact)| {
        let (own, exact) = (shade(set, own), shade(set, exact));
        let ev = develop(&exact, Exposure::Auto).exposure_ev;
        difference(
            &picture::exposed(own.premultiplied(), ev),
            &picture::exposed(exact.premultiplied(), ev),
            1.0,
        )
        .rmse
    });
    let differing = own.iter().zip(canonical).filter(|(a, b)| a.to_bits() != b.to_bits());
    Row { name, ms, rmse: median(rmse), differing: differing.count() as u64, is_default }
}

fn table(rows: &[Row]) -> ResultTable {
    rows.iter()
        .map(|row| {
            cells! {
                knob: "backend",
                value: row.name.as_str(),
                time_ms: row.ms,
                error: row.rmse,
                error_metric: "median RMSE after exposure",
                differing_from_canonical: row.differing,
                default: Cell::yes_if(row.is_default),
            }
        })
        .collect()
}

fn chart(rows: &[Row], size_px: u32) -> BarChart {
    let group = |row: &Row| {
        let suffix = if row.is_default { " ms, default" } else { " ms" }.to_owned();
        let series = usize::from(!row.is_default);
        let bar = Bar { series, value: row.ms, suffix, ..Bar::default() };
        Group { name: row.name.clone(), bars: vec![bar] }
    };
    BarChart::new(
        "Time of a brood by evaluator",
        format!(
            "{PROGRAMS} random programs on the sphere, {size_px} x {size_px} pixels, all threads; shorter is better"
        ),
        Axis::log("time of a brood, ms"),
        rows.iter().map(group),
    )
}
