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
    /// The material has control images.
    #[error(
        "a painted material with control images is not exported: the formats have no textures; \
         remove its images to export it"
    )]
    Images,
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
