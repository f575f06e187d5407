//! Pictures of known scenes as targets of `brood fit`: one from the command line, or several from a
//! JSON file.
//!
//! Owns the files: pictures, masks, scenes and meshes as input, comparison pictures as output. The
//! search crate decides which pixels are usable.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail, ensure};
use brood_bench::output;
use brood_eval::encode_png;
use brood_genome::Genome;
use brood_inspect::LinearImage;
use brood_mesh::BuiltinMesh;
use brood_protocol::PictureFormat;
use brood_scene::{ClipFrom, PictureSize, PixelArea, Refine, Sampling, Scene};
use brood_search::{Calibrated, Corrected, calibrate};
use brood_target::{
    KnownView, MeasuredTarget, Pictures as KnownPictures, PicturesError, PixelCounts, PixelStatus,
    ViewSetup,
};
use brood_worker::{Renderer, ViewComparison};
use serde::Deserialize;
use serde_json::{Value, json};

use super::FitArgs;
use crate::compare::NamedMaterial;
use crate::frame::read_obj;
use crate::light_file;

const PICTURE_BYTES: u64 = 256 << 20;
const JSON_BYTES: u64 = 4 << 20;
/// Stated standard deviations above which a correction is doubtful.
const FAR: f64 = 2.0;

/// JSON file of several pictures.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Spec {
    views: Vec<ViewSpec>,
}

/// One picture; file names are relative to the folder of the JSON file.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct ViewSpec {
    picture: PathBuf,
    /// Scene, or the name of its file.
    scene: SceneSpec,
    /// OBJ file; needed only if the scene uses an uploaded mesh.
    mesh: Option<PathBuf>,
    /// Picture whose white pixels are used; all by default.
    mask: Option<PathBuf>,
    /// Samples per pixel.
    #[serde(default)]
    samples: Sampling,
    /// True if the brightness is unknown and a gain is solved for.
    #[serde(default)]
    gain: bool,
    /// Code from which a channel counts as clipped: "auto", "off" or a number.
    #[serde(default)]
    clip_from: ClipFrom,
    /// Part of the picture to use: first column and row, width and height. All by default.
    #[serde(default)]
    crop: Option<[u32; 4]>,
    /// True if the picture is only compared with the result, not fitted.
    #[serde(default)]
    held_out: bool,
    /// Uncertainties within which the scene is corrected.
    #[serde(default)]
    refine: Refine,
}

/// Scene in the JSON file itself, or the name of a file.
#[derive(Debug, Deserialize)]
#[serde(untagged)]
enum SceneSpec {
    File(PathBuf),
    Scene(Box<Scene>),
}

/// The pictures of a target, held-out ones last, with the samples gathered from them.
pub struct TargetPictures {
    target: MeasuredTarget,
    /// The decoded pictures with their scenes.
    read: KnownPictures,
    /// File names of the pictures.
    names: Vec<String>,
    /// Corrections of the scenes.
    corrections: Vec<Corrected>,
}

/// Files and settings of a picture that is not read yet.
struct Source {
    picture: PathBuf,
    mask: Option<PathBuf>,
    setting: ViewSetup,
}

/// Reads the pictures that the arguments name; `None` if the target is not a picture.
pub fn read(args: &FitArgs, renderer: &Renderer) -> Result<Option<TargetPictures>> {
    let extension = args.target.extension().and_then(|extension| extension.to_str());
    let sources = match extension.map(str::to_ascii_lowercase).as_deref() {
        Some("png" | "jpg" | "jpeg" | "hdr") => vec![single(args, renderer)?],
        Some("exr") if !args.slice && is_picture(args) => vec![single(args, renderer)?],
        Some("json") => several(args, renderer)?,
        _ if args.mask.is_some() => bail!("--mask needs a picture as target"),
        _ if args.clip_from != ClipFrom::Auto => bail!("--clip-from needs a picture as target"),
        _ if args.crop.is_some() => bail!("--crop needs a picture as target"),
        _ if args.refine.is_some() => bail!("--refine needs a picture as target"),
        _ => return Ok(None),
    };
    // Pictures that are fitted come first.
    let (fitted, held): (Vec<_>, Vec<_>) =
        sources.into_iter().partition(|source| !source.setting.is_held_out);
    let sources: Vec<Source> = fitted.into_iter().chain(held).collect();
    let paths: Vec<PathBuf> = sources.iter().map(|source| source.picture.clone()).collect();
    let files = sources.into_iter().map(Source::load).collect::<Result<Vec<_>>>()?;
    let views = files
        .into_iter()
        .map(|File { setting, picture, mask }| KnownView::read(setting, &picture, mask.as_deref()));
    let (read, target) = KnownPictures::gather(views).map_err(|error| match error {
        PicturesError::View { index, error } => {
            anyhow::Error::from(error).context(paths[index].display().to_string())
        }
        few @ PicturesError::Few(_) => {
            anyhow::Error::from(few).context(args.target.display().to_string())
        }
        other => other.into(),
    })?;
    let name = |path: &PathBuf| {
        path.file_name().map_or_else(String::new, |name| name.to_string_lossy().into())
    };
    let names = paths.iter().map(name).collect();
    Ok(Some(TargetPictures { target, read, names, corrections: Vec::new() }))
}

/// True if the arguments make an EXR a picture instead of an image slice.
fn is_picture(args: &FitArgs) -> bool {
    args.frame.scene.is_some() || args.mask.is_some() || args.crop.is_some()
}

/// The single picture of the command line.
fn single(args: &FitArgs, renderer: &Renderer) -> Result<Source> {
    let (frame, mesh) = args.frame.load_alone(renderer, PictureFormat::Png)?;
    Ok(Source {
        picture: args.target.clone(),
        mask: args.mask.clone(),
        setting: ViewSetup {
            scene: frame.scene()?,
            mesh: mesh.shared(),
            assets: renderer.light_assets(),
            sampling: args.frame.samples,
            is_gain_unknown: args.gain,
            clip_from: args.clip_from,
            crop: args.crop,
            is_held_out: false,
            refine: args.refine.unwrap_or_default(),
        },
    })
}

/// The pictures that a JSON file lists.
fn several(args: &FitArgs, renderer: &Renderer) -> Result<Vec<Source>> {
    let name = || args.target.display().to_string();
    ensure!(
        args.mask.is_none(),
        "--mask is for a single picture; name masks of several pictures in {}",
        name()
    );
    ensure!(
        args.clip_from == ClipFrom::Auto,
        "--clip-from is for a single picture; set \"clip_from\" of several pictures in {}",
        name()
    );
    ensure!(
        args.crop.is_none(),
        "--crop is for a single picture; set \"crop\" of several pictures in {}",
        name()
    );
    ensure!(
        args.refine.is_none(),
        "--refine is for a single picture; set \"refine\" of several pictures in {}",
        name()
    );
    let bytes = output::read_file(&args.target, JSON_BYTES)?;
    let json: Value = serde_json::from_slice(&bytes).with_context(name)?;
    ensure!(
        json.get("views").is_some(),
        "{} must have \"views\": a JSON target lists pictures",
        name()
    );
    let spec: Spec = serde_json::from_value(json).with_context(name)?;
    let folder = args.target.parent().unwrap_or(Path::new(""));
    spec.views.into_iter().map(|view| source(view, folder, renderer)).collect()
}

/// Reads the scene and the mesh of a picture. `folder` is that of the JSON file.
fn source(spec: ViewSpec, folder: &Path, renderer: &Renderer) -> Result<Source> {
    let picture = folder.join(&spec.picture);
    let (scene, beside) = match spec.scene {
        SceneSpec::Scene(scene) => (*scene, folder.to_owned()),
        SceneSpec::File(file) => {
            let path = folder.join(file);
            let bytes = output::read_file(&path, JSON_BYTES)?;
            let scene = serde_json::from_slice(&bytes).with_context(|| path.display().to_string());
            (scene?, path.parent().unwrap_or(Path::new("")).to_owned())
        }
    };
    scene.validate().with_context(|| format!("the scene of {} is invalid", picture.display()))?;
    let refine = spec.refine.validate();
    refine.with_context(|| format!("\"refine\" of {} is invalid", picture.display()))?;
    let mesh = match (&spec.mesh, scene.builtin()) {
        (Some(_), Some(BuiltinMesh::SphereZ)) => bail!(
            "the scene of {} has \"sphere_pole\": \"z\", which needs the built-in sphere instead of \
             an OBJ file",
            picture.display()
        ),
        (Some(file), _) => read_obj(&folder.join(file))?.shared(),
        (None, Some(mesh)) => renderer.builtin(mesh).shared(),
        (None, None) => bail!(
            "the scene of {} uses an uploaded mesh; name its OBJ file as \"mesh\"",
            picture.display()
        ),
    };
    Ok(Source {
        mask: spec.mask.map(|file| folder.join(file)),
        setting: ViewSetup {
            assets: light_file::read(&scene, &beside)?,
            sampling: spec.samples,
            is_gain_unknown: spec.gain,
            clip_from: spec.clip_from,
            crop: spec.crop.map(|[x, y, width, height]| PixelArea { x, y, width, height }),
            is_held_out: spec.held_out,
            refine: spec.refine,
            scene,
            mesh,
        },
        picture,
    })
}

/// Contents of a picture's files.
struct File {
    setting: ViewSetup,
    picture: Vec<u8>,
    mask: Option<Vec<u8>>,
}

impl Source {
    fn load(self) -> Result<File> {
        let read = |path: &PathBuf| output::read_file(path, PICTURE_BYTES);
        let (picture, mask) = (read(&self.picture)?, self.mask.as_ref().map(read).transpose()?);
        Ok(File { setting: self.setting, picture, mask })
    }
}

impl TargetPictures {
    /// Corrects the scenes within their uncertainties.
    pub fn calibrated(self) -> Result<Self> {
        let found = calibrate(self.read, self.target).context("correct the scenes")?;
        let Calibrated { pictures: read, target, corrections } = found;
        Ok(Self { target, read, corrections, ..self })
    }

    /// Corrections of the scenes; empty if they are exact.
    pub fn corrections(&self) -> &[Corrected] {
        &self.corrections
    }

    /// Samples to fit and held-out samples.
    pub fn target(&self) -> MeasuredTarget {
        self.target.clone()
    }

    /// Writes target, best, difference and used pixels of each picture; returns the errors as JSON.
    ///
    /// Also writes the scenes if they were corrected.
    pub fn write(&self, folder: &Path, best: &Genome) -> Result<Vec<Value>> {
        for (index, view) in self.read.views.iter().enumerate() {
            if self.corrections.iter().any(|one| one.pictures.contains(&index)) {
                let scene = serde_json::to_string_pretty(&view.setting.scene);
                let path = folder.join(format!("scene{}.json", number(index)));
                output::write_file(&path, scene.context("write JSON")?.as_bytes())?;
            }
        }
        let subject = NamedMaterial::of("best", best.clone());
        let shown = self.read.views.iter().zip(&self.names).enumerate();
        shown.map(|(index, one)| write((folder, index), one, &subject)).collect()
    }

    /// The first picture.
    pub fn first(&self) -> &KnownView {
        &self.read.views[0]
    }

    /// Counts of the pixels by status, over all fitted pictures.
    pub fn counts(&self) -> PixelCounts {
        self.read.counts
    }
}

/// Writes the pictures of one view; returns its errors as JSON.
fn write(
    (folder, index): (&Path, usize),
    (known, name): (&KnownView, &String),
    best: &NamedMaterial,
) -> Result<Value> {
    let ViewComparison { wanted, found, error, flip, exposure_ev } =
        ViewComparison::of(known, best);
    let (view, PictureSize { width, height }) = (&known.view, known.size_px());
    let used = |status: &PixelStatus| [f64::from(u8::from(status.is_usable())); 3];
    let used = LinearImage::new(width, height, view.statuses().iter().map(used).collect());
    let pictures = [
        ("target", &wanted),
        ("best", &found),
        ("difference", &wanted.absolute_difference(&found)),
        ("pixels", &used),
    ];
    for (what, picture) in pictures {
        let png = encode_png(width, height, &picture.encoded_rgba());
        output::write_file(&folder.join(format!("{what}{}.png", number(index))), &png)?;
    }
    Ok(json!({
        "picture": name,
        "held_out": known.setting.is_held_out,
        "rmse": error.rmse,
        "rmse_used": error.rmse_used,
        "gain": error.gain,
        "gain_solved": view.is_gain_unknown(),
        "clip_from": known.setting.clip_from,
        "crop": known.setting.crop.map(|area| [area.x, area.y, area.width, area.height]),
        "clipped_from": view.clipped_from(),
        "exposure_ev": exposure_ev,
        "flip": flip,
        "pixels": view.counts(),
    }))
}

/// Number of a picture in file names; empty for the first.
fn number(index: usize) -> String {
    if index == 0 { String::new() } else { format!("-{}", index + 1) }
}

/// Corrections as JSON.
pub fn corrections(all: &[Corrected]) -> Value {
    let one = |one: &Corrected| {
        json!({
            "name": one.name, "pictures": one.pictures, "value": one.value,
            "stated_deviation": one.stated_deviation, "deviation": one.deviation,
            "moved": one.moved(),
        })
    };
    all.iter().map(one).collect()
}

/// Formats corrections for a terminal.
pub fn corrections_text(all: &[Corrected]) -> String {
    let line = |one: &Corrected| {
        let pictures: Vec<String> = one.pictures.iter().map(|k| (k + 1).to_string()).collect();
        let moved = one.moved();
        let warning = if moved > FAR {
            format!("; {moved:.1} of these from what was stated: is the scene right?")
        } else {
            String::new()
        };
        format!(
            "picture {}: {} {:.4}, standard deviation {:.4} (stated {:.4}{warning})\n",
            pictures.join(", "),
            one.name,
            one.value,
            one.deviation,
            one.stated_deviation
        )
    };
    all.iter().map(line).collect()
}

/// Formats the errors of the pictures for a terminal.
pub fn text(views: &[Value], counts: PixelCounts) -> String {
    let mut text = format!("{} pixels used: {counts}\n", counts.usable());
    for view in views {
        let number = |name: &str| view[name].as_f64().unwrap_or(f64::NAN);
        let held = if view["held_out"] == true { ", held out" } else { "" };
        let gain = if view["gain_solved"] == true {
            format!(" after a gain of {:.4}", number("gain"))
        } else {
            String::new()
        };
        let clipped = clipped_in_words(view);
        text += &format!(
            "{}{held}: RMSE {:.2e} of linear radiance over the picture, {:.2e} over the pixels used{gain}; FLIP {:.4}{clipped}\n",
            view["picture"].as_str().unwrap_or_default(),
            number("rmse"),
            number("rmse_used"),
            number("flip"),
        );
    }
    text
}

/// Clipped pixels of a picture, and the codes from which its channels are clipped; empty without
/// any.
fn clipped_in_words(view: &Value) -> String {
    let channels = ["red", "green", "blue"].iter().enumerate();
    let codes = channels.filter_map(|(channel, name)| {
        let code = view["clipped_from"][channel].as_u64()?;
        Some(format!("{name} {code}"))
    });
    let codes: Vec<String> = codes.collect();
    if codes.is_empty() {
        return String::new();
    }
    let (count, setting) = (&view["pixels"]["clipped"], &view["clip_from"]);
    let how = if setting == "auto" { "found" } else { "set" };
    format!("; {count} pixels clipped, from code {} ({how})", codes.join(", "))
}
