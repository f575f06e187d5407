//! `brood compare`: compares materials in one scene: differences between their pictures, and
//! physical measures of each.
//!
//! Owns the options and the files: pictures, differences, curves as CSV and SVG, a report, and a
//! page that shows everything.

mod curve;
mod material;
mod page;

use std::path::PathBuf;

use anyhow::Result;
use brood_bench::{logging, output};
use brood_eval::{Developed, encode_png};
use brood_inspect::{COMPARED, CurvePoint, LightOrbit, OTHER_LIGHT_DEG, Phenomena, Shot, curves};
use brood_protocol::PictureFormat;
use brood_scene::{Exposure, Scene};
use brood_worker::Renderer;
use clap::Args;
use serde_json::{Value, json};

use crate::frame::FrameArgs;
pub use material::NamedMaterial;

/// Options of `brood compare`.
#[derive(Debug, Args)]
pub struct CompareArgs {
    /// Two to six materials: `.brood` or JSON files of genomes or models, or measured tables; the
    /// first is the reference
    #[arg(required = true, num_args = COMPARED)]
    pub materials: Vec<PathBuf>,
    #[command(flatten)]
    pub frame: FrameArgs,
    /// Folder for the pictures, the curves and the page index.html
    #[arg(short, long, value_name = "DIR")]
    pub output: PathBuf,
}

/// Results of one material.
pub struct ComparedMaterial {
    pub name: String,
    pub curves: Vec<CurvePoint>,
    pub phenomena: Phenomena,
    /// Path of its picture, relative to the page.
    pub picture: String,
    /// Path of its picture with the light moved by [`OTHER_LIGHT_DEG`], relative to the page.
    pub other_light: String,
    /// Difference from the reference; `None` for the reference itself.
    pub difference: Option<ReferenceDifference>,
}

/// Difference of a picture from that of the reference.
pub struct ReferenceDifference {
    /// Path of the picture of absolute differences, relative to the page.
    pub picture: String,
    /// RMSE of linear RGB after exposure.
    pub rmse: f64,
    /// Mean FLIP error.
    pub flip: f64,
}

/// Runs the command.
pub fn run(args: &CompareArgs, json: bool) -> Result<()> {
    logging::start_offline();
    let renderer = Renderer::new(args.frame.backend);
    let (frame, mesh) = args.frame.load_alone(&renderer, PictureFormat::Png)?;
    let mut scene = frame.scene()?;
    let assets = renderer.light_assets();
    let subjects: Vec<NamedMaterial> =
        args.materials.iter().map(NamedMaterial::read).collect::<Result<_>>()?;
    output::make_dir(&args.output)?;
    let shot = |scene: &Scene, subject: &NamedMaterial| {
        let (size_px, sampling) = (args.frame.size, args.frame.samples);
        Shot { mesh: mesh.mesh(), scene, assets: &assets, size_px, sampling }.take(subject)
    };
    let spinner = output::spinner("comparing");
    let circle = LightOrbit::trace(mesh.mesh(), &scene, &assets);
    // One exposure for all, so that a darker material looks darker.
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
        let own = picture.linear(exposure_ev);
        let difference = match &reference {
            None => {
                reference = Some(own);
                None
            }
            Some(reference) => {
                let file = format!("{index:02}-difference.png");
                let (width, height) = own.size();
                let absolute = reference.absolute_difference(&own).encoded_rgba();
                output::write_file(
                    &args.output.join(&file),
                    &encode_png(width, height, &absolute),
                )?;
                let (rmse, flip) = (reference.rmse(&own), reference.flip(&own));
                Some(ReferenceDifference { picture: file, rmse, flip })
            }
        };
        let curves = curves(&subject.specimen());
        all.push(ComparedMaterial {
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

fn report(all: &[ComparedMaterial], exposure_ev: f64) -> Value {
    let one = |found: &ComparedMaterial| {
        let difference = found.difference.as_ref().map(
            |ReferenceDifference { picture, rmse, flip }| json!({ "picture": picture, "rmse": rmse, "flip": flip }),
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

fn table(all: &[ComparedMaterial], args: &CompareArgs) -> String {
    let width = all.iter().map(|found| found.name.chars().count()).max().unwrap_or(0);
    let mut text = format!(
        "{:width$}  {:>8} {:>8}  {:>8} {:>9}  {:>13}\n",
        "", "rmse", "flip", "albedo", "Fresnel x", "exposures, EV"
    );
    for found in all {
        let (rmse, flip) = match &found.difference {
            Some(ReferenceDifference { rmse, flip, .. }) => {
                (format!("{rmse:.4}"), format!("{flip:.4}"))
            }
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
