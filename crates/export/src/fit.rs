//! Fits: the nearest materials that other programs have, for formats that hold no code.

mod blender;
mod gltf;
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
use gltf::Preview;
use sum::Fit;

/// Makes the file of a BRDF's program. The format is one of fits.
pub(crate) fn of_program(program: &Program, format: Format) -> Result<Exported, PrintError> {
    check(program, format)?;
    let source = Source::of_program(program);
    let stem = format!("brood {}", &program.hash().to_string()[..8]);
    let note = |fit: &dyn Brdf| format!("{}; {}", source.words(), Deviation::of(fit, &source));
    let (bytes, note) = if format == Format::Gltf {
        let preview = Preview::of(&source);
        let note = note(&preview);
        (preview.file(&stem, &note), note)
    } else {
        let fit = Fit::of(&source);
        let note = note(&fit);
        let text = match format {
            Format::BlenderOsl => osl::shader(&fit, &stem, &note),
            _ => blender::script(&fit, &stem, &note),
        };
        (text.into_bytes(), note)
    };
    Ok(Exported { bytes, note: Some(note) })
}

/// Returns what a format of fits holds instead of a BRDF's program.
///
/// # Errors
/// Returns [`PrintError`] if the format cannot carry the material.
pub fn fitted(program: &Program, format: Format) -> Result<Box<dyn Brdf>, PrintError> {
    check(program, format)?;
    let source = Source::of_program(program);
    Ok(match format {
        Format::Gltf => Box::new(Preview::of(&source)),
        _ => Box::new(Fit::of(&source)),
    })
}

#[cfg(test)]
mod tests;
