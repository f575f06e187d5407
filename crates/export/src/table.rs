//! Tables of f: RGL's `.bsdf`, MERL's `.binary`, and samples as CSV.
//!
//! They are made from anything that has f for pairs of directions: a program, or a measured BRDF.
//! A table has a resolution, so each is compared with f at other pairs, by brood's own reader.

mod deviation;
mod merl;
mod rgl;
mod samples;
mod source;
mod tensor;

pub use samples::samples_csv;
pub use source::mean_positions;

use brood_brdf::Brdf;
use brood_eval::is_anisotropic;
use brood_program::Program;

use crate::error::PrintError;
use crate::exported::Exported;
use crate::format::Format;
pub(crate) use deviation::Deviation;
pub(crate) use source::{Source, Symmetry};

/// Error if a BRDF's program has no table or fit in a format.
pub(crate) fn check(program: &Program, format: Format) -> Result<(), PrintError> {
    if program.bumps().is_some() {
        return Err(PrintError::Bumps(format));
    }
    match format {
        Format::Merl if is_anisotropic(program) => Err(PrintError::Anisotropic),
        _ => Ok(()),
    }
}

/// Makes the table of a BRDF's program. The format is one of tables.
pub(crate) fn of_program(program: &Program, format: Format) -> Result<Exported, PrintError> {
    check(program, format)?;
    Ok(made(&Source::of_program(program), format))
}

/// Makes the table of a measured BRDF, if the format is one of tables.
pub(crate) fn of_measured(brdf: &dyn Brdf, format: Format) -> Result<Exported, PrintError> {
    if !format.is_table() {
        return Err(PrintError::Measured(format));
    }
    let source = Source::of_measured(brdf);
    match (format, source.symmetry()) {
        (Format::Merl, Symmetry::Half | Symmetry::None) => Err(PrintError::Anisotropic),
        _ => Ok(made(&source, format)),
    }
}

fn made(source: &Source<'_>, format: Format) -> Exported {
    match format {
        Format::RglBsdf => rgl::file(source),
        Format::Merl => merl::file(source),
        _ => samples::file(source),
    }
}

#[cfg(test)]
mod tests;
