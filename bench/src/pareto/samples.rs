//! Sweep of the samples per pixel: random materials on two meshes, each mode against the f64
//! reference at many samples.

use anyhow::Result;
use brood_mesh::{BuiltinMesh, Mesh};
use brood_program::Program;
use brood_scene::Scene;

use crate::chart::{Axis, Cell, Plot, Point, ResultTable, Series, cells};
use crate::measure::{
    PixelDifference, difference, fastest_ms, median, one_thread, programs, quantile,
};
use crate::output;
use crate::picture::{self, Mode, ModeRenderer, ReferenceRender};
use crate::record::Finding;

/// Amount of work of the sweep.
struct Workload {
    genomes: u32,
    size_px: u32,
    reference_samples: u16,
    repeats: u32,
}

/// Result for one genome in one mode.
struct GenomeResult {
    picture_ms: f64,
    /// Difference after clamping to the range of a display.
    shown: PixelDifference,
    unclipped_rmse: f64,
}

/// Results of one mode on one mesh.
struct ModeResult {
    mode: Mode,
    set_ms: f64,
    samples: usize,
    genomes: Vec<GenomeResult>,
}

/// Results of one mesh.
struct MeshResult {
    name: &'static str,
    modes: Vec<ModeResult>,
    /// For each genome the difference between the reference and one with half as many samples.
    reference_rmse: Vec<f64>,
}

/// Measures one finding for each mesh.
pub fn measure(short: bool, seed: u64) -> Result<Vec<Finding>> {
    let workload = if short {
        Workload { genomes: 3, size_px: 32, reference_samples: 128, repeats: 1 }
    } else {
        Workload { genomes: 6, size_px: 128, reference_samples: 1024, repeats: 5 }
    };
    let programs = programs(seed, workload.genomes);
    let bar = output::spinner("samples per pixel");
    let mut findings = Vec::new();
    for mesh in [BuiltinMesh::Sphere, BuiltinMesh::Knob] {
        let result = on_mesh(mesh, &programs, &workload, || bar.tick())?;
        findings.push(finding(&result, &workload));
    }
    bar.finish_and_clear();
    Ok(findings)
}

/// Measures every mode and genome on one mesh.
fn on_mesh(
    name: BuiltinMesh,
    programs: &[Program],
    workload: &Workload,
    step: impl Fn(),
) -> Result<MeshResult> {
    let mesh = Mesh::builtin(name);
    let scene = Scene::default();
    let pool = one_thread()?;
    let mut renderers = Vec::new();
    let mut result =
        MeshResult { name: name.name(), modes: Vec::new(), reference_rmse: Vec::new() };
    for mode in Mode::all() {
        let (set_ms, set) = pool.install(|| {
            fastest_ms(workload.repeats.min(3), || Ok(mode.set(&mesh, &scene, workload.size_px)))
        })?;
        let renderer = ModeRenderer::new(&mesh, &scene, workload.size_px, (mode, set));
        let samples = renderer.samples();
        result.modes.push(ModeResult {
            mode: renderer.mode(),
            set_ms,
            samples,
            genomes: Vec::new(),
        });
        renderers.push(renderer);
    }
    let reference_render = ReferenceRender {
        mesh: &mesh,
        scene: &scene,
        size_px: workload.size_px,
        samples: workload.reference_samples,
    };
    let all: Vec<&Program> = programs.iter().collect();
    let references = reference_render.pictures(&all, &step);
    let halves = reference_render.halved().pictures(&all, &step);
    let default = result.modes.iter().position(|mode| mode.mode.is_default());
    let default = default.expect("the default is among the modes");
    for ((program, reference), half) in programs.iter().zip(references).zip(halves) {
        // One exposure for all modes: the automatic one of the default mode.
        let (_, ev) = renderers[default].picture(program)?;
        let reference = picture::expose(&reference, ev);
        result.reference_rmse.push(difference(&picture::expose(&half, ev), &reference, 1.0).rmse);
        for (mode, renderer) in result.modes.iter_mut().zip(&mut renderers) {
            // Builds the fine samples that this material needs, so that they are not timed.
            renderer.picture(program)?;
            let (picture_ms, (pixels, _)) =
                pool.install(|| fastest_ms(workload.repeats, || renderer.picture(program)))?;
            let pixels = picture::exposed(&pixels, ev);
            mode.genomes.push(GenomeResult {
                picture_ms,
                shown: difference(&pixels, &reference, 1.0),
                unclipped_rmse: difference(&pixels, &reference, f64::INFINITY).rmse,
            });
        }
    }
    Ok(result)
}

fn finding(result: &MeshResult, workload: &Workload) -> Finding {
    let Workload { genomes, size_px, reference_samples, .. } = workload;
    Finding {
        name: if result.name == "sphere" { "samples-sphere" } else { "samples-knob" },
        note: format!(
            "{genomes} random genomes on the {} at {size_px} x {size_px}, one thread; RMSE of linear light after \
             exposure, clamped to 0..1, against {reference_samples} samples in f64, which differ from half as many by \
             reference_rmse; times cover evaluation, shading and development over existing samples",
            result.name
        ),
        table: table(result),
        raw: Some(raw(result)),
        chart: chart(result, workload).into(),
    }
}

fn table(result: &MeshResult) -> ResultTable {
    let mut table = ResultTable::default();
    for mode in &result.modes {
        let rmse = || mode.genomes.iter().map(|result| result.shown.rmse);
        table.push(cells! {
            knob: "samples a pixel",
            value: mode.mode.name(),
            time_ms: median(mode.genomes.iter().map(|result| result.picture_ms)),
            error: median(rmse()),
            error_metric: "median RMSE",
            error_worst: quantile(rmse(), 1.0),
            p999: median(mode.genomes.iter().map(|result| result.shown.p999)),
            set_ms: mode.set_ms,
            samples: mode.samples,
            reference_rmse: median(&result.reference_rmse),
            default: Cell::yes_if(mode.mode.is_default()),
        });
    }
    table
}

fn raw(result: &MeshResult) -> ResultTable {
    let mut table = ResultTable::default();
    for mode in &result.modes {
        for (genome, genome_result) in mode.genomes.iter().enumerate() {
            table.push(cells! {
                mesh: result.name,
                genome: genome,
                mode: mode.mode.name(),
                picture_ms: genome_result.picture_ms,
                rmse: genome_result.shown.rmse,
                rmse_unclipped: genome_result.unclipped_rmse,
                p999: genome_result.shown.p999,
                max: genome_result.shown.max,
                reference_rmse: result.reference_rmse[genome],
            });
        }
    }
    table
}

fn chart(result: &MeshResult, workload: &Workload) -> Plot {
    let series = |name: &str, error: &dyn Fn(&ModeResult) -> f64| {
        let point = |mode: &ModeResult| Point {
            x: median(mode.genomes.iter().map(|result| result.picture_ms)),
            y: error(mode),
            label: mode.mode.name(),
            is_default: mode.mode.is_default(),
            is_detached: mode.mode.is_adaptive(),
            ..Point::default()
        };
        Series::dotted(name, result.modes.iter().map(point))
    };
    let rmse =
        |mode: &ModeResult, share| quantile(mode.genomes.iter().map(|s| s.shown.rmse), share);
    Plot {
        title: format!("Samples per pixel on the {}", result.name),
        subtitle: format!(
            "{} random materials, {size} x {size} pixels, one thread, samples precomputed; against {} in f64",
            workload.genomes,
            workload.reference_samples,
            size = workload.size_px
        ),
        x: Axis::log("time of a picture, ms"),
        y: Axis::log("RMSE of linear light after exposure"),
        series: Series::label_first([
            series("median material", &|mode| rmse(mode, 0.5)),
            series("worst material", &|mode| rmse(mode, 1.0)),
            series("99.9th percentile of pixels, median material", &|mode| {
                median(mode.genomes.iter().map(|s| s.shown.p999))
            }),
        ]),
    }
}
