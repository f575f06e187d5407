//! `brood bench style`: times pictures of painted materials, in memory, on new and on known scenes,
//! and measures their errors in codes of a display.
//!
//! Two errors are separate: rounding, canonical f32 against f64 on the same points; and sampling,
//! the default sampling against many points per pixel in f64.

use std::time::Instant;

use anyhow::{Context, Result};
use brood_eval::{CanonicalEvaluator, Developed, Evaluator, ReferenceEvaluator, develop_colors};
use brood_genome::{BirthKey, Genome, Start, Variation};
use brood_light::LightAssets;
use brood_mesh::{BuiltinMesh, Mesh};
use brood_program::Program;
use brood_protocol::{Backend, Frame, MeshSource, PictureFormat};
use brood_scene::{MeshRef, PixelArea, Raster, SampleSet, Sampling, Scene};
use brood_worker::Renderer;
use clap::Args;
use serde::Serialize;
use serde_json::{Value, json};

use super::measure::{median, quantile};
use super::record::CommonArgs;

/// Side of the large picture in pixels.
const LARGE_PX: u32 = 256;
/// Side of the pictures of a brood in pixels.
const BROOD_PX: u32 = 128;
/// Number of frames of a brood, the centre included.
const BROOD: u32 = 21;

/// Options of `brood bench style`.
#[derive(Debug, Args)]
pub struct BenchStyleArgs {
    /// Number of runs, each with other materials and a renderer without caches
    #[arg(long, value_name = "N", default_value_t = 20, value_parser = clap::value_parser!(u32).range(1..=10_000))]
    repeats: u32,
    /// Number of materials whose errors are measured
    #[arg(long, value_name = "N", default_value_t = 21, value_parser = clap::value_parser!(u32).range(1..=1000))]
    programs: u32,
    /// Number of points per pixel of the reference
    #[arg(long, value_name = "N", default_value_t = 64, value_parser = clap::value_parser!(u16).range(4..=1024))]
    samples: u16,
    #[command(flatten)]
    common: CommonArgs,
}

/// Times and errors in one scene.
#[derive(Debug, Serialize)]
struct Row {
    scene: &'static str,
    threads: usize,
    /// First material at 256 px, with the points of a new scene; mesh and tracer are known.
    new_scene_256_ms: Figures,
    /// Another material at 256 px, without PNG.
    further_256_ms: Figures,
    /// Another material at 256 px, with PNG.
    further_256_png_ms: Figures,
    /// 21 other materials at 128 px on known points, with PNG.
    brood_128_ms: Figures,
    /// f32 against f64 on the same points, at 256 px.
    rounding: Errors,
    /// Default sampling against the reference, at 128 px.
    sampling: Errors,
}

#[derive(Debug, Serialize)]
struct Figures {
    min: f64,
    median: f64,
    p99: f64,
}

/// Differences of pictures in codes of a display, over wholly covered pixels.
#[derive(Debug, Default, Serialize)]
struct Errors {
    rms: f64,
    largest: u8,
    /// Percentage of pixels with a channel more than 1 code apart.
    over_1_percent: f64,
    /// Percentage of pixels with a channel more than 8 codes apart.
    over_8_percent: f64,
}

/// Runs the command.
pub fn run(args: &BenchStyleArgs, json: bool) -> Result<()> {
    let folder = args.common.start()?;
    let rows = scenes()?
        .into_iter()
        .map(|(name, scene)| measure(args, name, &scene))
        .collect::<Result<Vec<Row>>>()?;
    let head = format!(
        "{:<10} {:>22} {:>18} {:>18} {:>18}   rounding and sampling: rms, largest, % over 8 codes\n",
        "scene", "new at 256 px, ms", "further, ms", "with PNG, ms", "21 at 128 px, ms"
    );
    let line = |row: &Row| {
        let ms = |figures: &Figures| format!("{:.1} ({:.1})", figures.median, figures.min);
        let errors = |of: &Errors| format!("{:.3} {} {:.2}", of.rms, of.largest, of.over_8_percent);
        format!(
            "{:<10} {:>22} {:>18} {:>18} {:>18}   {}; {}\n",
            row.scene,
            ms(&row.new_scene_256_ms),
            ms(&row.further_256_ms),
            ms(&row.further_256_png_ms),
            ms(&row.brood_128_ms),
            errors(&row.rounding),
            errors(&row.sampling)
        )
    };
    folder.finish_rows("style", &rows, (&head, line), json)
}

/// Scenes of the knob: a lamp, three coloured lights with shadows, a lamp in the studio.
fn scenes() -> Result<Vec<(&'static str, Scene)>> {
    let lamps = json!([
        {},
        {"position": [-3, 1, 2], "intensity": [6, 3, 1]},
        {"kind": "directional", "direction": [0, 1, -0.3], "irradiance_w_m2": [0.2, 0.4, 1]},
    ]);
    let studio = json!([{}, {"kind": "environment", "image": "studio"}]);
    let scene = |lights: Value, shadows: bool| -> Result<Scene> {
        let mesh = BuiltinMesh::Knob.name();
        Ok(serde_json::from_value(json!({"mesh": mesh, "lights": lights, "shadows": shadows}))?)
    };
    Ok(vec![
        ("lamp", scene(json!([{}]), false)?),
        ("shadows", scene(lamps, true)?),
        ("studio", scene(studio, false)?),
    ])
}

fn genomes(seed: u64, count: u32) -> Vec<Genome> {
    let random = Variation::random(Start::Painted.dialect()).with_start(Start::Painted);
    (0..count).map(|slot| random.birth(BirthKey { seed, slot, attempt: 0 })).collect()
}

fn measure(args: &BenchStyleArgs, name: &'static str, scene: &Scene) -> Result<Row> {
    let frame = |size_px: u32| {
        let how = (PictureFormat::Png, Backend::Cpu);
        Frame::new(scene, MeshSource::Builtin, size_px, Sampling::default(), how)
    };
    let (large, small) = (frame(LARGE_PX), frame(BROOD_PX));
    let [mut new, mut further, mut png, mut brood] = [(); 4].map(|()| Vec::new());
    for round in 0..args.repeats {
        let renderer = Renderer::new(Backend::Cpu);
        let mesh = renderer.builtin(BuiltinMesh::Knob);
        let _ = mesh.mesh().tracer();
        let genomes = genomes(args.common.seed.wrapping_add(round.into()), BROOD + 2);
        let timed = |genomes: &[Genome], frame: &Frame, encodes: bool| -> Result<f64> {
            let start = Instant::now();
            let programs: Vec<Program> = genomes.iter().map(Program::lower).collect();
            let all: Vec<&Program> = programs.iter().collect();
            if encodes {
                renderer.render(frame, &mesh, &all).context("render")?;
            } else {
                renderer.develop(frame, &mesh, &all).context("render")?;
            }
            Ok(start.elapsed().as_secs_f64() * 1e3)
        };
        new.push(timed(&genomes[..1], &large, true)?);
        further.push(timed(&genomes[1..2], &large, false)?);
        png.push(timed(&genomes[2..3], &large, true)?);
        timed(&genomes[..1], &small, true)?;
        brood.push(timed(&genomes[2..], &small, true)?);
    }
    let styles: Vec<Program> =
        genomes(args.common.seed, args.programs).iter().map(Program::lower).collect();
    Ok(Row {
        scene: name,
        threads: rayon::current_num_threads(),
        new_scene_256_ms: figures(&new),
        further_256_ms: figures(&further),
        further_256_png_ms: figures(&png),
        brood_128_ms: figures(&brood),
        rounding: rounding(scene, &styles)?,
        sampling: sampling(scene, &styles, args.samples)?,
    })
}

fn figures(ms: &[f64]) -> Figures {
    Figures { min: quantile(ms, 0.0), median: median(ms), p99: quantile(ms, 0.99) }
}

fn points(scene: &Scene, size_px: u32, sampling: Sampling) -> SampleSet {
    let MeshRef::Builtin(mesh) = scene.mesh else {
        unreachable!("the scenes have a built-in mesh")
    };
    let area = PixelArea::whole(size_px);
    let raster = Raster { size_px: size_px.into(), sampling, area };
    SampleSet::render_points(&Mesh::builtin(mesh), scene, &LightAssets::default(), raster)
}

fn picture(evaluator: &dyn Evaluator, style: &Program, set: &SampleSet) -> Result<Developed> {
    let mut colors = Vec::new();
    evaluator.eval(&[style], set, &mut colors)?;
    Ok(develop_colors(set, &colors))
}

/// Canonical f32 against f64 on the points of the default sampling.
fn rounding(scene: &Scene, styles: &[Program]) -> Result<Errors> {
    let set = points(scene, LARGE_PX, Sampling::default());
    errors(styles, |style| {
        Ok([
            picture(&CanonicalEvaluator::default(), style, &set)?,
            picture(&ReferenceEvaluator, style, &set)?,
        ])
    })
}

/// Default sampling against `samples` points per pixel in f64.
fn sampling(scene: &Scene, styles: &[Program], samples: u16) -> Result<Errors> {
    let set = points(scene, BROOD_PX, Sampling::default());
    let fine = points(scene, BROOD_PX, Sampling::Fixed(samples));
    errors(styles, |style| {
        Ok([
            picture(&CanonicalEvaluator::default(), style, &set)?,
            picture(&ReferenceEvaluator, style, &fine)?,
        ])
    })
}

/// Differences of two pictures of each style, where both are wholly covered.
fn errors(
    styles: &[Program],
    pictures: impl Fn(&Program) -> Result<[Developed; 2]>,
) -> Result<Errors> {
    let (mut squares, mut pixels) = (0.0, 0u64);
    let (mut largest, mut over_1, mut over_8) = (0, 0u64, 0u64);
    for style in styles {
        let [one, other] = pictures(style)?;
        for (a, b) in one.rgba.chunks_exact(4).zip(other.rgba.chunks_exact(4)) {
            if a[3].min(b[3]) < u8::MAX {
                continue;
            }
            let apart = [0, 1, 2].map(|channel| a[channel].abs_diff(b[channel]));
            let most = apart.into_iter().max().unwrap_or(0);
            squares += apart.iter().map(|codes| f64::from(*codes).powi(2)).sum::<f64>();
            pixels += 1;
            largest = largest.max(most);
            over_1 += u64::from(most > 1);
            over_8 += u64::from(most > 8);
        }
    }
    let count = pixels.max(1) as f64;
    Ok(Errors {
        rms: (squares / (3.0 * count)).sqrt(),
        largest,
        over_1_percent: 100.0 * over_1 as f64 / count,
        over_8_percent: 100.0 * over_8 as f64 / count,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rounding_is_not_visible() {
        let scene = Scene { mesh: MeshRef::Builtin(BuiltinMesh::Sphere), ..Scene::default() };
        let styles: Vec<Program> = genomes(5, 3).iter().map(Program::lower).collect();
        let found = rounding(&scene, &styles).unwrap();
        assert!(found.rms < 0.2 && found.over_8_percent < 0.01, "{found:?}");
    }

    #[test]
    fn scenes_have_up_to_three_lights() {
        let scenes = scenes().unwrap();
        assert_eq!(scenes.iter().map(|(_, scene)| scene.lights.len()).max(), Some(3));
    }
}
