//! Text form of models: a line that names the model, and one line for each parameter.
//!
//! ```text
//! .model cook-torrance
//! f0 1 0.71 0.29
//! roughness 0.3
//! distribution beckmann
//! ```
//! Numbers are written so that they read back to the same bits. The rest of a file is the caller's
//! business.

use std::fmt;

use super::parameter::ParameterKind;
use super::value::{Model, ParameterError};

/// Error of [`Model::with_text`].
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum ParameterTextError {
    /// The parameter or its values are not valid.
    #[error(transparent)]
    Parameter(#[from] ParameterError),
    /// A value is not a number.
    #[error("{0:?} is not a number")]
    Number(String),
}

impl Model {
    /// Returns the model with a parameter set from its line: values separated by blanks, or
    /// the word of a choice.
    ///
    /// # Errors
    /// Returns [`ParameterTextError`] if a number cannot be parsed or the model rejects the
    /// values.
    pub fn with_text(self, name: &str, values: &str) -> Result<Self, ParameterTextError> {
        let values = values.trim();
        if let Some((parameter, _)) = self.kind().find(name)
            && matches!(parameter.kind, ParameterKind::Choice { .. })
        {
            return Ok(self.choose(name, values)?);
        }
        let values: Result<Vec<f64>, _> = values
            .split_whitespace()
            .map(|word| word.parse().map_err(|_| ParameterTextError::Number(word.to_owned())))
            .collect();
        Ok(self.with(name, &values?)?)
    }
}

impl fmt::Display for Model {
    /// Writes the model's line, then each parameter on its own line.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, ".model {}", self.kind())?;
        for (parameter, values) in self.parameters() {
            write!(f, "{}", parameter.name)?;
            match parameter.word(values) {
                Some(word) => write!(f, " {word}")?,
                None => values.iter().try_for_each(|number| write!(f, " {number}"))?,
            }
            writeln!(f)?;
        }
        Ok(())
    }
}
