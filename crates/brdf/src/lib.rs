//! Directions in the local frame, the reciprocal inputs that evolved programs read, and models of reflectance.
//!
//! This crate owns the mathematics of a pair of directions: what an [`Input`] is worth for it, why swapping the two
//! directions never changes that worth, and what classical and physical models make of it. It refuses to know meshes,
//! programs, images and files.
//!
//! ```
//! use brood_brdf::{DirectionPair, Input};
//! use glam::{DVec2, DVec3};
//!
//! let pair = DirectionPair::new(DVec3::new(0.6, 0.0, 0.8), DVec3::new(0.0, 0.6, 0.8)).unwrap();
//! for input in Input::ALL {
//!     assert_eq!(input.evaluate(&pair, DVec2::ZERO), input.evaluate(&pair.swapped(), DVec2::ZERO));
//! }
//! ```

mod block;
mod direction;
mod elementary;
mod input;
mod measured;
mod model;
mod swapped;

pub use block::{Block, HORIZON, Loop, Machine, Plain};
pub use direction::{DirectionError, DirectionPair};
pub use elementary::{Branchless, Elementary, Libm};
pub use input::{Input, InputMask, Parametrisation};
pub use measured::{
    CsvError, GoniometerError, Merl, MerlError, Neural, NeuralError, Rgl, RglError, SampleError,
    Samples, Scattered, Slice, SliceError, TensorError,
};
pub use model::{
    Brdf, Claims, ClearCoatConstants, CoatTables, DistributionConstants, FacetConstants,
    MetalConstants, Model, ModelConstants, ModelKind, ModelPreset, NumbersError, Parameter,
    ParameterError, ParameterTextError, PhongHighlight, PreparedModel, PrincipledConstants, Scale,
    SgdChannel, Shadowing, Shape, TableDetail, UnknownModel, WardForm, model_presets,
};
pub use swapped::Swapped;
