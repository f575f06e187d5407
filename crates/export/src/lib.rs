//! Export of materials for other renderers: shader source code (GLSL and WGSL), plugins, tables.
//!
//! [`export`] prints a module for a BRDF's `brood_program::Program` in a [`Format`],
//! [`export_material`] makes any export of any material: painted ones become a function `styled`.
//! [`export_measured`] makes tables of measured materials. [`conformance`] has
//! test cases and error bounds for backends that run exported models. The crate does not depend on
//! files or routes.
//!
//! The printed code computes the same bits as the canonical evaluator, given the same inputs and a
//! compiler that rounds each operation. Inputs are computed from directions in f32 by the printed
//! code, in f64 by the evaluator. Models are computed in f32 by the printed code, in f64 by the
//! evaluator, so they agree only to rounding.
//!
//! ```
//! use brood_export::{Format, export};
//! use brood_genome::Genome;
//! use brood_program::Program;
//!
//! let text = "brood 1\n.dialect paper smooth registers 7\nSIN R0.xy, R0.x\n";
//! let genome: Genome = text.parse().unwrap();
//! let module = export(&Program::lower(&genome), Format::GlslEs300);
//! assert!(module.contains("vec3 evolved(vec3 wi, vec3 wo, vec3 n, vec3 x, vec3 y, vec2 uv)"));
//! ```

mod about;
mod body;
pub mod conformance;
mod disney;
mod error;
mod exported;
mod fit;
mod format;
mod godot;
mod input;
mod language;
mod library;
mod materialx;
mod mitsuba;
mod model;
mod module;
mod mtoon;
mod print;
mod python;
mod reflectance;
mod sampling;
mod source;
mod style;
mod table;
mod three;

pub use about::Exactness;
pub use error::PrintError;
pub use exported::Exported;
pub use fit::fitted;
pub use format::{Format, FormatError};
pub use module::{export, export_within};
pub use print::{
    Within, check_material, export_genome, export_material, export_measured, is_limited,
};
pub use sampling::SamplingTable;
pub use table::{mean_positions, samples_csv};
