//! Models as text: the lines of a `.brood` file that hold one.
//!
//! ```text
//! brood 1
//! .model cook-torrance      # comment to the end of the line
//! f0 1 0.71 0.29
//! roughness 0.3
//! distribution beckmann
//! ```
//! Parameters that are not named have their defaults. Numbers are written so that they read back to the same bits.

use std::fmt;
use std::str::FromStr;

use super::kind::UnknownModel;
use super::{Model, ParameterError, Shape};

/// Why a text is no model.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum ModelTextError {
    /// The first line is not that of a file of this version.
    #[error("line 1: a material begins with `brood 1`")]
    Version,
    /// The second line names no model.
    #[error("line {0}: `.model` and a name are missing")]
    NoModel(usize),
    /// A name that no model has.
    #[error("line {0}: {1}")]
    Unknown(usize, UnknownModel),
    /// A parameter that cannot be.
    #[error("line {0}: {1}")]
    Parameter(usize, ParameterError),
    /// What should be a number is none.
    #[error("line {0}: {1:?} is not a number")]
    Number(usize, String),
    /// A parameter is given again.
    #[error("line {0}: {1} stands there twice")]
    Twice(usize, String),
}

impl FromStr for Model {
    type Err = ModelTextError;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        let text = text.trim_start_matches('\u{feff}');
        let mut lines = text
            .lines()
            .map(|line| line.split('#').next().unwrap_or_default().trim())
            .zip(1..)
            .filter(|(line, _)| !line.is_empty());
        let is_head = |line: &str| line.split_whitespace().eq(["brood", "1"]);
        if !lines.next().is_some_and(|(line, _)| is_head(line)) {
            return Err(ModelTextError::Version);
        }
        let (line, number) = lines.next().ok_or(ModelTextError::NoModel(2))?;
        let words: Vec<&str> = line.split_whitespace().collect();
        let &[".model", name] = words.as_slice() else {
            return Err(ModelTextError::NoModel(number));
        };
        let kind = name.parse().map_err(|error| ModelTextError::Unknown(number, error))?;
        let mut model = Self::new(kind);
        let mut given = Vec::new();
        for (line, number) in lines {
            let (name, values) = line.split_once(char::is_whitespace).unwrap_or((line, ""));
            if given.contains(&name) {
                return Err(ModelTextError::Twice(number, name.to_owned()));
            }
            given.push(name);
            model = model.read(name, values.trim(), number)?;
        }
        Ok(model)
    }
}

impl Model {
    fn read(self, name: &str, values: &str, line: usize) -> Result<Self, ModelTextError> {
        let refused = |error| ModelTextError::Parameter(line, error);
        if let Some((parameter, _)) = self.kind.place(name)
            && matches!(parameter.shape, Shape::Choice { .. })
        {
            return self.choose(name, values).map_err(refused);
        }
        let numbers: Result<Vec<f64>, _> = values
            .split_whitespace()
            .map(|word| word.parse().map_err(|_| ModelTextError::Number(line, word.to_owned())))
            .collect();
        self.with(name, &numbers?).map_err(refused)
    }
}

impl fmt::Display for Model {
    /// All parameters, each on a line of its own.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "brood 1\n.model {}", self.kind)?;
        for parameter in self.kind.parameters() {
            let numbers = self.get(parameter.name).expect("it is one of its own");
            write!(f, "{}", parameter.name)?;
            match parameter.shape {
                Shape::Choice { words } => {
                    let word =
                        words.iter().zip(0_u32..).find(|(_, at)| f64::from(*at) >= numbers[0]);
                    write!(f, " {}", word.expect("it is within its range").0)?;
                }
                Shape::Scalar { .. } | Shape::Color { .. } => {
                    for number in numbers {
                        write!(f, " {number}")?;
                    }
                }
            }
            writeln!(f)?;
        }
        Ok(())
    }
}
