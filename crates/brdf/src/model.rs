//! Classical and physical models of reflectance, with parameters that have a range, a default and a
//! source.
//!
//! A [`Model`] is a [`ModelKind`] with values for its parameters: the form of texts, mutation and
//! searches. A [`PreparedModel`] is the form that is evaluated. Independent of meshes, pictures and
//! programs.
//!
//! Dependencies between the files go one way: `constants`, `parameter` and `parameter_values`, then
//! files that several models share, then one file for each family of models, then `prepared` and
//! `kind`, which join all families, then `value`.

mod ashikhmin_shirley;
mod coat;
mod constants;
mod cook_torrance;
mod diffuse;
mod fit;
mod formula;
mod fresnel;
mod kind;
mod microfacet;
mod parameter;
mod parameter_values;
mod phong;
mod prepared;
mod preset;
mod principled;
mod reflect;
mod rough_plastic;
#[cfg(test)]
mod tests;
mod value;
mod ward;

pub use coat::{CoatTables, TableDetail};
pub use constants::{
    ClearCoatConstants, DistributionConstants, FacetConstants, MetalConstants, ModelConstants,
    PhongHighlight, PrincipledConstants, SgdChannel, Shadowing, WardForm,
};
pub use kind::{ModelKind, UnknownModel};
pub use parameter::{Parameter, ParameterKind, ParameterScale};
pub use parameter_values::{
    ParameterError, ParameterTextError, ParameterValues, ParameterValuesError, display_codes,
};
pub use prepared::PreparedModel;
pub use preset::{ModelPreset, model_presets};
pub use value::Model;
