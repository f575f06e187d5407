//! Measured materials: tables of reflectance, read from bytes and evaluated for any pair of
//! directions.
//!
//! Independent of files and image formats: callers pass bytes or pixels.

mod angle;
mod csv;
mod goniometer;
mod merl;
mod neural;
mod rgl;
mod sample;
mod scatter;
mod slice;
mod spectrum;
mod tensor;
mod warp;

pub use csv::{CsvError, pairs_from_csv};
pub use goniometer::GoniometerError;
pub use merl::{Merl, MerlError};
pub use neural::{Neural, NeuralError};
pub use rgl::{Rgl, RglError};
pub use sample::{MeasuredSamples, SampleError};
pub use scatter::Scattered;
pub use slice::{ImageSlice, ImageSliceError};
pub use tensor::TensorError;
