//! Reflectance (BRDFs) as functions of a pair of directions in the local frame of a surface.
//!
//! - [`DirectionPair`] is a validated pair of unit directions; [`Input`] is a scalar of such a pair
//!   that evolved programs read and that does not change when the directions are swapped.
//! - [`Model`] is one of the classical and physical models ([`ModelKind`]) with values for its
//!   parameters; [`PreparedModel`] is the form that is evaluated, pair by pair through [`Brdf`] or
//!   in [`Block`]s of SIMD lanes.
//! - [`Level`] runs a [`SimdKernel`] with the widest SIMD instructions of the machine.
//! - [`Merl`], [`Rgl`], [`Neural`], [`ImageSlice`] and [`Scattered`] are measured materials, read
//!   from bytes or from samples.
//!
//! The crate does no I/O and does not depend on meshes, programs or images.
//!
//! ```
//! use brood_brdf::{DirectionPair, Input};
//! use glam::{DVec2, DVec3};
//!
//! let pair = DirectionPair::new(DVec3::new(0.6, 0.0, 0.8), DVec3::new(0.0, 0.6, 0.8)).unwrap();
//! for input in Input::symmetric() {
//!     let value = input.evaluate(&pair, DVec2::ZERO);
//!     assert_eq!(value, input.evaluate(&pair.swapped(), DVec2::ZERO));
//! }
//! ```

mod block;
mod brdf;
mod direction;
mod elementary;
mod input;
mod level;
mod measured;
mod model;
mod named_enum;
mod quadrature;
mod swapped;

pub use block::{Block, HORIZON, Loop, Machine, Plain};
pub use brdf::{Brdf, Claims};
pub use direction::{DirectionError, DirectionPair};
pub use elementary::{Branchless, Elementary, Libm};
pub use input::{Input, InputMask, LightInput, Lighting, Parametrisation};
pub use level::{Level, LevelKind, SimdKernel};
pub use measured::{
    CsvError, GoniometerError, ImageSlice, ImageSliceError, MeasuredSamples, Merl, MerlError,
    Neural, NeuralError, Rgl, RglError, SampleError, Scattered, TensorError, pairs_from_csv,
};
pub use model::{
    ClearCoatConstants, CoatTables, DistributionConstants, FacetConstants, MetalConstants, Model,
    ModelConstants, ModelKind, ModelPreset, Parameter, ParameterError, ParameterKind,
    ParameterScale, ParameterTextError, ParameterValues, ParameterValuesError, PhongHighlight,
    PreparedModel, PrincipledConstants, SgdChannel, Shadowing, TableDetail, UnknownModel, WardForm,
    display_codes, model_presets,
};
pub use quadrature::gauss_legendre;
pub use swapped::Swapped;
