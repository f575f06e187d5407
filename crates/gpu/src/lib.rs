//! The evaluator on graphics hardware: one interpreter compute shader for a whole brood.
//!
//! This crate owns the choice of an adapter, the shaders and their encoding of programs, straight-line code for a program
//! that stays, sums of errors on the device, the cutting of work into pieces that fit a device, the probe that decides
//! whether an adapter is bit-exact and with which guard against contraction, and recovery from a lost device. It is the
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
mod clock;
mod device;
mod encode;
mod engine;
mod error;
mod evaluator;
#[cfg(test)]
mod export_tests;
mod fitness;
mod guard;
mod marked;
mod own;
mod pass;
mod pipeline;
mod plan;
mod probe;
mod residency;
mod shader;
mod shape;
mod slot;
mod straight;
mod sums;
mod timing;
mod tune;

pub use adapter::{AdapterReport, Contraction, GpuOptions, OwnPipelinePolicy};
pub use error::GpuError;
pub use evaluator::GpuEvaluator;
pub use fitness::GpuPopulation;
pub use guard::{Guard, Rung};
pub use shape::{RegisterFile, Shape};
pub use timing::BatchTiming;
