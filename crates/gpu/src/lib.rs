//! The evaluator on graphics hardware: one interpreter compute shader for a whole brood.
//!
//! This crate owns the choice of an adapter, the shader and its encoding of programs, the cutting of work into pieces
//! that fit a device, the probe that decides whether an adapter is bit-exact, and recovery from a lost device. It is the
//! only one that knows wgpu; it refuses to know genomes as genotypes, pictures, and when a GPU is worth its while.
//!
//! ```
//! use brood_eval::Evaluator;
//! use brood_gpu::{GpuError, GpuEvaluator, GpuOptions};
//!
//! match GpuEvaluator::new(&GpuOptions::default()) {
//!     Ok(gpu) => println!("{} is exact: {}", gpu.adapter().name, gpu.is_exact()),
//!     Err(GpuError::NoAdapter) => println!("no driver, the CPU does it"),
//!     Err(error) => println!("{error}"),
//! }
//! ```

mod adapter;
mod device;
mod encode;
mod engine;
mod error;
mod evaluator;
mod pipeline;
mod plan;
mod probe;
mod shader;

pub use adapter::{AdapterReport, Contraction, GpuOptions};
pub use error::GpuError;
pub use evaluator::GpuEvaluator;
