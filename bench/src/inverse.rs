//! `brood bench inverse`: recovers known kinds of material from one picture of a sphere, from
//! random starts, and reports the success rate, the error and the time per start.

use std::time::Instant;

use anyhow::{Context, Result, ensure};
use brood_eval::{LinearPicture, RadianceImage, shade_brdf};
use brood_genome::{Model, ModelKind};
use brood_light::LightAssets;
use brood_mesh::{BuiltinMesh, Mesh};
use brood_scene::{ClipFrom, PixelArea, Raster, Refine, SampleSet, Sampling, Scene};
use brood_search::analytic::{Form, Recovery};
use brood_target::{ImageView, Samples, View};
use clap::Args;
use serde::Serialize;
use serde_json::json;

use super::measure::{median, one_thread, quantile};
use super::record::CommonArgs;
use crate::output;

/// Sphere and light of the benchmarks compared with.
const SCENE: &str = r#"{
    "camera": {"orthographic": 1.05},
    "lights": [{"kind": "directional", "direction": [-1, -1, -1.4142135623730951], "irradiance_w_m2": [3.141592653589793, 3.141592653589793, 3.141592653589793]}]
}"#;

/// Options of `brood bench inverse`.
#[derive(Debug, Args)]
pub struct BenchInverseArgs {
    /// Number of random starts of each material
    #[arg(long, value_name = "N", default_value_t = 50, value_parser = clap::value_parser!(u32).range(1..=100_000))]
    starts: u32,
    /// Side of the picture in pixels
    #[arg(long, value_name = "N", default_value_t = 128, value_parser = clap::value_parser!(u32).range(16..=2048))]
    size: u32,
    /// Rays per pixel: 1, or `adaptive`, which integrates edges and highlights and samples other
    /// pixels at their centres
    #[arg(long, value_name = "N", default_value = "1")]
    samples: Sampling,
    /// Largest root mean square error of the picture that counts as success
    #[arg(long, value_name = "E", default_value_t = 1e-4)]
    rmse: f64,
    /// E_log over the used pixels at which a start ends
    #[arg(long, value_name = "E", default_value_t = 3e-6)]
    enough: f64,
    #[command(flatten)]
    common: CommonArgs,
}

/// Results of one material.
#[derive(Debug, Serialize)]
struct Row {
    material: &'static str,
    /// Number of parameters that are solved for.
    unknowns: usize,
    /// Number of pixels used.
    pixels: u64,
    starts: u32,
    successes: usize,
    /// Time of a start, including the picture that it is judged by.
    ms: Figures,
    /// Root mean square error of the picture of the result.
    rmse: Figures,
    /// Mean number of models evaluated per start.
    evaluations: f64,
    /// Mean number of starting points used per start.
    restarts: f64,
    /// Setup once for all starts: rays of the picture, and its pixels as samples.
    prepare_ms: f64,
}

#[derive(Debug, Serialize)]
struct Figures {
    min: f64,
    median: f64,
    mean: f64,
    p95: f64,
    max: f64,
}

/// Materials to recover.
fn truths() -> Result<[(&'static str, Model); 3]> {
    let conductor = Model::new(ModelKind::Conductor)
        .with("eta", &[0.143, 0.375, 1.442])?
        .with("k", &[3.983, 2.386, 1.603])?
        .with("roughness", &[0.2])?;
    let plastic = Model::new(ModelKind::RoughPlastic)
        .with("albedo", &[0.6, 0.25, 0.1])?
        .with("ior", &[1.5])?
        .with("roughness", &[0.15])?;
    let principled = Model::new(ModelKind::Principled)
        .with("base_color", &[0.7, 0.3, 0.15])?
        .with("roughness", &[0.35])?
        .with("metallic", &[0.3])?
        .with("clearcoat", &[0.6])?
        .with("clearcoat_gloss", &[0.7])?
        .choose("coat_form", "mitsuba")?;
    Ok([("rough conductor", conductor), ("rough plastic", plastic), ("principled", principled)])
}

/// Runs the command.
pub fn run(args: &BenchInverseArgs, json: bool) -> Result<()> {
    let folder = args.common.start()?;
    let scene: Scene = serde_json::from_str(SCENE).context("read the scene")?;
    let mesh = Mesh::builtin(BuiltinMesh::Sphere);
    let pool = one_thread()?;
    let mut rows = Vec::new();
    for (name, truth) in truths()? {
        let row = pool.install(|| material(args, (&mesh, &scene), (name, &truth)))?;
        eprintln!("{}", line(&row));
        rows.push(row);
    }
    let report = json!({ "size_px": args.size, "rmse": args.rmse, "threads": 1, "rows": rows });
    folder.add_json("inverse", &report)?;
    if json {
        return output::print_json(&report);
    }
    output::print(&rows.iter().map(|row| line(row) + "\n").collect::<String>())
}

/// Recovers one material from all starts.
fn material(
    args: &BenchInverseArgs,
    (mesh, scene): (&Mesh, &Scene),
    (name, truth): (&'static str, &Model),
) -> Result<Row> {
    let (size_px, assets) = (args.size, LightAssets::default());
    let raster =
        Raster { size_px: size_px.into(), sampling: args.samples, area: PixelArea::whole(size_px) };
    let rendered = picture(truth, &SampleSet::render_with_assets(mesh, scene, &assets, raster));
    let picture_of = LinearPicture::from(&rendered);
    let begun = Instant::now();
    let view = View {
        mesh,
        scene,
        assets: &assets,
        sampling: args.samples,
        picture: &picture_of,
        mask: None,
        is_gain_unknown: false,
        clip_from: ClipFrom::Auto,
        refine: Refine::default(),
    };
    let (view, samples): (ImageView, Samples) = ImageView::new(&view)?;
    let form = Form::of(truth);
    let recovery = Recovery::new(&samples, form, args.enough);
    let prepare_ms = begun.elapsed().as_secs_f64() * 1e3;
    let (mut ms, mut errors) = (Vec::new(), Vec::new());
    let (mut evaluations, mut restarts) = (0.0, 0.0);
    for number in 0..args.starts {
        let begun = Instant::now();
        let found = recovery.run(args.common.seed, number);
        let error = view.compare(&picture(&found.model, view.set())).rmse;
        ms.push(begun.elapsed().as_secs_f64() * 1e3);
        ensure!(error.is_finite(), "the picture has a non-finite error");
        errors.push(error);
        evaluations += found.evaluations as f64;
        restarts += f64::from(found.starts);
    }
    let starts = f64::from(args.starts);
    Ok(Row {
        material: name,
        unknowns: recovery.unknowns(),
        pixels: view.counts().used,
        starts: args.starts,
        successes: errors.iter().filter(|error| **error <= args.rmse).count(),
        ms: figures(&ms),
        rmse: figures(&errors),
        evaluations: evaluations / starts,
        restarts: restarts / starts,
        prepare_ms,
    })
}

fn picture(model: &Model, set: &SampleSet) -> RadianceImage {
    shade_brdf(set, &*model.brdf())
}

fn figures(values: &[f64]) -> Figures {
    Figures {
        min: quantile(values, 0.0),
        median: median(values),
        mean: values.iter().sum::<f64>() / values.len().max(1) as f64,
        p95: quantile(values, 0.95),
        max: quantile(values, 1.0),
    }
}

fn line(row: &Row) -> String {
    format!(
        "{}: {} unknowns from {} pixels; {} of {} starts succeeded; {:.2} ms per start in the median, {:.2} in the mean, {:.2} at most; picture \
         RMSE {:.1e} in the median, {:.1e} at most; {:.0} models evaluated, {:.2} starting points; {:.1} ms of setup",
        row.material,
        row.unknowns,
        row.pixels,
        row.successes,
        row.starts,
        row.ms.median,
        row.ms.mean,
        row.ms.max,
        row.rmse.median,
        row.rmse.max,
        row.evaluations,
        row.restarts,
        row.prepare_ms,
    )
}
