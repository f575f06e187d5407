//! Options of offline pictures: scene, mesh, light, size and evaluator.

use std::path::{Path, PathBuf};
use std::str::FromStr;
use std::sync::Arc;

use anyhow::{Context, Result, bail, ensure};
use brood_bench::output::read_file;
use brood_light::Light;
use brood_mesh::{BuiltinMesh, ObjLimits, parse_obj};
use brood_protocol::{Backend, Frame, MeshSource, PictureFormat};
use brood_scene::{Exposure, MeshRef, PictureSize, Sampling, Scene, Tone};
use brood_worker::{LoadedMesh, Renderer};
use clap::Args;

use crate::{image_file, light_file, object_file};

/// Largest side of a picture in pixels.
const SIDE_MAX_PX: u32 = 4096;
const SCENE_LIMIT_BYTES: u64 = 256 << 10;
/// Largest fixed number of samples per pixel.
const PIXEL_SAMPLES_MAX: u32 = 1024;
/// Largest number of samples of a fully covered and lit picture; a sample takes about a hundred
/// bytes.
const PICTURE_SAMPLES_MAX: u64 = 1 << 32;
const OBJ_LIMIT_BYTES: u64 = 32 << 20;

/// Options shared by the commands that render.
#[derive(Debug, Args)]
pub struct FrameArgs {
    /// Size of a picture in pixels, each side 1 to 4096: a side, or width and height as in 640x360
    #[arg(long, value_name = "N|WxH", default_value = "256", value_parser = size)]
    pub size: PictureSize,
    /// Samples per pixel: adaptive, or 1 to 1024 in every pixel, rounded up to a power of two
    #[arg(long, value_name = "adaptive|N", default_value = "adaptive", value_parser = sampling)]
    pub samples: Sampling,
    /// Mesh: an OBJ file, or ball, sphere, torus, cube or knob
    #[arg(long, value_name = "OBJ")]
    pub mesh: Option<String>,
    /// Scene as JSON; its IES profiles and environment pictures, and the OBJ files and genomes of
    /// its objects, are read from its folder
    #[arg(long, value_name = "JSON")]
    pub scene: Option<PathBuf>,
    /// Control image that a painted material names by its hash (`brood image`): a PNG or JPEG; may
    /// be repeated
    #[arg(long = "image", value_name = "FILE")]
    pub images: Vec<PathBuf>,
    /// Replace the lights by one point light at this position, as bright as the default light
    #[arg(long, value_name = "X,Y,Z", conflicts_with = "light_deg", allow_hyphen_values = true)]
    pub light: Option<Position>,
    /// Position of the light on its circle in degrees
    #[arg(long, value_name = "DEGREES", allow_hyphen_values = true)]
    pub light_deg: Option<f64>,
    /// Exposure in EV, or `auto`
    #[arg(long, value_name = "auto|EV", allow_hyphen_values = true)]
    pub exposure: Option<ExposureWord>,
    /// Tone curve: none, reinhard or filmic
    #[arg(long, value_name = "CURVE", value_parser = tone)]
    pub tone: Option<Tone>,
    /// Evaluator: auto, cpu, gpu or reference
    #[arg(long, value_name = "BACKEND", default_value = "auto")]
    pub backend: Backend,
}

/// Position given as `x,y,z`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Position(pub [f64; 3]);

/// Exposure given as `auto` or a number.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ExposureWord(pub Exposure);

fn size(text: &str) -> Result<PictureSize, String> {
    let known = text.parse().ok().filter(|size: &PictureSize| size.longer() <= SIDE_MAX_PX);
    known.ok_or_else(|| {
        format!("must be a side such as 512, or width and height such as 640x360, each 1 to {SIDE_MAX_PX}")
    })
}

fn sampling(text: &str) -> Result<Sampling, String> {
    let known =
        text.parse().ok().filter(|sampling: &Sampling| sampling.min_rays() <= PIXEL_SAMPLES_MAX);
    known.ok_or_else(|| format!("must be adaptive or a number from 1 to {PIXEL_SAMPLES_MAX}"))
}

fn tone(text: &str) -> Result<Tone, String> {
    let known = Tone::ALL.into_iter().find(|tone| tone.name() == text);
    known.ok_or_else(|| "must be none, reinhard or filmic".to_owned())
}

impl FromStr for Position {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let numbers: Option<Vec<f64>> = text.split(',').map(|n| n.trim().parse().ok()).collect();
        numbers
            .filter(|numbers| numbers.iter().all(|n: &f64| n.is_finite()))
            .and_then(|numbers| numbers.try_into().ok())
            .map(Self)
            .ok_or_else(|| "must be three numbers, as in 1,2.5,-3".to_owned())
    }
}

impl FromStr for ExposureWord {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        if text == "auto" {
            return Ok(Self(Exposure::Auto));
        }
        let ev = text.parse().ok().filter(|ev: &f64| ev.is_finite());
        ev.map(|ev| Self(Exposure::Ev(ev))).ok_or_else(|| "must be auto or a number".into())
    }
}

impl FrameArgs {
    /// Loads the scene, its light assets and the mesh.
    pub fn load(
        &self,
        renderer: &Renderer,
        format: PictureFormat,
    ) -> Result<(Frame, Arc<LoadedMesh>)> {
        let mut scene = self.read_scene()?;
        let folder = self.scene.as_deref().and_then(Path::parent).unwrap_or(Path::new(""));
        let mut assets = light_file::read(&scene, folder)?;
        for path in &self.images {
            let (hash, image) = image_file::read(path)?;
            assets.insert_image(hash.to_string(), Arc::new(image));
        }
        renderer.set_light_assets(assets);
        self.check_memory(&scene)?;
        if let Some(name) = &self.mesh {
            scene.mesh = match BuiltinMesh::from_name(name) {
                Some(mesh) => MeshRef::Builtin(mesh),
                None => MeshRef::Uploaded("file".to_owned()),
            };
            scene.validate().context("the scene does not fit --mesh")?;
        }
        let (mesh, source) = match (&self.mesh, scene.builtin()) {
            (_, Some(mesh)) => (renderer.builtin(mesh), MeshSource::Builtin),
            (Some(file), None) => {
                let mesh = read_obj(Path::new(file))?;
                let source = MeshSource::Uploaded(*mesh.hash());
                (Arc::new(mesh), source)
            }
            (None, None) => {
                bail!("the scene uses an uploaded mesh; give its OBJ file with --mesh")
            }
        };
        let how = (format, self.backend);
        let objects = object_file::read(&scene, folder, renderer)?;
        let frame = Frame::new(&scene, source, self.size, self.samples, how);
        Ok((frame.with_objects(objects), mesh))
    }

    /// As [`FrameArgs::load`], for commands that see only the object with the material.
    ///
    /// # Errors
    /// Also if the scene has other objects or a ground.
    pub fn load_alone(
        &self,
        renderer: &Renderer,
        format: PictureFormat,
    ) -> Result<(Frame, Arc<LoadedMesh>)> {
        let (frame, mesh) = self.load(renderer, format)?;
        ensure!(
            frame.objects.is_empty(),
            "this command needs a scene without other objects and without ground"
        );
        Ok((frame, mesh))
    }

    /// Returns an error if the picture could need more memory than machines have.
    fn check_memory(&self, scene: &Scene) -> Result<()> {
        let samples = self.size.pixels()
            * u64::from(self.samples.min_rays())
            * u64::from(scene.light_samples());
        ensure!(
            samples <= PICTURE_SAMPLES_MAX,
            "this picture may need {samples} samples, at most {PICTURE_SAMPLES_MAX} are possible: reduce --size, --samples or \
             the samples of the lights"
        );
        Ok(())
    }

    fn read_scene(&self) -> Result<Scene> {
        let mut scene = match &self.scene {
            None => Scene::default(),
            Some(path) => {
                let bytes = read_file(path, SCENE_LIMIT_BYTES)?;
                serde_json::from_slice(&bytes).with_context(|| path.display().to_string())?
            }
        };
        if let Some(Position(position)) = self.light {
            scene.lights = vec![Light::point_at(position)];
        }
        if let Some(degrees) = self.light_deg {
            scene = scene.with_light_deg(degrees);
        }
        if let Some(ExposureWord(exposure)) = self.exposure {
            scene.film.exposure = exposure;
        }
        if let Some(tone) = self.tone {
            scene.film.tone = tone;
        }
        scene.validate().context("the scene is invalid")?;
        Ok(scene)
    }
}

/// Reads an OBJ file; prints the reader's warnings on stderr.
pub fn read_obj(path: &Path) -> Result<LoadedMesh> {
    let bytes = read_file(path, OBJ_LIMIT_BYTES)?;
    let file =
        parse_obj(&bytes, &ObjLimits::default()).with_context(|| path.display().to_string())?;
    for warning in &file.warnings {
        eprintln!("warning: {}: line {}: {}", path.display(), warning.line, warning.text);
    }
    Ok(LoadedMesh::new(file.mesh))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn position_is_three_finite_numbers() {
        assert_eq!("1, 2.5,-3".parse(), Ok(Position([1.0, 2.5, -3.0])));
        for text in ["", "1,2", "1,2,3,4", "1,2,x", "1,2,inf", "nan,0,0"] {
            assert!(text.parse::<Position>().is_err(), "{text}");
        }
    }

    #[test]
    fn size_is_a_side_or_width_and_height() {
        assert_eq!(size("4096"), Ok(4096.into()));
        assert_eq!(size("640x1"), Ok(PictureSize { width: 640, height: 1 }));
        for text in ["0", "4097", "640x0", "1x4097", "640x", "640,360", "1x2x3", ""] {
            assert!(size(text).is_err(), "{text}");
        }
    }

    #[test]
    fn samples_are_adaptive_or_a_number() {
        assert_eq!(sampling("adaptive"), Ok(Sampling::Adaptive));
        assert_eq!(sampling("1024"), Ok(Sampling::Fixed(1024)));
        for text in ["0", "1025", "auto", "1.5", ""] {
            assert!(sampling(text).is_err(), "{text}");
        }
    }

    #[test]
    fn exposure_is_auto_or_a_finite_number() {
        assert_eq!("auto".parse(), Ok(ExposureWord(Exposure::Auto)));
        assert_eq!("-1.5".parse(), Ok(ExposureWord(Exposure::Ev(-1.5))));
        assert!("bright".parse::<ExposureWord>().is_err());
        assert!("inf".parse::<ExposureWord>().is_err());
    }
}
