//! Analysis of one material and comparison of several, for the command line, the API and the page.
//!
//! [`inspect`] returns the source of a genome with its dead code, its scalar code, operation
//! counts, physical checks, largest albedo, and reflectance over planes of incidence;
//! [`image_slice`] draws its reflectance over half and difference angle. [`curves`], [`Phenomena`]
//! and [`LinearImage`] compare materials and their pictures. [`Shot`] renders any material, also a
//! measured one. Values of genomes come from the canonical evaluator, those of measured materials
//! from [`brood_eval::model_reflectance`]. The crate does not depend on storage or jobs.
//!
//! ```
//! let text = "brood 1\n.dialect paper smooth registers 7\n.const C0 0.5 0.5 0.5 0\nMOV R0, C0\n";
//! let report = brood_inspect::inspect(&text.parse().expect("the text is a genome"));
//! assert_eq!(report.physics.max_f, 0.25); // the square of the result
//! assert_eq!(report.live, [true]);
//! ```

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
    COMPARED, CurvePoint, Exposures, HdrFlip, LightOrbit, LinearImage, LinearImageError,
    OTHER_LIGHT_DEG, Phenomena, Specimen, curves, flip, luminance,
};
pub use energy::Energy;
pub use listing::{marked_source, scalar_code};
pub use physics::Physics;
pub use plane::{Curve, Plane, planes};
pub use report::{Inspection, OperationCounts, Slopes, inspect};
pub use shot::{Picture, Shade, Shot};
pub use slice::{Slice, image_slice};
