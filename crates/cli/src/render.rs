//! `brood render`: one genome, one picture.

use std::path::PathBuf;
use std::time::Instant;

use anyhow::{Context, Result, bail};
use brood_eval::express;
use brood_protocol::PictureFormat;
use brood_scene::PixelArea;
use brood_worker::Renderer;
use clap::Args;
use serde_json::json;

use crate::frame::FrameArgs;
use crate::{genome_file, logging, output};

/// Options of `brood render`.
#[derive(Debug, Args)]
pub struct RenderArgs {
    /// A `.brood` or JSON file; - is stdin
    pub genome: PathBuf,
    #[command(flatten)]
    pub frame: FrameArgs,
    /// Only this part of the picture, in its pixels from the upper left
    #[arg(long, value_name = "X,Y,WIDTH,HEIGHT", allow_hyphen_values = true)]
    pub area: Option<PixelArea>,
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
    let program = express(&genome_file::read(&args.genome)?);
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
