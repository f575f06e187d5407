//! The worker: claims jobs from a server, renders them, hands the pictures back.
//!
//! This crate owns the choice of the evaluator, the caches of meshes, sample sets and programs, and the claim loop with
//! its heartbeats. It refuses to know tables and routes: everything it learns comes through the lease protocol. The
//! [`Renderer`] works without a server as well.
//!
//! ```
//! use brood_genome::{BirthKey, Dialect, Variation};
//! use brood_program::Program;
//! use brood_protocol::{Backend, Frame, MeshSource, PictureFormat};
//! use brood_scene::{BuiltinMesh, Scene};
//! use brood_worker::Renderer;
//!
//! let genome = Variation::random(Dialect::default()).birth(BirthKey { seed: 1, slot: 0, attempt: 0 });
//! let program = Program::lower(&genome);
//! let renderer = Renderer::new(Backend::Cpu);
//! let mesh = renderer.builtin(BuiltinMesh::Sphere);
//! let how = (PictureFormat::Png, Backend::Cpu);
//! let frame = Frame::new(&Scene::default(), MeshSource::Builtin, 32, 1, how);
//! let pictures = renderer.render(&frame, &mesh, &[&program]).unwrap();
//! assert!(pictures[0].bytes.starts_with(b"\x89PNG"));
//! ```

mod backoff;
mod beside;
mod cache;
mod claim;
mod comparison;
mod evaluator;
mod gpu;
mod job;
mod lamp;
mod render_thread;
mod renderer;
mod search;
mod search_run;
mod shot;
mod tally;

#[cfg(test)]
mod claim_tests;

pub use beside::Beside;
pub use cache::LoadedMesh;
pub use claim::{WorkerConfig, WorkerError, run};
pub use renderer::{RenderError, Renderer};
pub use search::{SearcherConfig, run_searches};
