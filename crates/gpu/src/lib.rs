//! GPU evaluator: one compute shader that interprets the programs of a whole brood.
//!
//! This crate owns the choice of an adapter, the shaders and their encoding of programs,
//! straight-line shaders for single programs that are evaluated repeatedly, sums of errors on the
//! device, the division of work into dispatches of bounded time, the start-up probe that decides
//! whether an adapter is bit-exact and which guard against contraction it needs, and recovery from
//! a lost device. Its main types are [`GpuEvaluator`], [`GpuOptions`] and [`AdapterReport`]. It is
//! the only crate that uses wgpu. It does not depend on pictures, and the caller decides when a GPU
//! is worth using.
//!
//! ```
//! use brood_eval::Evaluator;
//! use brood_gpu::{GpuError, GpuEvaluator, GpuOptions};
//!
//! match GpuEvaluator::new(&GpuOptions::default()) {
//!     Ok(gpu) => println!("{} is exact: {}", gpu.adapter().name, gpu.is_exact()),
//!     Err(GpuError::NoAdapter) => println!("no driver: use the CPU"),
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
mod float_controls;
mod guard;
mod interpreter_layout;
mod marked;
mod operation;
mod own;
mod pass;
mod pipeline;
mod plan;
mod probe;
mod residency;
mod shader;
mod slot;
mod straight;
mod sums;
mod threads;
mod timing;
mod tune;

pub use adapter::{AdapterReport, Contraction, GpuOptions, OwnPipelinePolicy};
pub use error::GpuError;
pub use evaluator::GpuEvaluator;
pub use fitness::GpuPopulation;
pub use guard::{Guard, GuardReport};
pub use interpreter_layout::{InterpreterLayout, RegisterFile};
pub use timing::BatchTiming;
