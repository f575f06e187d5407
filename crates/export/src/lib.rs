//! Exports: a program as source code that other renderers compile.
//!
//! This crate owns the printers, one road from scalar code to every language. It refuses to know genomes as such,
//! files and routes. What it prints keeps the meaning of the program, and its bits where the compiler rounds each
//! operation: inputs are computed from directions in f32 there, in f64 here, which is the only difference. Models are of
//! f32 there and of f64 here, and keep the meaning alone.
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

mod body;
pub mod conformance;
mod format;
mod input;
mod language;
mod library;
mod model;
mod module;

pub use format::{Format, FormatError};
pub use module::{export, export_within};
