//! `brood compare`: materials side by side in one scene, how far they are apart, and what their reflection has of physics.
//!
//! Owns the options and the files: pictures, differences, curves as CSV and SVG, a report, and a page that shows them all.

mod curve;
mod page;
mod phenomena;
mod subject;

use std::path::PathBuf;

use anyhow::{Context, Result};
use brood_eval::{Developed, encode_png};
use brood_protocol::PictureFormat;
use brood_scene::{Exposure, Scene};
use brood_worker::Renderer;
use clap::Args;
use serde_json::{Value, json};

use crate::diff::{self, Picture as Pixels};
use crate::frame::FrameArgs;
use crate::model_picture::{Picture, Shot};
use crate::{logging, output};
use curve::Curves;
use phenomena::Phenomena;
pub use subject::Subject;

/// More would neither fit beside each other nor be told apart in a chart.
const MOST: usize = 6;
/// The other light: this much further along the light circle, in degrees.
const OTHER_LIGHT_DEG: f64 = 60.0;

/// Pictures that only their exposure is wanted of.
const SMALL_PX: u32 = 64;

/// Options of `brood compare`.
#[derive(Debug, Args)]
pub struct CompareArgs {
    /// Two to six materials: `.brood` or JSON files of genomes and models, or measured tables; the others are held against the first
    #[arg(required = true, num_args = 2..=MOST)]
    pub materials: Vec<PathBuf>,
    #[command(flatten)]
    pub frame: FrameArgs,
    /// Where the pictures, the curves and the page index.html go
    #[arg(short, long, value_name = "DIR")]
    pub output: PathBuf,
}

/// A material with all that was found of it.
pub struct Found {
    pub name: String,
    pub curves: Curves,
    pub phenomena: Phenomena,
    /// Its pictures, relative to the page.
    pub picture: String,
    pub other_light: String,
    /// How far it is from the first; none for the first itself.
    pub difference: Option<Difference>,
}

/// How far a picture is from the first.
pub struct Difference {
    pub picture: String,
    /// Of linear RGB as exposed.
    pub rmse: f64,
    pub flip: f64,
}

/// Runs the command.
pub fn run(args: &CompareArgs, json: bool) -> Result<()> {
    logging::start_offline();
    let renderer = Renderer::new(args.frame.backend);
    let (frame, mesh) = args.frame.load(&renderer, PictureFormat::Png)?;
    let mut scene = frame.scene()?;
    let assets = renderer.light_assets();
    let subjects: Vec<Subject> = args.materials.iter().map(Subject::read).collect::<Result<_>>()?;
    output::make_dir(&args.output)?;
    let shot = |scene: &Scene, subject: &Subject| {
        let (size_px, sampling) = (args.frame.size, args.frame.samples);
        Shot { mesh: mesh.mesh(), scene, assets: &assets, size_px, sampling }.take(subject)
    };
    let spinner = output::spinner("comparing");
    let first = shot(&scene, &subjects[0]);
    // One exposure for all, or what is darker would not look so.
    let exposure_ev = first.developed.exposure_ev;
    scene.film.exposure = Exposure::Ev(exposure_ev);
    let other = scene.with_light_deg(scene.light_deg + OTHER_LIGHT_DEG);
    let reference = pixels(&first, exposure_ev);
    let mut all = Vec::with_capacity(subjects.len());
    for (index, subject) in subjects.iter().enumerate() {
        let write = |what: &str, developed: &Developed| -> Result<String> {
            let file = format!("{index:02}-{what}.png");
            let png = encode_png(developed.width, developed.height, &developed.rgba);
            output::write_file(&args.output.join(&file), &png)?;
            Ok(file)
        };
        let picture = shot(&scene, subject);
        let difference = match index {
            0 => None,
            _ => {
                let own = pixels(&picture, exposure_ev);
                let file = format!("{index:02}-difference.png");
                let apart = diff::absolute(&reference, &own).encoded();
                let path = args.output.join(&file);
                apart.save(&path).with_context(|| format!("write {}", path.display()))?;
                let (rmse, flip) = (diff::rmse(&reference, &own), diff::flip(&reference, &own));
                Some(Difference { picture: file, rmse, flip })
            }
        };
        let curves = Curves::of(subject);
        all.push(Found {
            name: subject.name().to_owned(),
            phenomena: Phenomena::of(subject, &curves, |degrees| {
                let mut scene = scene.with_light_deg(degrees);
                scene.film.exposure = Exposure::Auto;
                let (mesh, sampling) = (mesh.mesh(), args.frame.samples);
                let (scene, assets) = (&scene, &assets);
                let small = Shot { mesh, scene, assets, size_px: SMALL_PX, sampling };
                small.take(subject).developed.exposure_ev
            }),
            curves,
            picture: write("picture", &picture.developed)?,
            other_light: write("other-light", &shot(&other, subject).developed)?,
            difference,
        });
    }
    spinner.finish_and_clear();
    curve::write(&all, &args.output)?;
    let report = report(&all, exposure_ev);
    let text = serde_json::to_string_pretty(&report)?;
    output::write_file(&args.output.join("report.json"), text.as_bytes())?;
    let page = page::html(&all, exposure_ev);
    output::write_file(&args.output.join("index.html"), page.as_bytes())?;
    if json { output::print_json(&report) } else { output::print(&table(&all, args)) }
}

/// Linear pixels as exposed, over black.
fn pixels(picture: &Picture, exposure_ev: f64) -> Pixels {
    let gain = exposure_ev.exp2();
    let radiance = &picture.radiance;
    let exposed = |rgb: &[f32; 3]| rgb.map(|channel| f64::from(channel) * gain);
    let linear = radiance.premultiplied().iter().map(exposed).collect();
    Pixels::from_linear(radiance.width(), radiance.height(), linear)
}

fn report(all: &[Found], exposure_ev: f64) -> Value {
    let one = |found: &Found| {
        let difference = found.difference.as_ref().map(
            |Difference { picture, rmse, flip }| json!({ "picture": picture, "rmse": rmse, "flip": flip }),
        );
        json!({
            "name": found.name,
            "picture": found.picture,
            "other_light": found.other_light,
            "difference": difference,
            "albedo": found.curves.report(),
            "phenomena": found.phenomena.report(),
        })
    };
    json!({ "exposure_ev": exposure_ev, "materials": all.iter().map(one).collect::<Vec<Value>>() })
}

fn table(all: &[Found], args: &CompareArgs) -> String {
    let width = all.iter().map(|found| found.name.chars().count()).max().unwrap_or(0);
    let mut text = format!(
        "{:width$}  {:>8} {:>8}  {:>8} {:>9}  {:>13}\n",
        "", "rmse", "flip", "albedo", "Fresnel x", "exposures, EV"
    );
    for found in all {
        let (rmse, flip) = match &found.difference {
            Some(Difference { rmse, flip, .. }) => (format!("{rmse:.4}"), format!("{flip:.4}")),
            None => ("-".to_owned(), "-".to_owned()),
        };
        let Phenomena { fresnel_rise, largest_albedo, exposures_ev: [low, high], .. } =
            &found.phenomena;
        text += &format!(
            "{:width$}  {rmse:>8} {flip:>8}  {largest_albedo:>8.4} {fresnel_rise:>9.2}  {:>13}\n",
            found.name,
            format!("{low:.2} to {high:.2}"),
        );
    }
    text + &format!("{}\n", args.output.join("index.html").display())
}
