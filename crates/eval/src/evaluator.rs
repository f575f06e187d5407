//! The [`Evaluator`] trait and its error.

use brood_program::Program;
use brood_scene::SampleSet;

/// Error of a batch.
#[derive(Debug, thiserror::Error)]
pub enum EvalError {
    /// The evaluator does not support such a program; another evaluator may.
    #[error("the evaluator does not support this batch: {0}")]
    Unsupported(String),
    /// The device failed; a retry on another device may succeed.
    #[error("the device failed: {0}")]
    Device(String),
}

/// Success or failure of a batch.
pub type EvalResult = Result<(), EvalError>;

/// Evaluates programs on samples, always in batches.
pub trait Evaluator: Send + Sync {
    /// Returns the name of the backend: `cpu`, `gpu` or `reference`.
    fn name(&self) -> &str;

    /// True if results are bit-equal to the canonical ones.
    fn is_exact(&self) -> bool;

    /// Computes the reflectance of each program on each sample.
    ///
    /// # Shapes
    /// `out` is resized to `programs.len() * 3 * set.len()`: one part per program; in each part
    /// red, green and blue; in each channel the samples in order.
    ///
    /// # Errors
    /// Returns [`EvalError::Unsupported`] if the evaluator does not support one of the programs,
    /// [`EvalError::Device`] if the device failed.
    fn eval(&self, programs: &[&Program], set: &SampleSet, out: &mut Vec<f32>) -> EvalResult;
}
