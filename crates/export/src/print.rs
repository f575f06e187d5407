//! Any export of any material: chooses the printer, and refuses what a format cannot carry.

use brood_brdf::{Brdf, Input};
use brood_eval::express;
use brood_genome::{Genome, RANGE};
use brood_program::{Meaning, Program};

use crate::error::PrintError;
use crate::exported::Exported;
use crate::format::Format;
use crate::module::export_within;
use crate::{disney, fit, godot, materialx, mitsuba, mtoon, style, table, three};

/// Ranges that exported code must handle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Within {
    /// Largest absolute texture coordinate, 0 to 65504. Clamps that cannot act are left out.
    pub uv: f32,
    /// Number of lights of a painted material, 1 to 8. BRDFs have one.
    pub lights: usize,
}

impl Default for Within {
    fn default() -> Self {
        Self { uv: RANGE, lights: 1 }
    }
}

/// Returns a material in a format: a module with the function `evolved` of a BRDF
/// ([`export_within`](crate::export_within)) or `styled` of a painted material, parameters of
/// another material, or a table of f.
///
/// `styled(at, lights)` is the colour of a point as a display shows it. It takes a structure of the
/// point and an array of `within.lights` structures of lights, both described in the module. With
/// glass it is `styled(at, lights, glass)`, where the last structure is what rays see in the body,
/// and `styled_body(at, lights)` is the colour without glass.
///
/// # Errors
/// Returns [`PrintError`] if the format cannot carry the material.
pub fn export_material(
    program: &Program,
    format: Format,
    within: Within,
) -> Result<Exported, PrintError> {
    check_material(program, format, within)?;
    let is_brdf = is_brdf(program);
    match (format, program.meaning()) {
        (_, Meaning::Style(effects)) if format == Format::Mtoon => {
            Ok(mtoon::material(program, effects)?.into())
        }
        (Format::DisneyBrdf, _) => Ok(disney::file(program, within.uv).into()),
        (Format::ThreePage, _) => Ok(three::page(program, within.uv).into()),
        (Format::ThreeTsl, _) => Ok(three::module(program, within.uv).into()),
        (Format::Godot3, _) => Ok(godot::shader(program, within.uv).into()),
        (Format::MaterialX, _) => Ok(materialx::archive(program, within.uv)),
        (Format::Mitsuba, _) => Ok(mitsuba::plugin(program, within.uv).into()),
        _ if format.is_table() => table::of_program(program, format),
        _ if format.is_fit() => fit::of_program(program, format),
        _ if is_brdf => Ok(export_within(program, format, within.uv).into()),
        _ => Ok(style::module(program, format, (within.uv, within.lights)).into()),
    }
}

/// Returns a genome in a format, as [`export_material`], under the energy limit if [`is_limited`].
///
/// # Errors
/// Returns [`PrintError`] if the format cannot carry the material.
pub fn export_genome(
    genome: &Genome,
    format: Format,
    energy_limit: Option<bool>,
    within: Within,
) -> Result<Exported, PrintError> {
    let limited = is_limited(format, energy_limit, genome);
    export_material(&express(&genome.clone().with_limit(limited)), format, within)
}

/// Checks that a format can carry a material, without exporting it where that takes long.
///
/// # Errors
/// As [`export_material`].
pub fn check_material(program: &Program, format: Format, within: Within) -> Result<(), PrintError> {
    check_common(program, within)?;
    match (format, program.meaning()) {
        (Format::Mtoon, Meaning::Style(effects)) => mtoon::material(program, effects).map(drop),
        (Format::Mtoon, _) => Err(PrintError::NotPainted(format)),
        _ if !is_brdf(program) && format.language().is_none() => Err(PrintError::Painted(format)),
        _ if format.is_table() || format.is_fit() => table::check(program, format),
        _ => Ok(()),
    }
}

/// Returns a measured material in a format of tables.
///
/// # Errors
/// Returns [`PrintError`] if the format is not of tables, or cannot carry the material.
pub fn export_measured(brdf: &dyn Brdf, format: Format) -> Result<Exported, PrintError> {
    table::of_measured(brdf, format)
}

/// Errors of all formats.
fn check_common(program: &Program, within: Within) -> Result<(), PrintError> {
    if !(1..=Input::LIGHTS).contains(&within.lights) {
        return Err(PrintError::Lights(within.lights));
    }
    if program.is_by_brdf() {
        return Err(PrintError::ByBrdf);
    }
    if !program.images().is_empty() {
        return Err(PrintError::Images);
    }
    Ok(())
}

fn is_brdf(program: &Program) -> bool {
    matches!(program.meaning(), Meaning::Reflectance)
}

/// True if the energy limit is applied to an exported genome: as chosen, or where path tracers read
/// the format, or as the genome says.
#[must_use]
pub fn is_limited(format: Format, chosen: Option<bool>, genome: &Genome) -> bool {
    chosen.unwrap_or(genome.is_limited() || format.is_for_path_tracers())
}
