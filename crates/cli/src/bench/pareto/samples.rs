//! Samples a pixel: random materials on two meshes, each mode against the f64 reference at many samples.

use anyhow::Result;
use brood_program::Program;
use brood_scene::{BuiltinMesh, Mesh, Scene};

use crate::bench::measure::{
    Difference, difference, fastest_ms, median, one_thread, programs, quantile,
};
use crate::bench::picture::{self, Mode, Studio, Yardstick};
use crate::bench::record::Finding;
use crate::chart::{Axis, Cell, Plot, Point, Scale, Series, Table};
use crate::output;

/// How much is measured.
struct Extent {
    genomes: u32,
    size_px: u32,
    reference_samples: u16,
    repeats: u32,
}

/// One genome in one mode.
struct Shot {
    picture_ms: f64,
    shown: Difference,
    unclipped_rmse: f64,
}

/// What one mode came to on one mesh.
struct ModeResult {
    mode: Mode,
    set_ms: f64,
    samples: usize,
    shots: Vec<Shot>,
}

/// Everything about one mesh.
struct MeshResult {
    name: &'static str,
    modes: Vec<ModeResult>,
    /// For each genome the distance of the reference from one of half as many samples.
    reference_rmse: Vec<f64>,
}

/// One finding for each mesh.
pub fn measure(short: bool, seed: u64) -> Result<Vec<Finding>> {
    let extent = if short {
        Extent { genomes: 3, size_px: 32, reference_samples: 128, repeats: 1 }
    } else {
        Extent { genomes: 20, size_px: 128, reference_samples: 1024, repeats: 5 }
    };
    let programs = programs(seed, extent.genomes);
    let bar = output::spinner("samples a pixel");
    let mut findings = Vec::new();
    for mesh in [BuiltinMesh::Sphere, BuiltinMesh::Knob] {
        let result = on_mesh(mesh, &programs, &extent, || bar.tick())?;
        findings.push(finding(&result, &extent));
    }
    bar.finish_and_clear();
    Ok(findings)
}

fn on_mesh(
    name: BuiltinMesh,
    programs: &[Program],
    extent: &Extent,
    step: impl Fn(),
) -> Result<MeshResult> {
    let mesh = Mesh::builtin(name);
    let scene = Scene::default();
    let pool = one_thread()?;
    let mut studios = Vec::new();
    let mut result =
        MeshResult { name: name.name(), modes: Vec::new(), reference_rmse: Vec::new() };
    for mode in Mode::all() {
        let (set_ms, set) = pool.install(|| {
            fastest_ms(extent.repeats.min(3), || Ok(mode.set(&mesh, &scene, extent.size_px)))
        })?;
        let studio = Studio::new(&mesh, &scene, extent.size_px, (mode, set));
        let samples = studio.samples();
        result.modes.push(ModeResult { mode: studio.mode(), set_ms, samples, shots: Vec::new() });
        studios.push(studio);
    }
    let yardstick = Yardstick {
        mesh: &mesh,
        scene: &scene,
        size_px: extent.size_px,
        samples: extent.reference_samples,
    };
    let all: Vec<&Program> = programs.iter().collect();
    let references = yardstick.pictures(&all, &step);
    let halves = yardstick.halved().pictures(&all, &step);
    let shown = result.modes.iter().position(|mode| mode.mode.is_default());
    let shown = shown.expect("the default is among the modes");
    for ((program, reference), half) in programs.iter().zip(references).zip(halves) {
        // One exposure for all modes, as the product's own picture measures it.
        let (_, ev) = studios[shown].picture(program)?;
        let reference = picture::expose(&reference, ev);
        result.reference_rmse.push(difference(&picture::expose(&half, ev), &reference, 1.0).rmse);
        for (mode, studio) in result.modes.iter_mut().zip(&mut studios) {
            // Makes the fine samples that the material needs and the set does not have yet.
            studio.picture(program)?;
            let (picture_ms, (pixels, _)) =
                pool.install(|| fastest_ms(extent.repeats, || studio.picture(program)))?;
            let pixels = picture::exposed(&pixels, ev);
            mode.shots.push(Shot {
                picture_ms,
                shown: difference(&pixels, &reference, 1.0),
                unclipped_rmse: difference(&pixels, &reference, f64::INFINITY).rmse,
            });
        }
    }
    Ok(result)
}

fn finding(result: &MeshResult, extent: &Extent) -> Finding {
    let floor = median(result.reference_rmse.iter().copied());
    let Extent { genomes, size_px, reference_samples, .. } = extent;
    Finding {
        name: if result.name == "sphere" { "samples-sphere" } else { "samples-knob" },
        note: format!(
            "{genomes} random genomes on the {} at {size_px} x {size_px}, one thread; RMSE of linear light after \
             exposure, held in 0..1, against {reference_samples} samples in f64, which differ from half as many by \
             {floor:.1e} (median RMSE); a picture is evaluated, shaded and developed over samples that are there",
            result.name
        ),
        table: table(result),
        raw: Some(raw(result)),
        chart: chart(result, extent).svg(),
    }
}

fn table(result: &MeshResult) -> Table {
    let mut table = Table::new(&[
        "knob",
        "value",
        "time_ms",
        "error",
        "error_metric",
        "error_worst",
        "p999",
        "set_ms",
        "samples",
        "default",
    ]);
    for mode in &result.modes {
        let rmse = || mode.shots.iter().map(|shot| shot.shown.rmse);
        table.push([
            "samples a pixel".into(),
            mode.mode.name().into(),
            median(mode.shots.iter().map(|shot| shot.picture_ms)).into(),
            median(rmse()).into(),
            "median RMSE".into(),
            quantile(rmse(), 1.0).into(),
            median(mode.shots.iter().map(|shot| shot.shown.p999)).into(),
            mode.set_ms.into(),
            mode.samples.into(),
            Cell::from(if mode.mode.is_default() { "yes" } else { "" }),
        ]);
    }
    table
}

fn raw(result: &MeshResult) -> Table {
    let mut table = Table::new(&[
        "mesh",
        "genome",
        "mode",
        "picture_ms",
        "rmse",
        "rmse_unclipped",
        "p999",
        "max",
        "reference_rmse",
    ]);
    for mode in &result.modes {
        for (genome, shot) in mode.shots.iter().enumerate() {
            table.push([
                result.name.into(),
                genome.into(),
                mode.mode.name().into(),
                shot.picture_ms.into(),
                shot.shown.rmse.into(),
                shot.unclipped_rmse.into(),
                shot.shown.p999.into(),
                shot.shown.max.into(),
                result.reference_rmse[genome].into(),
            ]);
        }
    }
    table
}

fn chart(result: &MeshResult, extent: &Extent) -> Plot {
    let series = |name: &str, error: &dyn Fn(&ModeResult) -> f64, labelled: bool| Series {
        name: name.to_owned(),
        dots: true,
        points: result
            .modes
            .iter()
            .map(|mode| Point {
                x: median(mode.shots.iter().map(|shot| shot.picture_ms)),
                y: error(mode),
                label: if labelled { mode.mode.name() } else { String::new() },
                chosen: labelled && mode.mode.is_default(),
                apart: mode.mode.is_adaptive(),
            })
            .collect(),
    };
    let rmse = |mode: &ModeResult, share| quantile(mode.shots.iter().map(|s| s.shown.rmse), share);
    Plot {
        title: format!("Samples a pixel on the {}", result.name),
        subtitle: format!(
            "{} random materials, {size} x {size} pixels, one thread, sample set at hand; against {} samples in f64",
            extent.genomes,
            extent.reference_samples,
            size = extent.size_px
        ),
        x: Axis { title: "time of a picture, ms", scale: Scale::Log },
        y: Axis { title: "RMSE of linear light after exposure", scale: Scale::Log },
        series: vec![
            series("median material", &|mode| rmse(mode, 0.5), true),
            series("worst material", &|mode| rmse(mode, 1.0), false),
            series(
                "99.9th percentile of pixels, median material",
                &|mode| median(mode.shots.iter().map(|s| s.shown.p999)),
                false,
            ),
        ],
    }
}
