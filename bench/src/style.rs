//! `brood bench style`: times pictures of painted materials, in memory, on new and on known scenes,
//! and measures their errors in codes of a display.
//!
//! Two errors are separate: rounding, canonical f32 against f64 with the same sampling; and
//! sampling, the default sampling against many points per pixel.

use std::sync::Arc;
use std::time::Instant;

use anyhow::{Context, Result};
use brood_eval::Developed;
use brood_genome::preset::Preset;
use brood_genome::{
    BirthKey, Effect, EffectImage, EffectKind, Genome, ImageHash, Start, Variation,
};
use brood_light::{ImagePyramid, LightAssets};
use brood_mesh::BuiltinMesh;
use brood_program::Program;
use brood_protocol::{Backend, Frame, MeshSource, ObjectSource, PictureFormat};
use brood_scene::{Sampling, Scene};
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
/// Side of the images of materials and scenes in pixels, and their name in scenes.
const IMAGE_PX: u32 = 256;
const IMAGE: &str = "image";

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

/// Kind of painted materials.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
enum Kind {
    /// Random ones.
    Random,
    /// Random believable BRDFs, painted (`by brdf`).
    Toon,
    /// Random ones with images as dark and bright colour and as maps of overlays.
    Images,
    /// Random ones with a clear body.
    Glass,
}

/// Times and errors of one kind of materials in one scene.
#[derive(Debug, Serialize)]
struct Row {
    scene: &'static str,
    materials: Kind,
    threads: usize,
    /// First material at 256 px, with the points of a new scene; mesh and tracer are known.
    new_scene_256_ms: Figures,
    /// Another material at 256 px, without PNG.
    further_256_ms: Figures,
    /// Another material at 256 px, with PNG.
    further_256_png_ms: Figures,
    /// 21 other materials at 128 px on known points, with PNG.
    brood_128_ms: Figures,
    /// f32 against f64 with the same sampling, at 256 px.
    rounding: Errors,
    /// Default sampling against many points per pixel, at 128 px.
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
    let rows =
        settings()?.iter().map(|setting| setting.measure(args)).collect::<Result<Vec<Row>>>()?;
    let head = format!(
        "{:<10} {:<10} {:>18} {:>16} {:>16} {:>18}   rounding and sampling: rms, largest, % over 8 codes\n",
        "scene",
        "materials",
        "new at 256 px, ms",
        "further, ms",
        "with PNG, ms",
        "21 at 128 px, ms"
    );
    let line = |row: &Row| {
        let ms = |figures: &Figures| format!("{:.1} ({:.1})", figures.median, figures.min);
        let errors = |of: &Errors| format!("{:.3} {} {:.2}", of.rms, of.largest, of.over_8_percent);
        format!(
            "{:<10} {:<10} {:>18} {:>16} {:>16} {:>18}   {}; {}\n",
            row.scene,
            format!("{:?}", row.materials).to_lowercase(),
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

/// Scene of the knob and a kind of materials.
struct Setting {
    name: &'static str,
    scene: Scene,
    kind: Kind,
}

/// A lamp; three coloured lights with shadows; a lamp in the studio; a lamp on bumps; a lamp among
/// other objects on a ground, with shadows.
fn settings() -> Result<Vec<Setting>> {
    let lamps = json!([
        {},
        {"position": [-3, 1, 2], "intensity": [6, 3, 1]},
        {"kind": "directional", "direction": [0, 1, -0.3], "irradiance_w_m2": [0.2, 0.4, 1]},
    ]);
    let studio = json!([{}, {"kind": "environment", "image": "studio"}]);
    let bumps = json!({"image": IMAGE, "strength": 0.5});
    let objects = json!([
        {"mesh": "sphere", "position": [1.1, 0, 0.6], "scale": 0.4, "stands": true, "material": "gold"},
        {"mesh": "torus", "position": [-1.2, 0, 0.5], "scale": 0.4, "stands": true, "material": "paint-cartoon"},
    ]);
    let ground = json!({"material": "paint-gouache"});
    let all = [
        ("lamp", Kind::Random, json!({"lights": [{}]})),
        ("shadows", Kind::Random, json!({"lights": lamps, "shadows": true})),
        ("studio", Kind::Random, json!({"lights": studio})),
        ("lamp", Kind::Toon, json!({"lights": [{}]})),
        ("studio", Kind::Toon, json!({"lights": studio})),
        ("lamp", Kind::Images, json!({"lights": [{}]})),
        ("bumps", Kind::Random, json!({"lights": [{}], "normal_map": bumps})),
        (
            "among",
            Kind::Random,
            json!({"lights": [{}], "shadows": true, "objects": objects, "ground": ground}),
        ),
        (
            "among",
            Kind::Glass,
            json!({"lights": [{}], "shadows": true, "objects": objects, "ground": ground}),
        ),
    ];
    let setting = |(name, kind, mut scene): (&'static str, Kind, Value)| {
        scene["mesh"] = json!(BuiltinMesh::Knob.name());
        Ok(Setting { name, kind, scene: serde_json::from_value(scene)? })
    };
    all.into_iter().map(setting).collect()
}

/// Returns waves: as colours, as brightness, and as a normal map.
fn image() -> ImagePyramid {
    let wave = |at: u32, turns: f64| {
        let phase = f64::from(at) / f64::from(IMAGE_PX) * turns * std::f64::consts::TAU;
        (127.5 + 90.0 * libm::sin(phase)).round() as u8
    };
    let pixel = |at: u32| [wave(at % IMAGE_PX, 5.0), wave(at / IMAGE_PX, 3.0), 220, u8::MAX];
    let rgba: Vec<u8> = (0..IMAGE_PX * IMAGE_PX).flat_map(pixel).collect();
    ImagePyramid::new(IMAGE_PX, IMAGE_PX, &rgba)
}

impl Setting {
    fn genomes(&self, seed: u64, count: u32) -> Result<Vec<Genome>> {
        let start = if self.kind == Kind::Toon { Start::Believable } else { Start::Painted };
        let random = Variation::random(start.dialect()).with_start(start);
        let genome = |slot| self.kind.paint(random.birth(BirthKey { seed, slot, attempt: 0 }));
        (0..count).map(genome).collect()
    }

    /// Returns a renderer that knows the meshes, their tracers and the images.
    fn renderer() -> Renderer {
        let renderer = Renderer::new(Backend::Cpu);
        use BuiltinMesh::{Ground, Knob, Sphere, Torus};
        for mesh in [Knob, Sphere, Torus, Ground] {
            let _ = renderer.builtin(mesh).mesh().tracer();
        }
        let image = Arc::new(image());
        let mut assets = LightAssets::default();
        assets.insert_image(IMAGE, image.clone());
        assets.insert_image(ImageHash::of(IMAGE.as_bytes()).to_string(), image);
        renderer.set_light_assets(assets);
        renderer
    }

    fn frame(&self, size_px: u32, sampling: Sampling, backend: Backend) -> Result<Frame> {
        let how = (PictureFormat::Png, backend);
        let objects = self.scene.materials().map(|(material, _)| {
            let preset = material.and_then(Preset::find).context("materials are presets")?;
            let words = Program::lower(preset.genome()).to_words();
            Ok(ObjectSource { mesh: MeshSource::Builtin, words })
        });
        let frame = Frame::new(&self.scene, MeshSource::Builtin, size_px, sampling, how);
        Ok(frame.with_objects(objects.collect::<Result<_>>()?))
    }

    fn measure(&self, args: &BenchStyleArgs) -> Result<Row> {
        let frame = |size_px| self.frame(size_px, Sampling::default(), Backend::Cpu);
        let (large, small) = (frame(LARGE_PX)?, frame(BROOD_PX)?);
        let [mut new, mut further, mut png, mut brood] = [(); 4].map(|()| Vec::new());
        for round in 0..args.repeats {
            let renderer = Self::renderer();
            let mesh = renderer.builtin(BuiltinMesh::Knob);
            let genomes = self.genomes(args.common.seed.wrapping_add(round.into()), BROOD + 2)?;
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
        let styles = self.genomes(args.common.seed, args.programs)?;
        let styles: Vec<Program> = styles.iter().map(Program::lower).collect();
        Ok(Row {
            scene: self.name,
            materials: self.kind,
            threads: rayon::current_num_threads(),
            new_scene_256_ms: figures(&new),
            further_256_ms: figures(&further),
            further_256_png_ms: figures(&png),
            brood_128_ms: figures(&brood),
            rounding: self.rounding(&styles)?,
            sampling: self.sampling(&styles, args.samples)?,
        })
    }

    fn pictures(&self, frame: &Frame, styles: &[Program]) -> Result<Vec<Developed>> {
        let renderer = Self::renderer();
        let mesh = renderer.builtin(BuiltinMesh::Knob);
        let all: Vec<&Program> = styles.iter().collect();
        renderer.develop(frame, &mesh, &all).context("render")
    }

    /// Canonical f32 against f64 with the default sampling.
    fn rounding(&self, styles: &[Program]) -> Result<Errors> {
        let of =
            |backend| self.pictures(&self.frame(LARGE_PX, Sampling::default(), backend)?, styles);
        Ok(errors(&of(Backend::Cpu)?, &of(Backend::Reference)?))
    }

    /// Default sampling against `samples` points per pixel.
    fn sampling(&self, styles: &[Program], samples: u16) -> Result<Errors> {
        let of = |sampling| self.pictures(&self.frame(BROOD_PX, sampling, Backend::Cpu)?, styles);
        Ok(errors(&of(Sampling::default())?, &of(Sampling::Fixed(samples))?))
    }
}

impl Kind {
    /// Turns a random genome into one of the kind.
    fn paint(self, genome: Genome) -> Result<Genome> {
        let effects_of = |name: &str| -> Result<Vec<Effect>> {
            let preset = Preset::find(name).context("the preset exists")?;
            Ok(preset.genome().effects().to_vec())
        };
        let mut effects = genome.effects().to_vec();
        match self {
            Self::Random => {}
            Self::Toon => {
                let paint = Preset::find("paint-cartoon").context("the preset exists")?.genome();
                let key = BirthKey { seed: 0, slot: 0, attempt: 0 };
                return Ok(Variation::crossover(&genome, paint, 0.5, 0.0).birth(key));
            }
            Self::Glass => {
                let glass = effects_of("paint-glass")?;
                effects.extend(glass.into_iter().filter(|own| own.kind() == EffectKind::Glass));
            }
            Self::Images => {
                let image = ImageHash::of(IMAGE.as_bytes());
                for effect in &mut effects {
                    let places: &[&str] = match effect.kind() {
                        EffectKind::Light => &["dark", "bright"],
                        _ => &["map"],
                    };
                    let images =
                        places.iter().map(|place| EffectImage { place, image, share: 1.0 });
                    *effect = effect.clone().with_images(images.collect())?;
                }
            }
        }
        Ok(Genome::of_effects(effects)?)
    }
}

fn figures(ms: &[f64]) -> Figures {
    Figures { min: quantile(ms, 0.0), median: median(ms), p99: quantile(ms, 0.99) }
}

/// Differences of two pictures of each style, where both are wholly covered.
fn errors(ones: &[Developed], others: &[Developed]) -> Errors {
    let (mut squares, mut pixels) = (0.0, 0u64);
    let (mut largest, mut over_1, mut over_8) = (0, 0u64, 0u64);
    for (one, other) in ones.iter().zip(others) {
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
    Errors {
        rms: (squares / (3.0 * count)).sqrt(),
        largest,
        over_1_percent: 100.0 * over_1 as f64 / count,
        over_8_percent: 100.0 * over_8 as f64 / count,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_kind_is_drawn_without_visible_rounding() {
        for setting in settings().unwrap() {
            let genomes = setting.genomes(5, 2).unwrap();
            let styles: Vec<Program> = genomes.iter().map(Program::lower).collect();
            let of = |backend| {
                let frame = setting.frame(48, Sampling::default(), backend).unwrap();
                setting.pictures(&frame, &styles).unwrap()
            };
            let pictures = of(Backend::Cpu);
            let found = errors(&pictures, &of(Backend::Reference));
            assert!(found.rms < 0.2 && found.over_8_percent < 0.01, "{}: {found:?}", setting.name);
            assert_ne!(pictures[0].rgba, pictures[1].rgba);
            let is_read = styles[0].images().len();
            assert_eq!(is_read, usize::from(setting.kind == Kind::Images));
        }
    }
}
