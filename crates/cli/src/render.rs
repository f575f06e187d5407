//! `brood render`: renders one picture of a material.

use std::fmt::Display;
use std::path::PathBuf;
use std::time::Instant;

use anyhow::{Context, Result, bail};
use brood_bench::material_file::{self, MaterialFile};
use brood_bench::{logging, output};
use brood_brdf::{Brdf, Swapped};
use brood_eval::{encode_exr, encode_png, express};
use brood_inspect::Shot;
use brood_protocol::{Backend, PictureFormat};
use brood_scene::{PictureSize, PixelArea, Sampling};
use brood_worker::Renderer;
use clap::Args;
use serde_json::json;

use crate::frame::FrameArgs;

/// Options of `brood render`.
#[derive(Debug, Args)]
pub struct RenderArgs {
    /// Material: a `.brood` or JSON file of a genome or a model, a MERL `.binary`, an RGL `.bsdf`,
    /// samples as `.csv`, a goniometer's `.brdf`, or an image slice as `.exr`; - is stdin
    pub genome: PathBuf,
    #[command(flatten)]
    pub frame: FrameArgs,
    /// Render only this part of the picture, in pixels from the upper left corner
    #[arg(long, value_name = "X,Y,WIDTH,HEIGHT", allow_hyphen_values = true)]
    pub area: Option<PixelArea>,
    /// Exchange the directions to light and eye of a measured material, as path tracers from the
    /// eye do; shows its deviation from reciprocity
    #[arg(long)]
    pub swap: bool,
    /// Keep negative values of RGL tables (colours outside the display's gamut), as other renderers
    /// do; by default they become 0
    #[arg(long)]
    pub keep_negative: bool,
    /// Picture to write: .png is developed, .exr is linear
    #[arg(short, long, value_name = "FILE")]
    pub output: PathBuf,
}

/// Runs the command.
pub fn run(args: &RenderArgs, json: bool) -> Result<()> {
    logging::start_offline();
    let extension = args.output.extension().map(|ext| ext.to_ascii_lowercase());
    let format = match extension.as_ref().and_then(|ext| ext.to_str()) {
        Some("png") => PictureFormat::Png,
        Some("exr") => PictureFormat::Exr,
        _ => bail!("--output must end in .png or .exr"),
    };
    let program = match material_file::read_with(&args.genome, args.keep_negative)? {
        MaterialFile::Bred(_) if args.swap => {
            bail!("--swap needs a measured material; genomes are reciprocal")
        }
        MaterialFile::Bred(genome) => express(&genome),
        MaterialFile::Measured(brdf, kind) if args.swap => {
            return run_brdf(args, &Swapped(&*brdf), kind, (format, json));
        }
        MaterialFile::Measured(brdf, kind) => return run_brdf(args, &*brdf, kind, (format, json)),
    };
    let renderer = Renderer::new(args.frame.backend);
    let (frame, mesh) = args.frame.load(&renderer, format)?;
    if let Some(area) = args.area.filter(|area| !area.is_within(args.frame.size)) {
        let PictureSize { width, height } = args.frame.size;
        bail!("--area {area} must lie within the picture of {width} x {height} pixels");
    }
    let frame = frame.with_area(args.area);
    let spinner = output::spinner("rendering");
    let start = Instant::now();
    let pictures = renderer.render(&frame, &mesh, &[&program])?;
    let elapsed = start.elapsed();
    spinner.finish_and_clear();
    let picture = pictures.first().context("the renderer returned no picture")?;
    output::write_file(&args.output, &picture.bytes)?;
    let report = renderer.report();
    if json {
        return output::print_json(&json!({
            "file": args.output,
            "key": picture.key.to_string(),
            "size_px": args.frame.size,
            "exposure_ev": picture.exposure_ev,
            "samples_per_pixel": args.frame.samples,
            "samples": picture.samples,
            "operations": picture.operations,
            "milliseconds": elapsed.as_secs_f64() * 1e3,
            "backend": report,
        }));
    }
    output::print(&format!(
        "{}: {}, {} operations, exposure {:.3} EV, {:.1} ms on the {}\n",
        args.output.display(),
        samples_text(args.frame.samples, picture.samples),
        picture.operations,
        picture.exposure_ev,
        elapsed.as_secs_f64() * 1e3,
        report.name,
    ))
}

/// Returns the number of samples and that per pixel, which `--samples` is rounded up to.
fn samples_text(sampling: Sampling, samples: impl Display) -> String {
    match sampling {
        Sampling::Adaptive => format!("{samples} samples (adaptive)"),
        Sampling::Fixed(per_pixel) => format!("{samples} samples ({per_pixel} per pixel)"),
    }
}

/// Renders a measured material, on the CPU in f64.
fn run_brdf(
    args: &RenderArgs,
    brdf: &dyn Brdf,
    kind: &str,
    (format, json): (PictureFormat, bool),
) -> Result<()> {
    let frame = &args.frame;
    if args.area.is_some() || frame.backend == Backend::Gpu {
        bail!(
            "measured materials are rendered whole and on the CPU: leave out --area and --backend gpu"
        );
    }
    let renderer = Renderer::new(Backend::Cpu);
    let (requested, mesh) = frame.load_alone(&renderer, format)?;
    let scene = requested.scene()?;
    let start = Instant::now();
    let shot = Shot {
        mesh: mesh.mesh(),
        scene: &scene,
        assets: &renderer.light_assets(),
        size_px: frame.size,
        sampling: frame.samples,
    };
    let picture = shot.take(brdf);
    let developed = &picture.developed;
    let bytes = match format == PictureFormat::Exr {
        true => encode_exr(&picture.radiance)?,
        false => encode_png(developed.width, developed.height, &developed.rgba),
    };
    output::write_file(&args.output, &bytes)?;
    let milliseconds = start.elapsed().as_secs_f64() * 1e3;
    if json {
        return output::print_json(&json!({
            "file": args.output,
            "measured": kind,
            "size_px": frame.size,
            "exposure_ev": developed.exposure_ev,
            "samples_per_pixel": frame.samples,
            "samples": picture.samples,
            "milliseconds": milliseconds,
        }));
    }
    output::print(&format!(
        "{}: {kind}, {}, exposure {:.3} EV, {milliseconds:.1} ms\n",
        args.output.display(),
        samples_text(frame.samples, picture.samples),
        developed.exposure_ev,
    ))
}
