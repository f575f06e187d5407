//! Contents of the gallery: every model by itself, layers over each other and over a program, one
//! material under every kind of light.

use std::sync::Arc;

use anyhow::{Context, Result, ensure};
use brood_brdf::{Model, ModelKind, model_presets};
use brood_genome::Genome;
use brood_genome::preset::PRESETS;
use brood_light::{EnvironmentMap, IesProfile, LightAssets};
use brood_scene::Scene;
use serde_json::{Value, json};

/// Pictures under one heading.
pub struct Section {
    pub title: &'static str,
    pub words: &'static str,
    pub exhibits: Vec<Exhibit>,
}

/// A picture and its caption.
pub struct Exhibit {
    pub name: String,
    pub about: String,
    /// Citation; may be empty.
    pub source: String,
    /// Parameters, one per line.
    pub lines: Vec<String>,
    pub genome: Genome,
    pub scene: Scene,
    pub assets: LightAssets,
}

impl Exhibit {
    /// File name of the picture.
    pub fn file(&self) -> String {
        format!("{}.png", self.name)
    }
}

/// IES profile: a beam of some 40 degrees and a weaker glow to the sides.
const LAMP: &str = "TILT=NONE\n1 -1 1 5 1 1 2 0 0 0\n1 1 60\n0 15 30 60 90\n0\n100 90 35 12 0\n";
/// Thin varnish.
const VARNISH: &str = ".model cook-torrance\ndiffuse 0 0 0\nf0 0.04 0.04 0.04\nroughness 0.06\n";
/// Parameters that hold the body colour.
const BODY_PARAMETERS: [&str; 4] = ["albedo", "base_color", "diffuse", "rho_d"];
/// Body colour of all models.
const BODY_COLOR: [f64; 3] = [0.5, 0.16, 0.09];
/// Preset shown under the lights.
const UNDER_LIGHTS: &str = "model-plastic";

/// All sections in order.
pub fn sections() -> Result<Vec<Section>> {
    Ok(vec![
        Section {
            title: "Models",
            words: "Each with its default parameters except for the body colour; on the ball in the built-in studio, under a\n\
                    lamp.",
            exhibits: ModelKind::ALL.into_iter().map(model).collect::<Result<_>>()?,
        },
        Section {
            title: "Substances",
            words: "Known reflectances at normal incidence, in the model of Cook and Torrance: `brood model show gold`.",
            exhibits: model_presets()
                .into_iter()
                .map(|preset| {
                    let about = format!("{}, a {}", preset.about, preset.model.kind());
                    exhibit(preset.name, about, "", Genome::of_models(vec![preset.model])?)
                })
                .collect::<Result<_>>()?,
        },
        Section {
            title: "Layers",
            words: "Up to four models over each other or over a bred program; what they reflect is added.",
            exhibits: vec![
                layered("model-two-layers", "wood under varnish: three models", "")?,
                layered("model-car-paint", "car paint", "")?,
                layered(
                    "marble",
                    "a program, polished stone, under a model, a thin varnish",
                    VARNISH,
                )?,
                layered("matt-clay", "a program, terracotta, glazed by a model", VARNISH)?,
            ],
        },
        Section {
            title: "Lights",
            words: "One plastic under each [kind of light](maths/lights.md), with shadows.",
            exhibits: lights()?,
        },
    ])
}

/// Returns an exhibit on the ball in the studio, under a lamp.
fn exhibit(name: &str, about: String, source: &str, genome: Genome) -> Result<Exhibit> {
    let text = genome.to_string();
    let of_model = |line: &&str| line.starts_with(".model") || line.starts_with(char::is_lowercase);
    let lines = text.lines().skip(1).filter(of_model).map(str::to_owned).collect();
    let (name, source) = (name.to_owned(), source.to_owned());
    let scene = serde_json::from_value(json!({ "mesh": "ball", "lights": [
        { "kind": "point" },
        { "kind": "environment", "image": "studio" },
    ] }))?;
    let assets = LightAssets::default();
    Ok(Exhibit { name, about, source, lines, genome, scene, assets })
}

/// Returns the exhibit of a model with its default parameters, except for the body colour.
fn model(kind: ModelKind) -> Result<Exhibit> {
    let mut model = Model::new(kind);
    for name in BODY_PARAMETERS {
        if model.get(name).is_some_and(|body| body.iter().any(|channel| *channel > 0.0)) {
            model = model.with(name, &BODY_COLOR)?;
        }
    }
    let genome = Genome::of_models(vec![model])?;
    exhibit(kind.name(), kind.about().to_owned(), kind.source(), genome)
}

/// Returns the text of a preset.
fn preset(name: &str) -> Result<&'static str> {
    let found = PRESETS.iter().find(|preset| preset.name == name);
    Ok(found.with_context(|| format!("find the preset {name}"))?.text)
}

/// Returns the exhibit of a preset, with `more` models inserted before its program.
fn layered(name: &str, about: &str, more: &str) -> Result<Exhibit> {
    let text = preset(name)?;
    let is_instruction = |line: &str| line.starts_with(|c: char| c.is_ascii_uppercase());
    let mut out = String::new();
    let mut added = false;
    for line in text.lines() {
        if is_instruction(line) && !added {
            out += more;
            added = true;
        }
        out += line;
        out.push('\n');
    }
    ensure!(added || more.is_empty(), "{name} has no program to put layers on");
    let name = if more.is_empty() { name.to_owned() } else { format!("{name}-varnished") };
    exhibit(&name, about.to_owned(), "", out.parse().with_context(|| format!("read {name}"))?)
}

/// Returns an exhibit for each kind of light.
fn lights() -> Result<Vec<Exhibit>> {
    let one = |light: Value, about: &str| {
        let genome: Genome = preset(UNDER_LIGHTS)?.parse()?;
        let kind = light["kind"].as_str().unwrap_or_default().to_owned();
        let mut exhibit_of = exhibit(&format!("light-{kind}"), about.to_owned(), "", genome)?;
        exhibit_of.lines = vec![light.to_string()];
        let scene = json!({ "mesh": "knob", "shadows": true, "lights": [light] });
        exhibit_of.scene =
            serde_json::from_value(scene).with_context(|| format!("light by {kind}"))?;
        exhibit_of.assets.insert_profile("lamp.ies", Arc::new(IesProfile::parse(LAMP.as_bytes())?));
        exhibit_of.assets.insert_environment("sky.hdr", Arc::new(sky()?));
        Ok(exhibit_of)
    };
    let place = json!([1.5, 2.5, 2.0]);
    [
        (json!({ "kind": "point" }), "a point, the same in all directions"),
        (json!({ "kind": "spot", "hotspot_deg": 8, "falloff_deg": 14 }), "a cone with a soft rim"),
        (json!({ "kind": "directional", "direction": [-1, -1, -1] }), "parallel light"),
        (json!({ "kind": "sphere", "position": place, "radius": 0.8, "samples": 32 }), "a ball: soft shadows"),
        (json!({ "kind": "disk", "position": place, "radius": 1, "samples": 32 }), "a disk, one-sided"),
        (json!({ "kind": "rectangle", "position": place, "width": 3, "height": 0.6, "samples": 32 }), "a wide panel: stretched highlights"),
        (json!({ "kind": "ies", "profile": "lamp.ies", "axis": [-0.5, -0.8, -0.6], "position": place }), "a lamp with an IES profile"),
        (json!({ "kind": "environment", "image": "sky.hdr", "samples": 128 }), "an environment picture: sky, ground and a low sun"),
        (json!({ "kind": "ambient", "samples": 64 }), "the same radiance from everywhere: with shadows, ambient occlusion"),
    ]
    .into_iter()
    .map(|(light, about)| one(light, about))
    .collect()
}

/// Sky that is blue above and pale at the horizon, with a brown ground and a sun of a few degrees.
fn sky() -> Result<EnvironmentMap> {
    const SIZE: (u16, u16) = (64, 32);
    let pixel = |(row, column): (u16, u16)| -> [f32; 3] {
        let up = 1.0 - 2.0 * (f32::from(row) + 0.5) / f32::from(SIZE.1);
        let is_sun = (7..9).contains(&row) && (44..46).contains(&column);
        match (is_sun, up > 0.0) {
            (true, _) => [180.0, 150.0, 110.0],
            (_, true) => [0.75 - 0.55 * up, 0.85 - 0.45 * up, 1.0 - 0.15 * up],
            (_, false) => [0.14, 0.11, 0.08],
        }
    };
    let places = (0..SIZE.1).flat_map(|row| (0..SIZE.0).map(move |column| (row, column)));
    let pixels = places.map(pixel).collect();
    Ok(EnvironmentMap::new(SIZE.0.into(), SIZE.1.into(), pixels)?)
}
