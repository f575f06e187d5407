//! Worker: leases render jobs, searches and exports from a server, runs them and reports results.
//!
//! Render jobs run on the fastest bit-exact evaluator, which is chosen by a benchmark at the start;
//! meshes, sample sets, programs and targets are cached. [`run`] renders, [`run_searches`]
//! searches, [`run_exports`] exports, all through the lease protocol. [`run_sleepers`] loads
//! servers in benchmarks. [`Renderer`] also works without a server.
//!
//! ```
//! use brood_genome::{BirthKey, Dialect, Variation};
//! use brood_program::Program;
//! use brood_protocol::{Backend, Frame, MeshSource, PictureFormat};
//! use brood_mesh::BuiltinMesh;
//! use brood_scene::Scene;
//! use brood_worker::Renderer;
//!
//! let key = BirthKey { seed: 1, slot: 0, attempt: 0 };
//! let genome = Variation::random(Dialect::default()).birth(key);
//! let program = Program::lower(&genome);
//! let renderer = Renderer::new(Backend::Cpu);
//! let mesh = renderer.builtin(BuiltinMesh::Sphere);
//! let output = (PictureFormat::Png, Backend::Cpu);
//! let frame = Frame::new(&Scene::default(), MeshSource::Builtin, 32, 1, output);
//! let pictures = renderer.render(&frame, &mesh, &[&program]).unwrap();
//! assert!(pictures[0].bytes.starts_with(b"\x89PNG"));
//! ```

mod backoff;
mod banded_picture;
mod bounded_cache;
mod cache;
mod claim;
mod encoded_picture;
mod error;
mod evaluated_picture;
mod evaluator;
mod export;
mod glass;
mod gpu;
mod gpu_benchmark;
mod image_inputs;
mod job;
mod job_control;
mod lease;
mod light_asset_cache;
mod lit_spheres;
mod painted_picture;
mod reflected_picture;
mod render_counters;
mod render_thread;
mod render_worker;
mod renderer;
mod scene_view;
mod search;
mod search_run;
mod search_target;
mod shot;
mod sight;
mod sleeper;
mod spread_picture;
mod subject;
mod surroundings;
mod target_cache;
mod view_comparison;

#[cfg(test)]
mod claim_tests;
#[cfg(test)]
mod lease_tests;
#[cfg(test)]
mod renderer_tests;

pub use error::RenderError;
pub use export::run_exports;
pub use lease::WorkerError;
pub use render_worker::{WorkerConfig, run};
pub use renderer::Renderer;
pub use scene_view::LoadedMesh;
pub use search::{SearcherConfig, run_searches};
pub use sleeper::{SleepCounters, SleeperConfig, run_sleepers};
pub use spread_picture::{darkest_and_brightest, map_picture};
pub use view_comparison::ViewComparison;
