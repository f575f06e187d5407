//! Any export of any material: chooses the printer, and refuses what a format cannot carry.

use brood_brdf::Input;
use brood_genome::RANGE;
use brood_program::{Meaning, Program};

use crate::error::PrintError;
use crate::format::Format;
use crate::module::export_within;
use crate::{mtoon, style};

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
/// ([`export_within`](crate::export_within)) or `styled` of a painted material, or parameters of
/// another material.
///
/// `styled(at, lights)` is the colour of a point as a display shows it. It takes a structure of the
/// point and an array of `within.lights` structures of lights, both described in the module. With
/// glass it is `styled(at, lights, glass)`, where the last structure is what rays see in the body,
/// and `styled_body(at, lights)` is the colour without glass.
///
/// # Errors
/// Returns [`PrintError`] if the format cannot carry the material.
pub fn print(program: &Program, format: Format, within: Within) -> Result<String, PrintError> {
    if !(1..=Input::LIGHTS).contains(&within.lights) {
        return Err(PrintError::Lights(within.lights));
    }
    if program.is_by_brdf() {
        return Err(PrintError::ByBrdf);
    }
    if !program.images().is_empty() {
        return Err(PrintError::Images);
    }
    match (format.language(), program.meaning()) {
        (Some(_), Meaning::Reflectance) => Ok(export_within(program, format, within.uv)),
        (Some(language), _) => {
            Ok(style::module(program, (format, language), (within.uv, within.lights)))
        }
        (None, Meaning::Style(effects)) => mtoon::material(program, effects),
        (None, _) => Err(PrintError::NotPainted(format)),
    }
}
