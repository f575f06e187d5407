//! Models as text: the line that names one, and one line for each of its parameters.
//!
//! ```text
//! .model cook-torrance
//! f0 1 0.71 0.29
//! roughness 0.3
//! distribution beckmann
//! ```
//! Numbers are written so that they read back to the same bits. What stands around these lines in a file is not known here.

use std::fmt;

use super::{Model, ParameterError, Shape};

/// Why a line gives no parameter of a model.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum ParameterTextError {
    /// A parameter that cannot be.
    #[error(transparent)]
    Parameter(#[from] ParameterError),
    /// What should be a number is none.
    #[error("{0:?} is not a number")]
    Number(String),
}

impl Model {
    /// The same with a parameter as its line gives it: numbers between blanks, or the word of a choice.
    pub fn with_text(self, name: &str, values: &str) -> Result<Self, ParameterTextError> {
        let values = values.trim();
        if let Some((parameter, _)) = self.kind.place(name)
            && matches!(parameter.shape, Shape::Choice { .. })
        {
            return Ok(self.choose(name, values)?);
        }
        let numbers: Result<Vec<f64>, _> = values
            .split_whitespace()
            .map(|word| word.parse().map_err(|_| ParameterTextError::Number(word.to_owned())))
            .collect();
        Ok(self.with(name, &numbers?)?)
    }
}

impl fmt::Display for Model {
    /// The model's line and all parameters, each on a line of its own.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, ".model {}", self.kind)?;
        for (parameter, numbers) in self.parameters() {
            write!(f, "{}", parameter.name)?;
            match parameter.word(numbers) {
                Some(word) => write!(f, " {word}")?,
                None => numbers.iter().try_for_each(|number| write!(f, " {number}"))?,
            }
            writeln!(f)?;
        }
        Ok(())
    }
}
