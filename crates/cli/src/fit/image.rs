//! Pictures of known scenes as targets of `brood fit`: one with the options of the command line, or several in a JSON file.
//!
//! Owns the files: pictures, masks, scenes and meshes in, and what was found beside them out. Which pixels say something is the
//! search's business.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use anyhow::{Context, Result, bail, ensure};
use brood_eval::{LinearPicture, decode_linear, encode_png};
use brood_genome::Genome;
use brood_inspect::LinearImage;
use brood_protocol::PictureFormat;
use brood_scene::{LightAssets, MeshRef, Sampling, Scene};
use brood_search::{ImageView, MeasuredTarget, PixelCounts, Samples, View, pooled};
use brood_worker::{LoadedMesh, Renderer};
use serde::Deserialize;
use serde_json::{Value, json};

use super::FitArgs;
use crate::compare::Subject;
use crate::frame::read_obj;
use crate::model_picture::Shot;
use crate::{light_file, output};

const PICTURE_BYTES: u64 = 256 << 20;
const JSON_BYTES: u64 = 4 << 20;
/// As pictures that are rendered.
const SIDE_MOST: u32 = 4096;

/// Several pictures.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Spec {
    views: Vec<ViewSpec>,
}

/// One of them; names are paths from the folder of the file.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct ViewSpec {
    picture: PathBuf,
    /// A scene, or the name of its file.
    scene: SceneSpec,
    mesh: Option<PathBuf>,
    mask: Option<PathBuf>,
    #[serde(default)]
    samples: Sampling,
    /// Brightness is not known.
    #[serde(default)]
    gain: bool,
    /// Nothing is fitted to it: it is only compared with what was found.
    #[serde(default)]
    held_out: bool,
}

#[derive(Debug, Deserialize)]
#[serde(untagged)]
enum SceneSpec {
    File(PathBuf),
    Scene(Box<Scene>),
}

/// A picture with its scene.
struct Shown {
    name: String,
    scene: Scene,
    mesh: Arc<LoadedMesh>,
    assets: LightAssets,
    sampling: Sampling,
    side: u32,
    view: ImageView,
    is_held_out: bool,
}

/// The pictures of a target.
pub struct Pictures {
    shown: Vec<Shown>,
    samples: Samples,
    counts: PixelCounts,
}

/// What is needed of a picture before it is looked at.
struct Source {
    picture: PathBuf,
    mask: Option<PathBuf>,
    scene: Scene,
    mesh: Arc<LoadedMesh>,
    assets: LightAssets,
    sampling: Sampling,
    is_gain_unknown: bool,
    is_held_out: bool,
}

/// The pictures that the arguments name; none where the target is no picture.
pub fn read(args: &FitArgs, renderer: &Renderer) -> Result<Option<Pictures>> {
    let extension = args.target.extension().and_then(|extension| extension.to_str());
    let sources = match extension.map(str::to_ascii_lowercase).as_deref() {
        Some("png" | "jpg" | "jpeg" | "hdr") => vec![alone(args, renderer)?],
        Some("exr") if !args.slice && (args.frame.scene.is_some() || args.mask.is_some()) => {
            vec![alone(args, renderer)?]
        }
        Some("json") => several(args, renderer)?,
        _ if args.mask.is_some() => bail!("--mask is for pictures"),
        _ => return Ok(None),
    };
    let mut shown = Vec::with_capacity(sources.len());
    let mut used = Vec::with_capacity(sources.len());
    for source in sources {
        let name = source.picture.display().to_string();
        let (one, samples) = look(source).with_context(|| name)?;
        if one.is_held_out {
            shown.push((one, None));
        } else {
            shown.push((one, Some(used.len())));
            used.push(samples);
        }
    }
    ensure!(!used.is_empty(), "every picture is held out, and nothing is left to fit");
    let (fitted, held): (Vec<_>, Vec<_>) = shown.into_iter().partition(|(_, at)| at.is_some());
    let (samples, counts) = pooled(fitted.iter().map(|(one, _)| &one.view).zip(&used))
        .with_context(|| args.target.display().to_string())?;
    let shown = fitted.into_iter().chain(held).map(|(one, _)| one).collect();
    Ok(Some(Pictures { shown, samples, counts }))
}

/// The one picture of the command line.
fn alone(args: &FitArgs, renderer: &Renderer) -> Result<Source> {
    let (frame, mesh) = args.frame.load(renderer, PictureFormat::Png)?;
    Ok(Source {
        picture: args.target.clone(),
        mask: args.mask.clone(),
        scene: frame.scene()?,
        mesh,
        assets: renderer.light_assets(),
        sampling: args.frame.samples,
        is_gain_unknown: args.gain,
        is_held_out: false,
    })
}

fn several(args: &FitArgs, renderer: &Renderer) -> Result<Vec<Source>> {
    let name = || args.target.display().to_string();
    ensure!(args.mask.is_none(), "masks of several pictures are named in {}", name());
    let bytes = output::read_file(&args.target, JSON_BYTES)?;
    let json: Value = serde_json::from_slice(&bytes).with_context(name)?;
    ensure!(
        json.get("views").is_some(),
        "{} is no target: a JSON file of pictures has \"views\"",
        name()
    );
    let spec: Spec = serde_json::from_value(json).with_context(name)?;
    let folder = args.target.parent().unwrap_or(Path::new(""));
    spec.views.into_iter().map(|view| source(view, folder, renderer)).collect()
}

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
    scene.validate().with_context(|| format!("the scene of {} is refused", picture.display()))?;
    let mesh = match (&spec.mesh, &scene.mesh) {
        (Some(file), _) => Arc::new(read_obj(&folder.join(file))?),
        (None, MeshRef::Builtin(mesh)) => renderer.builtin(*mesh),
        (None, MeshRef::Uploaded(_)) => bail!(
            "the scene of {} shows an uploaded mesh; name its file as \"mesh\"",
            picture.display()
        ),
    };
    Ok(Source {
        mask: spec.mask.map(|file| folder.join(file)),
        assets: light_file::read(&scene, &beside)?,
        sampling: spec.samples,
        is_gain_unknown: spec.gain,
        is_held_out: spec.held_out,
        picture,
        scene,
        mesh,
    })
}

fn decode(path: &Path) -> Result<LinearPicture> {
    let bytes = output::read_file(path, PICTURE_BYTES)?;
    decode_linear(&bytes, SIDE_MOST).with_context(|| path.display().to_string())
}

fn look(source: Source) -> Result<(Shown, Samples)> {
    let picture = decode(&source.picture)?;
    ensure!(
        picture.width.max(picture.height) <= SIDE_MOST,
        "a target has at most {SIDE_MOST} x {SIDE_MOST} pixels"
    );
    let mask = source.mask.as_deref().map(decode).transpose()?;
    let Source { picture: path, scene, mesh, assets, sampling, is_held_out, .. } = source;
    let view = View {
        mesh: mesh.mesh(),
        scene: &scene,
        assets: &assets,
        sampling,
        picture: &picture,
        mask: mask.as_ref(),
        is_gain_unknown: source.is_gain_unknown,
    };
    let (view, samples) = ImageView::new(&view)?;
    let name = path.file_name().map_or_else(String::new, |name| name.to_string_lossy().into());
    let side = picture.width;
    Ok((Shown { name, scene, mesh, assets, sampling, side, view, is_held_out }, samples))
}

impl Pictures {
    /// What is fitted and what is held out.
    pub fn target(&self) -> Result<MeasuredTarget> {
        Ok(MeasuredTarget::of_pixels(&self.samples)?)
    }

    /// Writes target, best, difference and used pixels of each picture; what is told of them.
    pub fn write(&self, folder: &Path, best: &Genome) -> Result<Vec<Value>> {
        let subject = Subject::of("best", best.clone());
        let one = |(index, shown): (usize, &Shown)| shown.write((folder, index), &subject);
        self.shown.iter().enumerate().map(one).collect()
    }

    /// What became of all pixels that could be fitted to.
    pub fn counts(&self) -> PixelCounts {
        self.counts
    }
}

impl Shown {
    fn write(&self, (folder, index): (&Path, usize), best: &Subject) -> Result<Value> {
        let Self { scene, assets, side, sampling, view, .. } = self;
        let shot =
            Shot { mesh: self.mesh.mesh(), scene, assets, size_px: *side, sampling: *sampling };
        let taken = shot.take(best);
        let error = view.compare(&taken.radiance);
        // Both at one exposure: the scene's own, or what is automatic for what was found.
        let ev = taken.developed.exposure_ev;
        let gain_ev = if error.gain > 0.0 { libm::log2(error.gain) } else { 0.0 };
        let linear = |pixels: Vec<[f64; 3]>| LinearImage::new(*side, *side, pixels);
        let wanted = linear(view.wanted().to_vec()).exposed(ev - gain_ev);
        let found = taken.radiance.premultiplied().iter().map(|pixel| pixel.map(f64::from));
        let found = linear(found.collect()).exposed(ev);
        let used = view.used().iter().map(|used| [f64::from(u8::from(*used)); 3]).collect();
        let pictures = [
            ("target", &wanted),
            ("best", &found),
            ("difference", &wanted.absolute_difference(&found)),
            ("pixels", &linear(used)),
        ];
        for (name, picture) in pictures {
            let number = if index == 0 { String::new() } else { format!("-{}", index + 1) };
            let png = encode_png(*side, *side, &picture.encoded_rgba());
            output::write_file(&folder.join(format!("{name}{number}.png")), &png)?;
        }
        Ok(json!({
            "picture": self.name,
            "held_out": self.is_held_out,
            "rmse": error.rmse,
            "rmse_used": error.rmse_used,
            "gain": error.gain,
            "gain_solved": view.is_gain_unknown(),
            "exposure_ev": ev,
            "flip": wanted.flip(&found),
            "pixels": view.counts(),
        }))
    }
}

/// What is told of pictures, for people.
pub fn text(views: &[Value], counts: PixelCounts) -> String {
    let mut text = format!("{} pixels used: {counts}\n", counts.used);
    for view in views {
        let number = |name: &str| view[name].as_f64().unwrap_or(f64::NAN);
        let held = if view["held_out"] == true { ", held out" } else { "" };
        let gain = if view["gain_solved"] == true {
            format!(", times {:.4}, which brightness was not known by", number("gain"))
        } else {
            String::new()
        };
        text += &format!(
            "{}{held}: RMSE {:.2e} of linear radiance over the picture, {:.2e} over the pixels used{gain}; FLIP {:.4}\n",
            view["picture"].as_str().unwrap_or_default(),
            number("rmse"),
            number("rmse_used"),
            number("flip"),
        );
    }
    text
}
