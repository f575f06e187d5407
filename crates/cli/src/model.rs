//! `brood model`: lists reflectance models, prints them and measures their directional albedo.

use std::fmt::Write;
use std::path::PathBuf;

use anyhow::{Context, Result};
use brood_bench::material_file::{self, MaterialFile};
use brood_bench::output;
use brood_brdf::{
    Brdf, Claims, Model, ModelKind, Parameter, ParameterKind, ParameterScale, model_presets,
};
use brood_eval::{
    EnergyLimit, Quadrature, channel_albedos, direction_at, direction_pair, energy_limit, express,
};
use brood_genome::{Genome, Output};
use brood_program::Program;
use clap::{Args, Subcommand};
use serde_json::{Value, json};

use crate::gallery::{self, GalleryArgs};

/// Subcommands of `brood model`.
#[derive(Debug, Subcommand)]
pub enum ModelCommand {
    /// List the models and the known substances
    List,
    /// Print a model, or a known substance, as a file to edit
    Show {
        /// Name from `brood model list`
        name: String,
    },
    /// Print the directional albedo of a material at several angles of incidence
    Albedo(AlbedoArgs),
    /// Render all models, layers and lights, with a page of captions
    Gallery(GalleryArgs),
}

/// Options of `brood model albedo`.
#[derive(Debug, Args)]
pub struct AlbedoArgs {
    /// Material: a `.brood` or JSON file of a genome or a model, a MERL `.binary`, an RGL `.bsdf`,
    /// samples as `.csv`, a goniometer's `.brdf`, or an image slice as `.exr`; - is stdin
    file: PathBuf,
    /// Order of the quadrature: N rings of directions with 2N azimuths each
    #[arg(long, value_name = "N", default_value_t = 128, value_parser = clap::value_parser!(u16).range(2..=1024))]
    order: u16,
}

/// Printed angles of incidence in degrees.
const THETA_DEG: [f64; 14] =
    [0.0, 10.0, 20.0, 30.0, 40.0, 50.0, 60.0, 70.0, 80.0, 85.0, 89.0, 89.9, 89.99, 89.9999];

/// Runs the command.
pub fn run(command: &ModelCommand, json: bool) -> Result<()> {
    match command {
        ModelCommand::List => list(json),
        ModelCommand::Show { name } => show(name, json),
        ModelCommand::Albedo(args) => albedo(args, json),
        ModelCommand::Gallery(args) => gallery::run(args, json),
    }
}

fn list(json: bool) -> Result<()> {
    let presets = model_presets();
    if json {
        let substances: Vec<Value> = presets
            .iter()
            .map(|preset| json!({ "name": preset.name, "about": preset.about, "model": preset.model.kind().name() }))
            .collect();
        let models: Vec<Value> = ModelKind::ALL.into_iter().map(kind_json).collect();
        return output::print_json(&json!({ "models": models, "substances": substances }));
    }
    let width = ModelKind::ALL.map(|kind| kind.name().len()).into_iter().max().unwrap_or(0);
    let mut text = String::new();
    for kind in ModelKind::ALL {
        writeln!(text, "{:width$}  {}", kind.name(), kind.about())?;
    }
    text += "\nsubstances\n\n";
    for preset in &presets {
        writeln!(text, "{:width$}  {}, a {}", preset.name, preset.about, preset.model.kind())?;
    }
    output::print(&text)
}

fn show(name: &str, json: bool) -> Result<()> {
    let substance = model_presets().into_iter().find(|preset| preset.name == name);
    let model = match substance {
        Some(preset) => preset.model,
        None => Model::new(name.parse().context("run `brood model list` for all names")?),
    };
    let kind = model.kind();
    let plain = Genome::of_models(vec![model])?.to_string();
    if json {
        let mut found = kind_json(kind);
        found["text"] = json!(plain);
        return output::print_json(&found);
    }
    let mut text = String::new();
    let mut lines = plain.lines();
    for line in lines.by_ref().take(2) {
        writeln!(text, "{line}")?;
    }
    writeln!(text, "# {}\n# {}", kind.about(), kind.source())?;
    for (line, parameter) in lines.zip(kind.parameters()) {
        writeln!(text, "{line:<34} # {}", bounds(parameter))?;
    }
    output::print(&text)
}

/// Meaning, range and unit of a parameter, in one line.
fn bounds(parameter: &Parameter) -> String {
    let (low, high) = parameter.range;
    let range = match parameter.kind {
        ParameterKind::Choice { words } => words.join(" | "),
        ParameterKind::DisplayColor { .. } => "#000000 to #ffffff".to_owned(),
        ParameterKind::Scalar { .. } | ParameterKind::Color { .. } => format!("{low} to {high}"),
    };
    let unit =
        if parameter.unit.is_empty() { String::new() } else { format!(" {}", parameter.unit) };
    format!("{}; {range}{unit}", parameter.about)
}

fn kind_json(kind: ModelKind) -> Value {
    let parameters: Vec<Value> = kind.parameters().iter().map(parameter_json).collect();
    json!({ "name": kind.name(), "about": kind.about(), "source": kind.source(), "parameters": parameters })
}

fn parameter_json(parameter: &Parameter) -> Value {
    let (low, high) = parameter.range;
    let mut found =
        json!({ "name": parameter.name, "about": parameter.about, "unit": parameter.unit });
    match parameter.kind {
        ParameterKind::Choice { words } => found["words"] = json!(words),
        ParameterKind::Scalar { default } => found["default"] = json!(default),
        ParameterKind::Color { default } => found["default"] = json!(default),
        ParameterKind::DisplayColor { default } => found["default"] = json!(default),
    }
    if !matches!(parameter.kind, ParameterKind::Choice { .. }) {
        found["low"] = json!(low);
        found["high"] = json!(high);
        found["logarithmic"] = json!(parameter.scale == ParameterScale::Logarithmic);
    }
    found
}

fn albedo(args: &AlbedoArgs, json: bool) -> Result<()> {
    let material = material_file::read(&args.file)?;
    let program = match &material {
        MaterialFile::Bred(genome) => Some(express(genome)),
        MaterialFile::Measured(..) => None,
    };
    let order = usize::from(args.order);
    let albedo_of = |theta: f64, order: usize| match (&material, &program) {
        (MaterialFile::Measured(brdf, _), _) => {
            directional_albedo(&**brdf, theta, &Quadrature::new(order))
        }
        (MaterialFile::Bred(_), program) => {
            let program = program.as_ref().expect("a genome has been expressed");
            channel_albedos(program, theta, order)
        }
    };
    // The error is estimated by a quadrature of half the order.
    let rows = THETA_DEG.map(|theta| {
        let found = albedo_of(theta, order);
        let other = albedo_of(theta, order.div_ceil(2));
        let error = found.iter().zip(other).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        (theta, found, error)
    });
    // Under the limit, the bound is that of the unlimited program divided by it, as for `inspect`.
    let bound = match &material {
        MaterialFile::Bred(genome) => Some(limit_of(genome)),
        MaterialFile::Measured(..) => None,
    };
    let Claims { reciprocal, conserving } = claims(&material);
    if json {
        let rows: Vec<Value> = rows
            .iter()
            .map(|(theta, albedo, error)| json!({ "theta_deg": theta, "albedo": albedo, "error": error }))
            .collect();
        return output::print_json(
            &json!({ "reciprocal": reciprocal, "conserving": conserving, "rows": rows, "bound": bound.map(bound_json) }),
        );
    }
    let mut text = String::from("theta_deg,r,g,b,error\n");
    for (theta, [r, g, b], error) in rows {
        writeln!(text, "{theta},{r:.6},{g:.6},{b:.6},{error:.1e}")?;
    }
    if let Some((limit, largest)) = bound {
        writeln!(text, "# at most {largest:.6}, at {:.4} degrees", limit.theta_deg)?;
    }
    output::print(&text)
}

/// Limit of a genome without `.limit`, and the upper bound of its albedo with it.
fn limit_of(genome: &Genome) -> (EnergyLimit, f64) {
    let limit = energy_limit(&Program::lower(genome));
    let divisor = if genome.is_limited() { limit.divisor } else { 1.0 };
    (limit, limit.bound() / divisor)
}

fn bound_json((limit, largest): (EnergyLimit, f64)) -> Value {
    json!({ "max_albedo": largest, "error_bound": limit.error_bound, "theta_deg": limit.theta_deg })
}

/// Guaranteed properties: those of the model's source, or for a genome those of its layers and its
/// energy limit.
fn claims(material: &MaterialFile) -> Claims {
    match material {
        MaterialFile::Measured(brdf, _) => brdf.claims(),
        MaterialFile::Bred(genome) => {
            let of_layers: Vec<Claims> =
                genome.layers().iter().map(|model| model.brdf().claims()).collect();
            let alone = genome.instructions().is_empty() && *genome.output() == Output::IDENTITY;
            let conserving = matches!(of_layers.as_slice(), [only] if alone && only.conserving);
            Claims {
                reciprocal: of_layers.iter().all(|claims| claims.reciprocal),
                conserving: conserving || genome.is_limited(),
            }
        }
    }
}

/// Directional albedo of each channel.
fn directional_albedo(brdf: &dyn Brdf, theta_deg: f64, quadrature: &Quadrature) -> [f64; 3] {
    let (sine, cosine) = libm::sincos(theta_deg.to_radians());
    let wi = direction_at(sine, cosine, 0.0);
    let f: Vec<[f64; 3]> = quadrature
        .directions()
        .iter()
        .map(|wo| brdf.f(&direction_pair(wi, *wo)).to_array())
        .collect();
    [0, 1, 2].map(|channel| quadrature.integrate(f.iter().map(|rgb| rgb[channel])))
}
