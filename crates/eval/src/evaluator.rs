//! The trait of everything that evaluates programs.

use brood_program::Program;
use brood_scene::SampleSet;

/// Why a batch could not be evaluated.
#[derive(Debug, thiserror::Error)]
pub enum EvalError {
    /// The evaluator cannot run such a program; another one can.
    #[error("the evaluator cannot run this batch: {0}")]
    Unsupported(String),
    /// The device failed; trying again elsewhere may help.
    #[error("the device failed: {0}")]
    Device(String),
}

/// Evaluates programs on samples, always in batches.
pub trait Evaluator: Send + Sync {
    /// `cpu`, `gpu` or `reference`.
    fn name(&self) -> &str;

    /// Whether its results are the canonical bits.
    fn is_exact(&self) -> bool;

    /// The reflectance of each program on each sample.
    ///
    /// # Shapes
    /// `out` is made `programs.len() * 3 * set.len()` long: program by program, in each red, green, blue, in each the
    /// samples in order.
    fn eval(
        &self,
        programs: &[&Program],
        set: &SampleSet,
        out: &mut Vec<f32>,
    ) -> Result<(), EvalError>;
}
