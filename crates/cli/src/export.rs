//! `brood export`: writes a material for other renderers; converts measured materials.

use std::io::IsTerminal;
use std::path::PathBuf;

use anyhow::{Context, Result, bail, ensure};
use brood_bench::material_file::{self, MaterialFile};
use brood_bench::{logging, output};
use brood_brdf::Swapped;
use brood_eval::express;
use brood_export::{Exported, Format, Within, export_material, export_measured, is_limited};
use brood_target::TargetKind;
use clap::Args;
use serde_json::json;

use crate::breed::on_off;

/// Options of `brood export`.
#[derive(Debug, Args)]
pub struct ExportArgs {
    /// Genome, as a `.brood` or JSON file; - is stdin. A measured material for formats of tables:
    /// MERL .binary, RGL .bsdf, samples .csv, goniometer .brdf, image slice .exr
    material: PathBuf,
    /// Format: glsl-es-300, glsl-410, wgsl, hlsl, disney-brdf, materialx, godot-3; three-page,
    /// three-tsl (three.js); mitsuba (a plugin); rgl-bsdf, merl, samples-csv (tables); blender,
    /// blender-osl, gltf (fits); vrm-mtoon for simple painted
    /// materials
    #[arg(long, value_name = "FORMAT", default_value = "glsl-es-300")]
    format: Format,
    /// Energy limit: divide by the largest albedo if that is above 1. By default on in formats for
    /// path tracers (mitsuba, rgl-bsdf, merl, fits), in others as the genome says
    #[arg(long, value_name = "on|off", value_parser = on_off)]
    limit: Option<bool>,
    /// Number of lights of the function of a painted material, 1 to 8
    #[arg(long, value_name = "N", default_value_t = 1)]
    lights: usize,
    /// File to write; stdout by default
    #[arg(long, short, value_name = "FILE")]
    output: Option<PathBuf>,
}

/// Runs the command.
pub fn run(args: &ExportArgs, json: bool) -> Result<()> {
    logging::start_offline();
    let within = || args.material.display().to_string();
    let (exported, size) = exported(args).with_context(within)?;
    let Some(path) = &args.output else { return to_stdout(args.format, exported, json) };
    output::write_file(path, &exported.bytes)?;
    let bytes = exported.bytes.len();
    if json {
        return output::print_json(&json!({
            "format": args.format.name(), "path": path, "bytes": bytes, "note": exported.note,
        }));
    }
    let size = exported.note.unwrap_or(size);
    eprintln!("{}: {}, {size}", path.display(), args.format.label());
    Ok(())
}

/// Exports the material; also returns words about its size.
fn exported(args: &ExportArgs) -> Result<(Exported, String)> {
    match material_file::read(&args.material)? {
        MaterialFile::Bred(genome) => {
            let limited = is_limited(args.format, args.limit, &genome);
            let program = express(&genome.with_limit(limited));
            let within = Within { lights: args.lights, ..Within::default() };
            let exported = export_material(&program, args.format, within)?;
            Ok((exported, format!("{} operations", program.operations())))
        }
        MaterialFile::Measured(brdf, kind) => {
            ensure!(
                args.limit != Some(true),
                "--limit on is for genomes: a measured material is exported as it is"
            );
            let is_rgl = kind == TargetKind::Rgl.words();
            let exported = match args.format {
                // The measured incidence stays the measured incidence.
                Format::RglBsdf if is_rgl => export_measured(&Swapped(&*brdf), args.format),
                format => export_measured(&*brdf, format),
            };
            Ok((exported?, kind.to_owned()))
        }
    }
}

fn to_stdout(format: Format, exported: Exported, json: bool) -> Result<()> {
    let Exported { bytes, note } = exported;
    if format.is_binary() && (json || std::io::stdout().is_terminal()) {
        bail!("{} is binary: name a file with -o", format.name());
    }
    if json {
        let source = String::from_utf8(bytes).context("the format is text")?;
        return output::print_json(
            &json!({ "format": format.name(), "source": source, "note": note }),
        );
    }
    note.iter().for_each(|note| eprintln!("{note}"));
    output::print_bytes(&bytes)
}
