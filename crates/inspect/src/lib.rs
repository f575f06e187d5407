//! What a genome is: its source with what is dead marked, its scalar code, counts, physical checks, how much it reflects,
//! and its reflectance over a plane and over the half-angle square.
//!
//! This crate owns the words and figures of an inspection, the same on the command line, over HTTP and on the page. It
//! refuses to know where genomes are kept. Figures are those of the canonical evaluator.

mod energy;
mod evaluate;
mod listing;
mod physics;
mod plane;
mod report;
mod slice;

pub use energy::Energy;
pub use listing::{marked_source, scalar_code};
pub use physics::Physics;
pub use plane::{Curve, Plane, planes};
pub use report::{Inspection, OperationCounts, inspect};
pub use slice::{Slice, image_slice};
