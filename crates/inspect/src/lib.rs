//! What a genome is: its source with what is dead marked, its scalar code, counts, physical checks, how much it reflects,
//! and its reflectance over a plane and over the half-angle square; and what several materials are beside each other.
//!
//! This crate owns the words and figures of an inspection and of a comparison, the same on the command line, over HTTP and on
//! the page, and pictures of what is no program. It refuses to know where genomes are kept and who renders the pictures of a brood.
//! Figures are those of the canonical evaluator.

mod compare;
mod energy;
mod evaluate;
mod listing;
mod physics;
mod plane;
mod report;
mod shot;
mod slice;

pub use compare::{
    COMPARED, CurvePoint, LightCircle, LinearImage, LinearImageError, OTHER_LIGHT_DEG, Phenomena,
    Specimen, curves, luminance,
};
pub use energy::Energy;
pub use listing::{marked_source, scalar_code};
pub use physics::Physics;
pub use plane::{Curve, Plane, planes};
pub use report::{Inspection, OperationCounts, inspect};
pub use shot::{Picture, Shade, Shot};
pub use slice::{Slice, image_slice};
