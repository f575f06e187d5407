//! The [`Evaluator`] trait and its error.

use std::borrow::Cow;

use brood_program::{Meaning, Program};
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

    /// Computes the reflectance of each program on each sample; of painted materials, the colour.
    ///
    /// # Shapes
    /// `out` is resized to `programs.len() * 3 * set.len()`: one part per program; in each part
    /// red, green and blue; in each channel the samples in order.
    ///
    /// # Errors
    /// Returns [`EvalError::Unsupported`] if the evaluator does not support one of the programs, or
    /// one is painted and the set is not one of points ([`SampleSet::lighting`]),
    /// [`EvalError::Device`] if the device failed.
    fn eval(&self, programs: &[&Program], set: &SampleSet, out: &mut Vec<f32>) -> EvalResult;
}

/// Programs of a batch, in which styles are lowered for the lights of a set.
#[derive(Debug)]
pub struct Lowered<'a> {
    given: &'a [&'a Program],
    /// The lowered styles, in the order of `given`.
    colors: Vec<Program>,
}

impl<'a> Lowered<'a> {
    /// Lowers the styles among the programs.
    ///
    /// # Errors
    /// Returns [`EvalError::Unsupported`] if there is a style and the samples of the set are not
    /// points.
    pub fn of(given: &'a [&'a Program], set: &SampleSet) -> Result<Self, EvalError> {
        let styles = given.iter().filter(|program| is_style(program));
        let lower = |style: &&Program| match set.lighting() {
            Some(lighting) => Ok(style.painted(lighting)),
            None => {
                let reason = "painted materials need samples of points, not of light";
                Err(EvalError::Unsupported(reason.to_owned()))
            }
        };
        Ok(Self { given, colors: styles.map(lower).collect::<Result<_, _>>()? })
    }

    /// Returns the programs in the order in which they were given.
    #[must_use]
    pub fn programs(&self) -> Cow<'_, [&Program]> {
        if self.colors.is_empty() {
            return Cow::Borrowed(self.given);
        }
        let mut colors = self.colors.iter();
        let next = |program: &&'a Program| match is_style(program) {
            true => colors.next().expect("each style has been lowered"),
            false => program,
        };
        Cow::Owned(self.given.iter().map(next).collect())
    }
}

fn is_style(program: &Program) -> bool {
    matches!(program.meaning(), Meaning::Style(_))
}
