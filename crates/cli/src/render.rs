//! `brood render`: one material, one picture.

use std::path::PathBuf;
use std::time::Instant;

use anyhow::{Context, Result, bail};
use brood_brdf::{Brdf, Swapped};
use brood_eval::{encode_exr, encode_png, express};
use brood_inspect::Shot;
use brood_protocol::{Backend, PictureFormat};
use brood_scene::PixelArea;
use brood_worker::Renderer;
use clap::Args;
use serde_json::json;

use crate::frame::FrameArgs;
use crate::material_file::{self, Material};
use crate::{logging, output};

/// Options of `brood render`.
#[derive(Debug, Args)]
pub struct RenderArgs {
    /// A `.brood` or JSON file of a genome or a model, a MERL `.binary`, an RGL `.bsdf`, samples as `.csv`, a goniometer's
    /// `.brdf`, or an image slice as `.exr`; - is stdin
    pub genome: PathBuf,
    #[command(flatten)]
    pub frame: FrameArgs,
    /// Only this part of the picture, in its pixels from the upper left
    #[arg(long, value_name = "X,Y,WIDTH,HEIGHT", allow_hyphen_values = true)]
    pub area: Option<PixelArea>,
    /// Exchange the directions to the light and to the eye, as renderers do that follow light from the eye; it shows how far a
    /// measured material is from reciprocal
    #[arg(long)]
    pub swap: bool,
    /// Keep the values below 0 of RGL's tables, which are 0 otherwise: colours beyond the display's have them, and other
    /// renderers keep them
    #[arg(long)]
    pub keep_negative: bool,
    /// The picture: .png is developed, .exr is linear
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
        _ => bail!("the output's name must end in .png or .exr"),
    };
    let program = match material_file::read_with(&args.genome, args.keep_negative)? {
        Material::Bred(_) if args.swap => bail!("--swap is for what was measured"),
        Material::Bred(genome) => express(&genome),
        Material::Measured(brdf, kind) if args.swap => {
            return run_brdf(args, &Swapped(&*brdf), kind, (format, json));
        }
        Material::Measured(brdf, kind) => return run_brdf(args, &*brdf, kind, (format, json)),
    };
    let renderer = Renderer::new(args.frame.backend);
    let (frame, mesh) = args.frame.load(&renderer, format)?;
    if let Some(area) = args.area.filter(|area| !area.is_within(args.frame.size)) {
        bail!("the area {area} is not within a picture of {} pixels", args.frame.size);
    }
    let frame = frame.with_area(args.area);
    let spinner = output::spinner("rendering");
    let start = Instant::now();
    let pictures = renderer.render(&frame, &mesh, &[&program])?;
    let elapsed = start.elapsed();
    spinner.finish_and_clear();
    let picture = pictures.first().context("one program gives one picture")?;
    output::write_file(&args.output, &picture.bytes)?;
    let report = renderer.report();
    if json {
        return output::print_json(&json!({
            "file": args.output,
            "key": picture.key.to_string(),
            "size_px": args.frame.size,
            "exposure_ev": picture.exposure_ev,
            "samples": picture.samples,
            "operations": picture.operations,
            "milliseconds": elapsed.as_secs_f64() * 1e3,
            "backend": report,
        }));
    }
    output::print(&format!(
        "{}: {} samples, {} operations, exposure {:.3} EV, {:.1} ms on the {}\n",
        args.output.display(),
        picture.samples,
        picture.operations,
        picture.exposure_ev,
        elapsed.as_secs_f64() * 1e3,
        report.name,
    ))
}

/// The same of what was measured, which the CPU computes in f64.
fn run_brdf(
    args: &RenderArgs,
    brdf: &dyn Brdf,
    kind: &str,
    (format, json): (PictureFormat, bool),
) -> Result<()> {
    let frame = &args.frame;
    if args.area.is_some() || frame.backend == Backend::Gpu {
        bail!(
            "measured materials are rendered whole and on the CPU: leave --area and --backend gpu out"
        );
    }
    let renderer = Renderer::new(Backend::Cpu);
    let (asked, mesh) = frame.load(&renderer, format)?;
    let scene = asked.scene()?;
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
    let bytes = match format {
        PictureFormat::Exr => encode_exr(&picture.radiance)?,
        PictureFormat::Png => encode_png(developed.width, developed.height, &developed.rgba),
    };
    output::write_file(&args.output, &bytes)?;
    let milliseconds = start.elapsed().as_secs_f64() * 1e3;
    if json {
        return output::print_json(&json!({
            "file": args.output,
            "measured": kind,
            "size_px": frame.size,
            "exposure_ev": developed.exposure_ev,
            "samples": picture.samples,
            "milliseconds": milliseconds,
        }));
    }
    output::print(&format!(
        "{}: {}, {} samples, exposure {:.3} EV, {milliseconds:.1} ms\n",
        args.output.display(),
        kind,
        picture.samples,
        developed.exposure_ev,
    ))
}
