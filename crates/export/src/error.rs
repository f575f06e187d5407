//! Error of exports.

use brood_brdf::Input;

use crate::format::Format;

/// Reason why a material is not exported in a format.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum PrintError {
    /// The number of lights is out of range.
    #[error("lights must be 1 to {most}, got {0}", most = Input::LIGHTS)]
    Lights(usize),
    /// The format is of painted materials.
    #[error("{} is a format of painted materials", .0.name())]
    NotPainted(Format),
    /// The format is of BRDFs.
    #[error(
        "{} is a format of BRDFs: a painted material has colours as a display shows them, not a \
         reflectance",
        .0.name()
    )]
    Painted(Format),
    /// The material has control images.
    #[error(
        "a painted material with control images is not exported: the formats have no textures; \
         remove its images to export it"
    )]
    Images,
    /// The format has one normal, and the genome has bumps.
    #[error(
        "{} has no bumps, which turn the normal from place to place; without its bumps, the \
         material is exported",
        .0.name()
    )]
    Bumps(Format),
    /// MERL's tables are isotropic.
    #[error(
        "merl is a format of isotropic BRDFs, and this one changes when the surface turns about \
         its normal; rgl-bsdf has anisotropic ones"
    )]
    Anisotropic,
    /// The format is of programs, and the material is measured.
    #[error(
        "{} is a format of genomes; a measured material is exported as {}",
        .0.name(),
        tables()
    )]
    Measured(Format),
    /// The light amount is a picture of a BRDF.
    #[error(
        "a painted material `by brdf` is not exported: its amount of light is a picture of its \
         BRDF, not a function of a point; without its effects, the BRDF is"
    )]
    ByBrdf,
    /// The toon material lacks something that the style has.
    #[error("VRM's toon material has {0}")]
    Mtoon(&'static str),
}

/// Names of the formats of measured materials.
fn tables() -> String {
    let tables = Format::ALL.into_iter().filter(|format| format.is_table());
    tables.map(Format::name).collect::<Vec<_>>().join(", ")
}
