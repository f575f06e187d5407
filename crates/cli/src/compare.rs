//! `brood compare`: materials side by side in one scene, how far they are apart, and what their reflection has of physics.
//!
//! Owns the options and the files: pictures, differences, curves as CSV and SVG, a report, and a page that shows them all.

mod curve;
mod page;
mod subject;

use std::path::PathBuf;

use anyhow::Result;
use brood_eval::{Developed, encode_png};
use brood_inspect::{
    COMPARED, CurvePoint, LightCircle, LinearImage, OTHER_LIGHT_DEG, Phenomena, Picture, Shot,
    curves,
};
use brood_protocol::PictureFormat;
use brood_scene::{Exposure, Scene};
use brood_worker::Renderer;
use clap::Args;
use serde_json::{Value, json};

use crate::frame::FrameArgs;
use crate::{logging, output};
pub use subject::Subject;

/// Options of `brood compare`.
#[derive(Debug, Args)]
pub struct CompareArgs {
    /// Two to six materials: `.brood` or JSON files of genomes and models, or measured tables; the others are held against the first
    #[arg(required = true, num_args = COMPARED)]
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
    pub curves: Vec<CurvePoint>,
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
    let circle = LightCircle::trace(mesh.mesh(), &scene, &assets);
    // One exposure for all, or what is darker would not look so.
    let exposure_ev = circle.ev(&subjects[0].specimen(), scene.film);
    scene.film.exposure = Exposure::Ev(exposure_ev);
    let other = scene.with_light_deg(scene.light_deg + OTHER_LIGHT_DEG);
    let mut reference = None;
    let mut all = Vec::with_capacity(subjects.len());
    for (index, subject) in subjects.iter().enumerate() {
        let write = |what: &str, developed: &Developed| -> Result<String> {
            let file = format!("{index:02}-{what}.png");
            let png = encode_png(developed.width, developed.height, &developed.rgba);
            output::write_file(&args.output.join(&file), &png)?;
            Ok(file)
        };
        let picture = shot(&scene, subject);
        let own = pixels(&picture, exposure_ev);
        let difference = match &reference {
            None => {
                reference = Some(own);
                None
            }
            Some(reference) => {
                let file = format!("{index:02}-difference.png");
                let (width, height) = own.size();
                let apart = reference.absolute_difference(&own).encoded_rgba();
                output::write_file(&args.output.join(&file), &encode_png(width, height, &apart))?;
                let (rmse, flip) = (reference.rmse(&own), reference.flip(&own));
                Some(Difference { picture: file, rmse, flip })
            }
        };
        let curves = curves(&subject.specimen());
        all.push(Found {
            name: subject.name().to_owned(),
            phenomena: Phenomena::of(&subject.specimen(), &curves, &circle),
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
fn pixels(picture: &Picture, exposure_ev: f64) -> LinearImage {
    let radiance = &picture.radiance;
    let linear = radiance.premultiplied().iter().map(|rgb| rgb.map(f64::from)).collect();
    LinearImage::new(radiance.width(), radiance.height(), linear).exposed(exposure_ev)
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
            "curves": found.curves,
            "phenomena": found.phenomena,
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
