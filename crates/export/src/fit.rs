//! Fits: the nearest materials that other programs have, for formats that hold no code.

mod blender;
mod least;
mod lobe;
mod osl;
mod sum;
mod view;

use brood_brdf::Brdf;
use brood_program::Program;

use crate::error::PrintError;
use crate::exported::Exported;
use crate::format::Format;
use crate::table::{Deviation, Source, check};
use sum::Fit;

/// Makes the file of a BRDF's program. The format is one of fits.
pub(crate) fn of_program(program: &Program, format: Format) -> Result<Exported, PrintError> {
    check(program, format)?;
    let source = Source::of_program(program);
    let stem = format!("brood {}", &program.hash().to_string()[..8]);
    let fit = Fit::of(&source);
    let note = format!("{}; {}", source.words(), Deviation::of(&fit, &source));
    let text = match format {
        Format::BlenderOsl => osl::shader(&fit, &stem, &note),
        _ => blender::script(&fit, &stem, &note),
    };
    Ok(Exported { bytes: text.into_bytes(), note: Some(note) })
}

/// Returns what a format of fits holds instead of a BRDF's program.
///
/// # Errors
/// Returns [`PrintError`] if the format cannot carry the material.
pub fn fitted(program: &Program, format: Format) -> Result<Box<dyn Brdf>, PrintError> {
    check(program, format)?;
    Ok(Box::new(Fit::of(&Source::of_program(program))))
}

#[cfg(test)]
mod tests;
